// SPDX-License-Identifier: MIT
// Shear law: Coulomb friction, Ft = -mu fn Vt/|Vt| (Bell 2005, eq. 17). At Vt = 0 the law jumps, and any
// force up to mu fn is allowed: there a spring holds, as in eq. 19. A contact that begins sliding pushes with
// full friction at once (eq. 19 has to load its spring first), and its friction follows the velocity, not the
// spring. Sliding that comes to rest, or slower than the spring could make it by handing its energy back, mu
// fn / sqrt(kt m_t), is held by the spring: sliding and holding do not chatter.
#pragma once

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"
#include "granular/contact/static_friction.h"

namespace granular {

struct Coulomb {
  static constexpr bool kHasMemory = true;

  /// On particle 1, N. fn = magnitude of the normal force, N; kt = stiffness of the holding spring, N/m; Vt,
  /// m/s; D, m.
  static Vector3 force(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D) {
    return -friction(c, fn, Vt, kt * D + c.dashpot * Vt);
  }
  /// D once the sub-step is accepted, m: the same force at the Coulomb limit.
  static Vector3 settled(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D) {
    const Vector3 T = kt * D + c.dashpot * Vt;
    if (T.squaredNorm() <= c.mu * fn * c.mu * fn) return D;
    return (friction(c, fn, Vt, T) - c.dashpot * Vt) / kt;
  }
  /// D of a contact that has just begun, m: loaded to the limit if it slides.
  static Vector3 begun(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D) {
    return slides(c, fn, Vt) ? Vector3((c.mu * fn * Vt.normalized() - c.dashpot * Vt) / kt) : D;
  }

 private:
  static bool slides(const ShearConstants& c, double fn, const Vector3& Vt) {
    return Vt.norm() > c.mu * fn * c.slipCompliance;
  }
  static Vector3 friction(const ShearConstants& c, double fn, const Vector3& Vt, const Vector3& T) {
    const bool holds = T.squaredNorm() <= c.mu * fn * c.mu * fn;
    if (!holds && slides(c, fn, Vt)) return c.mu * fn * Vt.normalized();
    return StaticFriction::limited(c.mu * fn, T);
  }
};

}  // namespace granular
