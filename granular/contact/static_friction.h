// SPDX-License-Identifier: MIT
// Shear law: static friction by a virtual spring, Ft = -min(mu fn, kt |D|) D/|D|, D = tangential displacement
// since the contact began (Bell 2005, eq. 19). A dashpot may stand beside the spring: T = kt D + c Vt, Ft =
// -min(mu fn, |T|) T/|T|. D is part of the integrator's state: its rate is Vt, turned along with the contact.
// When a sub-step is accepted the spring gives way to the Coulomb limit, so that D never stores more than
// friction can hold.
#pragma once

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"

namespace granular {

struct StaticFriction {
  static constexpr bool kHasMemory = true;

  /// On particle 1, N. fn = magnitude of the normal force, N; kt = tangential stiffness, N/m; Vt, m/s; D, m.
  /// Whether the contact slid before is no matter here.
  static Vector3 force(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D,
                       bool) {
    return -limited(c.mu * fn, kt * D + c.dashpot * Vt);
  }
  /// Whether friction is at its limit once the sub-step is accepted.
  static bool slides(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D,
                     bool) {
    return (kt * D + c.dashpot * Vt).squaredNorm() > c.mu * fn * c.mu * fn;
  }
  /// D from then on, m: the same force at the limit.
  static Vector3 settled(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D,
                         bool slides) {
    return slides ? Vector3((limited(c.mu * fn, kt * D + c.dashpot * Vt) - c.dashpot * Vt) / kt) : D;
  }

  /// T, or as much of it as the limit allows, N.
  static Vector3 limited(double limit, const Vector3& T) {
    const double size = T.norm();
    return size > limit ? Vector3(limit / size * T) : T;
  }
};

}  // namespace granular
