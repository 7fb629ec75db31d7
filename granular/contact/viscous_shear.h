// SPDX-License-Identifier: MIT
// Shear law: viscous, Ft = -kt Vt (Bell 2005, eq. 16). Not bounded by the normal force.
#pragma once

#include "granular/contact/law_constants.h"

namespace granular {

struct ViscousShear {
  static constexpr bool kHasMemory = false;

  /// On particle 1, N. fn = magnitude of the normal force, N; Vt = tangential velocity of 1 against 2, m/s.
  template <class Real>
  static Vector3Of<Real> force(const ShearConstantsOf<Real>& c, Real, const Vector3Of<Real>& Vt) {
    return Real(-c.viscosity) * Vt;
  }
  /// Of the force over |Vt|, N s/m.
  template <class Real>
  static Real viscosity(const ShearConstantsOf<Real>& c, const Real&, const Vector3Of<Real>&) {
    return c.viscosity;
  }
};

}  // namespace granular
