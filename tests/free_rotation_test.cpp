// SPDX-License-Identifier: MIT
#include "granular/dynamics/free_rotation.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granular {
namespace {

TEST(FreeRotation, TurnsASphereByItsAngleExactly) {
  const Vector3 w(3.0, -2.0, 1.0), L = 0.4 * w;
  const Vector3 inverse = Vector3::Constant(1.0 / 0.4);
  const Quaternion start(Eigen::AngleAxisd(0.7, Vector3(1.0, 2.0, -1.0).normalized()));
  for (const double t : {1e-6, 0.01, 0.5, 20.0}) {
    const Quaternion expected = Quaternion(Eigen::AngleAxisd(t * w.norm(), w.normalized())) * start;
    EXPECT_LT(freelyTurned(start, L, inverse, t).angularDistance(expected), 1e-14) << t;
  }
}

/// Twice the kinetic energy of a top with this angular momentum.
double twiceEnergy(const Quaternion& q, const Vector3& L, const Vector3& inverse) {
  const Vector3 own = q.conjugate() * L;
  return inverse.dot(own.cwiseAbs2());
}

TEST(FreeRotation, KeepsTheEnergyOfATopWithoutATrend) {
  // Symplectic: energy swings with h^4 about its start, after 100,000 steps as in the first.
  const Vector3 inverse(1.0, 1.0 / 2.0, 1.0 / 3.0), L(1.0, 1.2, -0.7);
  Quaternion q = Quaternion::Identity();
  const double start = twiceEnergy(q, L, inverse), h = 0.05;
  double early = 0.0, late = 0.0;
  for (int i = 0; i < 100000; ++i) {
    q = freelyTurned(q, L, inverse, h);
    const double off = std::abs(twiceEnergy(q, L, inverse) / start - 1.0);
    (i < 1000 ? early : late) = std::max(i < 1000 ? early : late, off);
  }
  EXPECT_LT(early, h * h * h * h);
  EXPECT_LT(late, 1.01 * early);
}

TEST(FreeRotation, IsOfFourthOrderForATop) {
  const Vector3 inverse(1.0, 1.0 / 2.0, 1.0 / 3.0), L(1.0, 1.2, -0.7);
  const auto after = [&](int steps) {
    Quaternion q = Quaternion::Identity();
    for (int i = 0; i < steps; ++i) q = freelyTurned(q, L, inverse, 2.0 / steps);
    return q;
  };
  const Quaternion exact = after(3000);
  EXPECT_NEAR(std::log2(after(20).angularDistance(exact) / after(40).angularDistance(exact)), 4.0, 0.1);
}

}  // namespace
}  // namespace granular
