// SPDX-License-Identifier: MIT
#include "tests/verification/reference_impact.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace granular::verification {
namespace {

// Steps over one contact time. The start of contact, where xi^alpha has a root, costs order: the error falls
// with the power 2 + alpha of the step; at this number every law's restitution is right to 1e-8.
constexpr double kStepsPerContact = 40000.0;

template <std::size_t Size, class Rate>
std::array<double, Size> rungeKutta4(const std::array<double, Size>& y, double h, Rate&& rate) {
  const auto at = [&](const std::array<double, Size>& k, double f) {
    std::array<double, Size> z = y;
    for (std::size_t i = 0; i < Size; ++i) z[i] += f * k[i];
    return z;
  };
  const auto k1 = rate(y), k2 = rate(at(k1, 0.5 * h)), k3 = rate(at(k2, 0.5 * h)), k4 = rate(at(k3, h));
  std::array<double, Size> z = y;
  for (std::size_t i = 0; i < Size; ++i) z[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
  return z;
}

}  // namespace

NormalForce powerLaw(double alpha, double beta, double kr, double kd) {
  return [=](double xi, double xiDot) { return kr * std::pow(xi, beta) + kd * std::pow(xi, alpha) * xiDot; };
}

ReferenceImpact referenceImpact(const NormalForce& force, double mass, double speed, double timeScale,
                                bool attraction) {
  using State = std::array<double, 4>;  // xi, xi', integral of fn, integral of fn xi
  const auto push = [&](const State& y) {
    return attraction || y[1] > 0.0 || y[0] <= 0.0 ? y[0] : force(y[0], y[1]);  // > 0 while the contact lasts
  };
  const auto rate = [&](const State& y) {
    const double fn = force(std::max(y[0], 0.0), y[1]);
    return State{y[1], -fn / mass, fn, fn * y[0]};
  };
  const double h = timeScale / kStepsPerContact;
  State y{0.0, speed, 0.0, 0.0};
  ReferenceImpact result;
  double t = 0.0;
  for (State next = rungeKutta4(y, h, rate); next[1] > 0.0 || push(next) > 0.0;
       next = rungeKutta4(y, h, rate)) {
    y = next;
    t += h;
    result.largestOverlap = std::max(result.largestOverlap, y[0]);
  }
  double low = 0.0, high = h;  // the moment of release within the last step
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (push(rungeKutta4(y, middle, rate)) > 0.0 ? low : high) = middle;
  }
  y = rungeKutta4(y, low, rate);
  result.restitution = -y[1] / speed;
  result.release = t + low;
  result.impulse = y[2];
  result.meanOverlap = y[3] / y[2];
  return result;
}

double referenceRestitution(double alpha, double beta, double D, bool attraction) {
  return referenceImpact(powerLaw(alpha, beta, 1.0, D), 1.0, 1.0, 3.2, attraction).restitution;
}

ObliqueResult referenceOblique(const ObliqueDef& def) {
  using State = std::array<double, 5>;  // xi, xi', v, w, T: force of the spring, kt D
  const double inertia = 0.4 * def.mass * def.radius * def.radius;
  const auto normal = [&](const State& y) { return std::max(0.0, def.normal(std::max(y[0], 0.0), y[1])); };
  const auto rate = [&](const State& y) {
    const double xi = std::max(y[0], 0.0), slip = y[2] + y[3] * (def.radius - xi);
    const double limit = def.friction * normal(y), ft = -std::clamp(y[4], -limit, limit);
    // Pressed deeper, the spring keeps its force; relieved, it keeps its displacement and loses force with
    // kt.
    const double relief = y[1] < 0.0 && xi > 0.0 ? def.stiffnessPower * y[1] / xi * y[4] : 0.0;
    return State{y[1], -normal(y) / def.mass, ft / def.mass, ft * (def.radius - xi) / inertia,
                 def.shearStiffness * std::pow(xi, def.stiffnessPower) * slip + relief};
  };
  const double h = def.timeScale / kStepsPerContact;
  State y{0.0, def.normalSpeed, def.tangentialSpeed, def.spin, 0.0};
  for (;;) {
    y = rungeKutta4(y, h, rate);
    if (y[0] <= 0.0 || (y[1] < 0.0 && normal(y) <= 0.0)) break;
    const double limit = def.friction * normal(y);  // the spring gives way
    y[4] = std::clamp(y[4], -limit, limit);
  }
  return {.normalSpeed = -y[1], .tangentialSpeed = y[2], .spin = y[3]};
}

}  // namespace granular::verification
