// SPDX-License-Identifier: MIT
// Shear law: Coulomb friction, Ft = -mu fn Vt/|Vt| (Bell 2005, eq. 17). At Vt = 0 the law jumps, and any
// force up to mu fn is allowed: there a spring holds, as in eq. 19. A contact that begins fast slides at once
// with full friction (eq. 19 has to load its spring first), and while it slides the spring is kept loaded
// along Vt. Below the speed at which the spring could hand its energy back, mu fn / sqrt(kt m_t), and when Vt
// turns back, the spring takes over. So sliding and holding do not chatter.
#pragma once

#include "granular/base/pose.h"
#include "granular/contact/law_constants.h"
#include "granular/contact/static_friction.h"

namespace granular {

struct Coulomb {
  static constexpr bool kHasMemory = true;

  /// On particle 1, N. fn = magnitude of the normal force, N; kt = stiffness of the holding spring, N/m; Vt,
  /// m/s; D, m; slid = when the last sub-step was accepted, or the contact is new.
  static Vector3 force(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D,
                       bool slid) {
    if (slides(c, fn, kt, Vt, D, slid) && isFast(c, fn, Vt)) return -c.mu * fn * Vt.normalized();
    return StaticFriction::force(c, fn, kt, Vt, D, slid);
  }
  /// Whether it slides once the sub-step is accepted.
  static bool slides(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D,
                     bool slid) {
    const bool goesOn = slid && isFast(c, fn, Vt) && D.dot(Vt) >= 0.0;
    return goesOn || StaticFriction::slides(c, fn, kt, Vt, D, slid);
  }
  /// D from then on, m: at the limit along Vt while it slides.
  static Vector3 settled(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D,
                         bool slides) {
    if (slides && isFast(c, fn, Vt)) return c.mu * fn / kt * Vt.normalized();
    return StaticFriction::settled(c, fn, kt, Vt, D, slides);
  }

 private:
  static bool isFast(const ShearConstants& c, double fn, const Vector3& Vt) {
    return Vt.norm() > c.mu * fn * c.slipCompliance;
  }
};

}  // namespace granular
