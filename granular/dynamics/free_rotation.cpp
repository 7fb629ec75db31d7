// SPDX-License-Identifier: MIT
#include "granular/dynamics/free_rotation.h"

#include <cmath>

namespace granular {
namespace {

struct HalfTurn {
  double cosine, sineOverAngle;
};

/// cos(a) and sin(a) / a of a half angle by its square. Small ones, which are the rule, by the series to
/// a^12: what is left out is below 1e-24. Factors in place of divisors: every grain is turned in every
/// sub-step.
HalfTurn halfTurn(double squared) {
  const double x = squared;
  if (x > 0.01) {
    const double angle = std::sqrt(x);
    return {std::cos(angle), std::sin(angle) / angle};
  }
  constexpr auto over = [](double n) { return 1.0 / n; };
  return {
      1 - x * (over(2) - x * (over(24) - x * (over(720) - x * (over(40320) -
                                                               x * (over(3628800) - x * over(479001600)))))),
      1 - x * (over(6) -
               x * (over(120) -
                    x * (over(5040) - x * (over(362880) - x * (over(39916800) - x * over(6227020800))))))};
}

/// A top as its rotations about its own axes see it.
struct Top {
  Quaternion orientation;
  Vector3 angularMomentum;  // from the body's frame
  const Vector3& inverseInertia;

  /// What L_axis^2 / (2 I_axis) alone would do for t seconds.
  void turn(int axis, double t) {
    const double half = 0.5 * t * angularMomentum[axis] * inverseInertia[axis];
    const auto [c, sineOverAngle] = halfTurn(half * half);
    const double s = half * sineOverAngle;
    double &Lj = angularMomentum[(axis + 1) % 3], &Lk = angularMomentum[(axis + 2) % 3];
    const double cosine = c * c - s * s, sine = 2.0 * s * c, before = Lj;
    Lj = cosine * before + sine * Lk;
    Lk = cosine * Lk - sine * before;
    Quaternion turn(c, 0.0, 0.0, 0.0);
    turn.vec()[axis] = s;
    orientation = orientation * turn;
  }
  /// Second order.
  void turnAboutAll(double t) {
    turn(0, 0.5 * t);
    turn(1, 0.5 * t);
    turn(2, t);
    turn(1, 0.5 * t);
    turn(0, 0.5 * t);
  }
};

}  // namespace

Quaternion turnBy(const Vector3& angle) {
  const HalfTurn half = halfTurn(0.25 * angle.squaredNorm());
  const Vector3 v = 0.5 * half.sineOverAngle * angle;
  return {half.cosine, v.x(), v.y(), v.z()};
}

Quaternion freelyTurned(const Quaternion& orientation, const Vector3& angularMomentum,
                        const Vector3& inverseInertia, double t) {
  if (inverseInertia.minCoeff() == inverseInertia.maxCoeff()) {
    return (turnBy(t * inverseInertia.x() * angularMomentum) * orientation).normalized();
  }
  static const double kOuter = 1.0 / (2.0 - std::cbrt(2.0)), kInner = 1.0 - 2.0 * kOuter;
  Top top{orientation, orientation.conjugate() * angularMomentum, inverseInertia};
  top.turnAboutAll(kOuter * t);
  top.turnAboutAll(kInner * t);
  top.turnAboutAll(kOuter * t);
  return top.orientation.normalized();
}

}  // namespace granular
