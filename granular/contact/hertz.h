// SPDX-License-Identifier: MIT
// What the three Hertz laws share (Bell 2005, eqs. 12-15): the spring kr xi^(3/2), its energy, its contact
// time, and the damping constant that gives a restitution.
#pragma once

#include <cmath>

#include "granular/contact/law_constants.h"
#include "granular/contact/restitution.h"

namespace granular {

/// Base of the Hertz laws; Alpha is the exponent of the overlap in the damper, times 4 (so that it can be a
/// template argument).
template <int AlphaTimesFour>
struct Hertz {
  static constexpr double kAlpha = AlphaTimesFour / 4.0;
  static constexpr bool kByArea = false;
  static constexpr double kStiffnessPower = 0.5;  // tangentStiffness ~ xi^p

  template <class Real>
  static Real elasticForce(const NormalConstantsOf<Real>& c, Real xi) {
    return c.kr * xi * sqrt(xi);
  }
  static double elasticEnergy(const NormalConstants& c, double xi) {
    return 0.4 * c.kr * xi * xi * std::sqrt(xi);
  }
  static double tangentStiffness(const NormalConstants& c, double xi) { return 1.5 * c.kr * std::sqrt(xi); }

  /// With the present energy as that of an impact: v0^2 = xi'^2 + (4/5) (kr/m) xi^(5/2); (kr/m)^4 v0^2.
  template <class Real>
  static Real urgency(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    const Real k2 = c.stiffnessPerMass * c.stiffnessPerMass;
    return k2 * k2 * (xiDot * xiDot + 0.8 * c.stiffnessPerMass * xi * xi * sqrt(xi));
  }

  static double dampingForRestitution(double e, bool attraction) {
    return granular::dampingForRestitution(kAlpha, 1.5, e, attraction);
  }
  static NormalConstants constants(const NormalRequest& request) {
    const double m = request.contact.mass;
    const double kr = request.def.stiffness.value_or(request.contact.hertzStiffness());
    const double kd = hertzDampingConstant(kAlpha, request.damping, kr, m, request.speed);
    return {.kr = kr,
            .kd = request.def.damping.value_or(kd),
            .smallestForce = request.smallestForce(),
            .stiffnessPerMass = kr / m};
  }
};

}  // namespace granular
