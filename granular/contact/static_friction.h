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
  static Vector3 force(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D) {
    return -limited(c.mu * fn, kt * D + c.dashpot * Vt);
  }
  /// D once the sub-step is accepted, m: the same force at the Coulomb limit.
  static Vector3 settled(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D) {
    const Vector3 T = kt * D + c.dashpot * Vt;
    if (T.squaredNorm() <= c.mu * fn * c.mu * fn) return D;
    return (limited(c.mu * fn, T) - c.dashpot * Vt) / kt;
  }

  /// D of a contact that has just begun and slid as far as D, m.
  static Vector3 begun(const ShearConstants&, double, double, const Vector3&, const Vector3& D) { return D; }

  /// T, or as much of it as the limit allows, N.
  static Vector3 limited(double limit, const Vector3& T) {
    const double size = T.norm();
    return size > limit ? Vector3(limit / size * T) : T;
  }
};

}  // namespace granular
