// SPDX-License-Identifier: MIT
// Shear law: Coulomb friction, Ft = -mu fn Vt/|Vt| (Bell 2005, eq. 17). At Vt = 0 the law jumps, and any
// force up to mu fn is allowed: there a spring holds, as in eq. 19. It takes over below the speed at which it
// could hand its energy back, mu fn / sqrt(kt m_t), so that sliding and holding do not chatter; while sliding
// it is kept loaded to the limit.
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
    return slides(c, fn, Vt) ? Vector3(-c.mu * fn * Vt.normalized())
                             : StaticFriction::force(c, fn, kt, Vt, D);
  }
  /// D once the sub-step is accepted, m.
  static Vector3 settled(const ShearConstants& c, double fn, double kt, const Vector3& Vt, const Vector3& D) {
    return slides(c, fn, Vt) ? Vector3(c.mu * fn / kt * Vt.normalized())
                             : StaticFriction::settled(c, fn, kt, Vt, D);
  }

 private:
  static bool slides(const ShearConstants& c, double fn, const Vector3& Vt) {
    return Vt.norm() > c.mu * fn * c.slipCompliance;
  }
};

}  // namespace granular
