// SPDX-License-Identifier: MIT
// Shear law: regularised Coulomb friction (Bell 2005, eq. 18), Ft = -min(mu fn, kt |Vt|) Vt/|Vt|. The paper's
// choice for grains. It needs no memory, and holds a resting load only by creeping at |Vt| = load / kt.
#pragma once

#include <algorithm>

namespace granular {

struct RegularisedCoulomb {
  double mu = 0.0;  ///< friction coefficient
  double kt = 0.0;  ///< viscosity, N s/m; not the stiffness that eq. 19 calls by the same letter

  /// Ft = -factor * Vt. fn = magnitude of the normal force, N; speed = |Vt|, m/s. N s/m, finite for speed 0.
  double factor(double fn, double speed) const { return mu * fn < kt * speed ? mu * fn / speed : kt; }
};

}  // namespace granular
