// SPDX-License-Identifier: MIT
// Shear law: Coulomb friction, Ft = -mu fn Vt/|Vt| (Bell 2005, eq. 17). At Vt = 0 the law jumps, and any
// force up to mu fn is allowed: there a spring holds, as in eq. 19. A contact that begins fast slides at once
// with full friction (eq. 19 has to load its spring first), and while it slides the spring is kept loaded
// along Vt. Below the speed at which the spring could hand its energy back, mu fn / sqrt(kt m_t), and when Vt
// turns back, the spring takes over. So sliding and holding do not chatter.
#pragma once

#include "granular/contact/law_constants.h"
#include "granular/contact/static_friction.h"

namespace granular {

struct Coulomb {
  static constexpr bool kHasMemory = true;

  /// On particle 1, N. fn = magnitude of the normal force, N; kt = stiffness of the holding spring, N/m; Vt,
  /// m/s; D, m; slid = when the last sub-step was accepted, or the contact is new.
  template <class Real>
  static Vector3Of<Real> force(const ShearConstantsOf<Real>& c, const Real& fn, const Real& kt,
                               const Vector3Of<Real>& Vt, const Vector3Of<Real>& D,
                               const MaskOf<Real>& slid) {
    const Vector3Of<Real> sliding = Real(-c.mu * fn / sqrt(Vt.squaredNorm())) * Vt;
    return select<Real>(slides(c, fn, kt, Vt, D, slid) && isFast(c, fn, Vt), sliding,
                        StaticFriction::force(c, fn, kt, Vt, D, slid));
  }
  /// Whether it slides once the sub-step is accepted.
  template <class Real>
  static MaskOf<Real> slides(const ShearConstantsOf<Real>& c, const Real& fn, const Real& kt,
                             const Vector3Of<Real>& Vt, const Vector3Of<Real>& D, const MaskOf<Real>& slid) {
    const MaskOf<Real> goesOn = slid && isFast(c, fn, Vt) && D.dot(Vt) >= Real(0.0);
    return goesOn || StaticFriction::slides(c, fn, kt, Vt, D, slid);
  }
  /// D from then on, m: at the limit along Vt while it slides.
  template <class Real>
  static Vector3Of<Real> settled(const ShearConstantsOf<Real>& c, const Real& fn, const Real& kt,
                                 const Vector3Of<Real>& Vt, const Vector3Of<Real>& D,
                                 const MaskOf<Real>& slides) {
    const Vector3Of<Real> sliding = Real(c.mu * fn / kt / sqrt(Vt.squaredNorm())) * Vt;
    return select<Real>(slides && isFast(c, fn, Vt), sliding,
                        StaticFriction::settled(c, fn, kt, Vt, D, slides));
  }

 private:
  template <class Real>
  static MaskOf<Real> isFast(const ShearConstantsOf<Real>& c, const Real& fn, const Vector3Of<Real>& Vt) {
    return sqrt(Vt.squaredNorm()) > c.mu * fn * c.slipCompliance;
  }
};

}  // namespace granular
