// SPDX-License-Identifier: MIT
// Normal law: damped linear spring, alpha = 0, beta = 1 (Bell 2005, eqs. 6-8): the same restitution and the
// same contact time at every speed.
//
// Differs from the paper: eqs. 9-10 hold only where the damper may pull at the end of the contact. Dry grains
// let go when the force reaches zero, after the time tau(z) / w0 with restitution exp(-z tau), z = kd / (2
// sqrt(m kr)); kr and kd are worked out from that, so that the e and t_c asked for are those obtained. With
// attraction, eqs. 9-10. Test: Verification 1.linear-*.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/contact/law_constants.h"

namespace granular {

struct LinearSpring {
  static constexpr double kLargestDamping = 0.9;  // z beyond which the contact time counts as no longer
  static constexpr bool kByArea = false;
  static constexpr double kStiffnessPower = 0.0;  // tangentStiffness ~ xi^p

  /// Magnitude of the normal force, N, > 0 pushes apart. xi = overlap, m, > 0; xiDot = overlap rate, m/s.
  template <class Real>
  static Real force(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    return max(c.smallestForce, c.kr * xi + c.kd * xiDot);
  }
  /// Growth of the force with the overlap rate, N s/m.
  template <class Real>
  static Real damping(const NormalConstantsOf<Real>& c, Real) {
    return c.kd;
  }
  template <class Real>
  static Real elasticForce(const NormalConstantsOf<Real>& c, Real xi) {
    return c.kr * xi;
  }
  static double elasticEnergy(const NormalConstants& c, double xi) { return 0.5 * c.kr * xi * xi; }
  template <class Real>
  static Real tangentStiffness(const NormalConstantsOf<Real>& c, const Real&) {
    return c.kr;
  }
  /// The constant that urgency() reads.
  template <class Real>
  static Real& urgencyConstant(NormalConstantsOf<Real>& c) {
    return c.impactRate;
  }
  template <class Real>
  static Real urgency(const NormalConstantsOf<Real>& c, Real, Real) {
    return urgencyOfRate(c.impactRate);
  }

  /// Dimensionless contact time w0 t until the force has fallen to zero (attraction: until the overlap has).
  static double contactAngle(double z, bool attraction) {
    if (z < 1.0) {
      const double s = std::sqrt(1.0 - z * z);
      return (std::numbers::pi - (attraction ? 0.0 : std::atan2(2.0 * z * s, 1.0 - 2.0 * z * z))) / s;
    }
    if (z == 1.0) return 2.0;
    const double s = std::sqrt(z * z - 1.0);
    return std::log((z + s) / (z - s)) / s;
  }

  /// Where a given damping decides z: one by one, a library's functions.
  static double contactAngleOf(double z) { return contactAngle(std::min(z, kLargestDamping), false); }
  template <class Real>
  static Real contactAngleOf(const Real& z) {
    return Real([&](auto lane) { return contactAngleOf(double{z[lane]}); });
  }

  /// z for a restitution: e = exp(-z tau(z)), by bisection. With attraction z < 1 (eq. 9 over eq. 10).
  static double dampingForRestitution(double e, bool attraction) {
    if (e >= 1.0) return 0.0;
    if (attraction) return -std::log(e) / std::hypot(std::log(e), std::numbers::pi);
    double low = 0.0, high = 1.0;
    const auto restitution = [](double z) { return std::exp(-z * contactAngle(z, false)); };
    while (restitution(high) > e) high *= 2.0;
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (low + high);
      (restitution(middle) > e ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }

  template <class Real>
  static NormalConstantsOf<Real> constants(const NormalRequestOf<Real>& request) {
    const NormalLawDef& def = request.def;
    const Real m = request.contact.mass;
    const double z = request.damping;
    const Real time = def.contactTime
                          ? Real(*def.contactTime)
                          : hertzContactTime<Real>(request.contact.hertzStiffness(), m, request.speed);
    const Real frequency = contactAngle(z, def.attraction) / time;
    const Real kr = def.stiffness ? Real(*def.stiffness) : Real(m * frequency * frequency);
    const Real kd = def.damping ? Real(*def.damping) : Real(2.0 * z * sqrt(m * kr));
    const Real angle = def.damping ? contactAngleOf(Real(0.5 * kd / sqrt(m * kr)))
                                   : Real(contactAngle(std::min(z, kLargestDamping), false));
    const Real contactTime = angle / sqrt(kr / m);
    return {.kr = kr,
            .kd = kd,
            .smallestForce = request.smallestForce(),
            .stiffnessPerMass = kr / m,
            .impactRate = 1.0 / contactTime};
  }
};

}  // namespace granular
