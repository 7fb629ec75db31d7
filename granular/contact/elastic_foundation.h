// SPDX-License-Identifier: MIT
// Normal law for contacts of bodies: an elastic foundation (Johnson, Contact Mechanics 1985, sec. 4.3), as
// stiff as the area that its particles stand for (against an exact surface: pressed_patch.h), with a dashpot
// proportional to the spring force (after Hunt & Crossley 1975): F = kr A xi (1 + a xi').
//
// Then m v dv = -k g(x) (1 + a v) dx whatever k and g are, so that the rebound speed follows from the impact
// speed and a alone: s - ln(1 + s) = -e s - ln(1 - e s) with s = a v. Mass, stiffness, area and the number of
// touching particles drop out: a covered body bounces the same however densely it is covered. Differs from
// the paper: there every particle pushes with its own Hertz law (sec. 5 names the consequence). Test:
// Verification covering.*.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/contact/law_constants.h"

namespace granular {

struct ElasticFoundation {
  static constexpr bool kByArea = true;
  static constexpr double kStiffnessPower = 0.0;  // tangentStiffness ~ xi^p

  /// Pressure, N/m^2 of area. xi = overlap, m, > 0; xiDot = overlap rate, m/s.
  template <class Real>
  static Real force(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    return max(c.smallestForce, c.kr * xi * (1.0 + c.kd * xiDot));
  }
  /// Growth of the pressure with the overlap rate, N s/m^3.
  template <class Real>
  static Real damping(const NormalConstantsOf<Real>& c, Real xi) {
    return c.kr * c.kd * xi;
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
  template <class Real>
  static Real urgency(const NormalConstantsOf<Real>& c, Real, Real) {
    return urgencyOfRate(c.impactRate);
  }

  /// s = a v for a restitution, by bisection on s in (0, 1/e).
  static double dampingForRestitution(double e, bool) {
    if (e >= 1.0) return 0.0;
    double low = 0.0, high = 1.0 / e;  // the separation speed stays below 1/a
    for (int i = 0; i < 100; ++i) {
      const double s = 0.5 * (low + high);
      // Series where both sides would cancel: (s^2/2)(1 - e^2) - (s^3/3)(1 + e^3).
      const double approach = s < 1e-4 ? s * s / 2.0 - s * s * s / 3.0 : s - std::log1p(s);
      const double u = e * s;
      const double departure = u < 1e-4 ? u * u / 2.0 + u * u * u / 3.0 : -u - std::log1p(-u);
      (approach > departure ? low : high) = s;
    }
    return 0.5 * (low + high);
  }

  static NormalConstants constants(const NormalRequest& request) {
    const double kr = request.def.stiffness.value_or(request.contact.modulus / request.bodyLength);
    // Everything that can touch at once acts on the body: the shortest time that a contact of it can last.
    const double frequency = std::sqrt(kr * request.bodyArea / request.contact.mass);
    return {.kr = kr,
            .kd = request.def.damping.value_or(request.damping / request.speed),
            .smallestForce = request.smallestForce(),
            .stiffnessPerMass = kr * request.bodyArea / request.contact.mass,
            .impactRate = frequency / std::numbers::pi};
  }
};

}  // namespace granular
