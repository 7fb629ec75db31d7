// SPDX-License-Identifier: MIT
// Normal law: Hertz with viscoelastic damping, alpha = 1/2, beta = 3/2 (Bell 2005, eqs. 6-7 and 12). The
// default: restitution falls with impact speed as experiments do, 1 - e_n ~ v^(1/5).
#pragma once

#include <algorithm>
#include <cmath>

namespace granular {

struct HertzViscoelastic {
  double kr = 0.0;  ///< N/m^(3/2)
  double kd = 0.0;  ///< N s/m^(3/2)

  /// Magnitude of the normal force, N, pushing apart; never < 0: dry grains do not pull.
  /// xi = overlap, m, > 0; xiDot = overlap rate, m/s, > 0 while the particles approach.
  double force(double xi, double xiDot) const {
    return std::max(0.0, std::sqrt(xi) * (kr * xi + kd * xiDot));
  }
  /// The part of it that a spring without damping would give, N.
  double elasticForce(double xi) const { return kr * xi * std::sqrt(xi); }
  /// Energy stored at overlap xi, J: the integral of elasticForce.
  double elasticEnergy(double xi) const { return 0.4 * kr * xi * xi * std::sqrt(xi); }
};

/// Duration of an elastic Hertz impact at speed v, s: 3.218065 (m^2 / (kr^2 v))^(1/5) (Landau & Lifshitz,
/// Theory of Elasticity, sec. 9). mass = m_eff, kg.
inline double hertzContactTime(double kr, double mass, double v) {
  constexpr double kHertzTime = 3.2180653;
  return kHertzTime * std::pow(mass * mass / (kr * kr * v), 0.2);
}

}  // namespace granular
