// SPDX-License-Identifier: MIT
// Shear law: regularised Coulomb friction, Ft = -min(mu fn, kt |Vt|) Vt/|Vt| (Bell 2005, eq. 18). The paper's
// choice for grains. It needs no memory, and holds a resting load only by creeping at |Vt| = load / kt.
#pragma once

#include "granular/contact/law_constants.h"

namespace granular {

struct RegularisedCoulomb {
  static constexpr bool kHasMemory = false;

  /// On particle 1, N. fn = magnitude of the normal force, N; Vt = tangential velocity of 1 against 2, m/s.
  template <class Real>
  static Vector3Of<Real> force(const ShearConstantsOf<Real>& c, Real fn, const Vector3Of<Real>& Vt) {
    return Real(-viscosity(c, fn, Vt)) * Vt;
  }
  /// Of the force over |Vt|, N s/m.
  template <class Real>
  static Real viscosity(const ShearConstantsOf<Real>& c, const Real& fn, const Vector3Of<Real>& Vt) {
    const Real speed = sqrt(Vt.squaredNorm()), limit = c.mu * fn;
    const Real kt = c.viscosity;
    return select(limit < kt * speed, Real(limit / speed), kt);
  }
};

}  // namespace granular
