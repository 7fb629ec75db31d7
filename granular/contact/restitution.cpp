// SPDX-License-Identifier: MIT
#include "granular/contact/restitution.h"

#include <array>
#include <cmath>

namespace granular {
namespace {

using Point = std::array<double, 2>;  // x, x'

/// Rate of (x, x') against s where t = s^2: x^alpha has a root at the start of contact, which s smooths away.
Point rate(const Point& p, double s, double alpha, double beta, double D) {
  const double x = std::max(p[0], 0.0);
  const double force = std::pow(x, beta) + D * std::pow(x, alpha) * p[1];
  return {2.0 * s * p[1], -2.0 * s * force};
}

Point rungeKutta4(const Point& p, double s, double ds, double alpha, double beta, double D) {
  const auto at = [&](const Point& k, double f) { return Point{p[0] + f * k[0], p[1] + f * k[1]}; };
  const Point k1 = rate(p, s, alpha, beta, D);
  const Point k2 = rate(at(k1, 0.5 * ds), s + 0.5 * ds, alpha, beta, D);
  const Point k3 = rate(at(k2, 0.5 * ds), s + 0.5 * ds, alpha, beta, D);
  const Point k4 = rate(at(k3, ds), s + ds, alpha, beta, D);
  return {p[0] + ds / 6.0 * (k1[0] + 2.0 * k2[0] + 2.0 * k3[0] + k4[0]),
          p[1] + ds / 6.0 * (k1[1] + 2.0 * k2[1] + 2.0 * k3[1] + k4[1])};
}

/// Whether the contact has ended: the overlap is gone, or (no attraction) the force
/// x^alpha (x^(beta - alpha) + D x') no longer pushes.
bool hasEnded(const Point& p, double alpha, double beta, double D, bool attraction) {
  if (p[1] >= 0.0) return false;
  return p[0] <= 0.0 || (!attraction && std::pow(p[0], beta - alpha) + D * p[1] <= 0.0);
}

}  // namespace

double restitutionOfDamping(double alpha, double beta, double D, bool attraction) {
  constexpr double kStep = 1.0 / 512.0;  // in s; 1e-9 in e for all laws here
  Point p{0.0, 1.0};
  double s = 0.0;
  for (;;) {
    const Point next = rungeKutta4(p, s, kStep, alpha, beta, D);
    if (hasEnded(next, alpha, beta, D, attraction)) break;
    p = next;
    s += kStep;
  }
  double low = 0.0, high = kStep;  // bisect the moment of release within the last step
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const Point q = rungeKutta4(p, s, middle, alpha, beta, D);
    (hasEnded(q, alpha, beta, D, attraction) ? high : low) = middle;
  }
  return -rungeKutta4(p, s, low, alpha, beta, D)[1];
}

double dampingForRestitution(double alpha, double beta, double e, bool attraction) {
  if (e >= 1.0) return 0.0;
  double low = 0.0, high = 1.0;
  while (restitutionOfDamping(alpha, beta, high, attraction) > e) high *= 2.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (restitutionOfDamping(alpha, beta, middle, attraction) > e ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace granular
