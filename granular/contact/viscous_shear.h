// SPDX-License-Identifier: MIT
// Shear law: viscous, Ft = -kt Vt (Bell 2005, eq. 16). Not bounded by the normal force.
#pragma once

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"

namespace granular {

struct ViscousShear {
  static constexpr bool kHasMemory = false;

  /// On particle 1, N. fn = magnitude of the normal force, N; Vt = tangential velocity of 1 against 2, m/s.
  static Vector3 force(const ShearConstants& c, double, const Vector3& Vt) { return -c.viscosity * Vt; }
};

}  // namespace granular
