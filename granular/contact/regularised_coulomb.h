// SPDX-License-Identifier: MIT
// Shear law: regularised Coulomb friction, Ft = -min(mu fn, kt |Vt|) Vt/|Vt| (Bell 2005, eq. 18). The paper's
// choice for grains. It needs no memory, and holds a resting load only by creeping at |Vt| = load / kt.
#pragma once

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"

namespace granular {

struct RegularisedCoulomb {
  static constexpr bool kHasMemory = false;

  /// On particle 1, N. fn = magnitude of the normal force, N; Vt = tangential velocity of 1 against 2, m/s.
  static Vector3 force(const ShearConstants& c, double fn, const Vector3& Vt) {
    const double speed = Vt.norm();
    const double kt = c.viscosity;
    return c.mu * fn < kt * speed ? Vector3(-c.mu * fn / speed * Vt) : Vector3(-kt * Vt);
  }
};

}  // namespace granular
