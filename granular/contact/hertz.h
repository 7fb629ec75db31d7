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
  static_assert(AlphaTimesFour >= 0 && AlphaTimesFour <= 2);
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
  template <class Real>
  static Real tangentStiffness(const NormalConstantsOf<Real>& c, const Real& xi) {
    return 1.5 * c.kr * sqrt(xi);
  }

  /// The constant that urgency() reads.
  template <class Real>
  static Real& urgencyConstant(NormalConstantsOf<Real>& c) {
    return c.stiffnessPerMass;
  }
  /// With the present energy as that of an impact: v0^2 = xi'^2 + (4/5) (kr/m) xi^(5/2); (kr/m)^4 v0^2.
  template <class Real>
  static Real urgency(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    const Real k2 = c.stiffnessPerMass * c.stiffnessPerMass;
    return k2 * k2 * (xiDot * xiDot + 0.8 * c.stiffnessPerMass * xi * xi * sqrt(xi));
  }

  static double dampingForRestitution(double e, bool attraction) {
    return granular::dampingForRestitution(kAlpha, 1.5, e, attraction);
  }
  template <class Real>
  static NormalConstantsOf<Real> constants(const NormalRequestOf<Real>& request) {
    const Real m = request.contact.mass;
    const Real kr = request.def.stiffness ? Real(*request.def.stiffness) : request.contact.hertzStiffness();
    const double v = request.speed;
    // One over the root of the depth (m v^2/kr)^(2/5) of an impact at v; one root serves all.
    const Real r = inverseFifthRoot(Real(m * (v * v) / kr));
    return {.kr = kr,
            .kd = request.def.damping ? Real(*request.def.damping)
                                      : dampingConstant(request.damping, kr, m, v, r),
            .smallestForce = request.smallestForce(),
            .stiffnessPerMass = kr / m,
            .impactRate = r * r * (v / kHertzTime)};
  }

  /// kd from the dimensionless damping D: D m (kr/m)^(2/5 (alpha + 1)) v^((1 - 4 alpha)/5); v = the speed at
  /// which the restitution shall hold, m/s; r = (m v^2/kr)^(-1/5).
  template <class Real>
  static Real dampingConstant(double D, const Real& kr, const Real& m, double v, const Real& r) {
    if constexpr (AlphaTimesFour == 1) return D * sqrt(kr * m);
    return D * v * m * (AlphaTimesFour == 0 ? r * r : r * r * r);
  }
};

}  // namespace granular
