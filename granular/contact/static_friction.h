// SPDX-License-Identifier: MIT
// Shear law: static friction by a virtual spring, Ft = -min(mu fn, kt |D|) D/|D|, D = tangential displacement
// since the contact began (Bell 2005, eq. 19). A dashpot may stand beside the spring: T = kt D + c Vt, Ft =
// -min(mu fn, |T|) T/|T|. D is part of the integrator's state: its rate is Vt, turned along with the contact.
// When a sub-step is accepted the spring gives way to the Coulomb limit, so that D never stores more than
// friction can hold.
#pragma once

#include "granular/contact/law_constants.h"

namespace granular {

struct StaticFriction {
  static constexpr bool kHasMemory = true;

  /// On particle 1, N. fn = magnitude of the normal force, N; kt = tangential stiffness, N/m; Vt, m/s; D, m.
  /// Whether the contact slid before is no matter here.
  template <class Real>
  static Vector3Of<Real> force(const ShearConstantsOf<Real>& c, const Real& fn, const Real& kt,
                               const Vector3Of<Real>& Vt, const Vector3Of<Real>& D, const MaskOf<Real>&) {
    return Real(-1.0) * limited<Real>(c.mu * fn, kt * D + c.dashpot * Vt);
  }
  /// Whether friction is at its limit once the sub-step is accepted.
  template <class Real>
  static MaskOf<Real> slides(const ShearConstantsOf<Real>& c, const Real& fn, const Real& kt,
                             const Vector3Of<Real>& Vt, const Vector3Of<Real>& D, const MaskOf<Real>&) {
    const Vector3Of<Real> T = kt * D + c.dashpot * Vt;
    return T.squaredNorm() > c.mu * fn * c.mu * fn;
  }
  /// D from then on, m: the same force at the limit, of which the dashpot is given nothing that goes along
  /// with it. Were T cut down to the limit, dashpot and all, as other codes do, D would be -c Vt/kt or so in
  /// fast sliding: energy from nowhere, more of it the faster. Test: SlidingCubes.EnergyIsAccountedFor.
  template <class Real>
  static Vector3Of<Real> settled(const ShearConstantsOf<Real>& c, const Real& fn, const Real& kt,
                                 const Vector3Of<Real>& Vt, const Vector3Of<Real>& D,
                                 const MaskOf<Real>& slides) {
    const Vector3Of<Real> T = kt * D + c.dashpot * Vt;
    const Vector3Of<Real> direction = T / Real(sqrt(T.squaredNorm()));
    const Real along = max(Real(0.0), Real(c.dashpot * Vt.dot(direction)));
    const Vector3Of<Real> atLimit = (Real(c.mu * fn + along) * direction - c.dashpot * Vt) / kt;
    return select<Real>(slides, atLimit, D);
  }

  /// T, or as much of it as the limit allows, N.
  template <class Real>
  static Vector3Of<Real> limited(const Real& limit, const Vector3Of<Real>& T) {
    const Real size = sqrt(T.squaredNorm());
    return select(size > limit, Real(limit / size), Real(1.0)) * T;
  }
};

}  // namespace granular
