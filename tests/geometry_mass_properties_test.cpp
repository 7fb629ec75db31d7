// SPDX-License-Identifier: MIT
// Mass properties against closed forms. Tolerances: 1e-12 relative where the mesh is the solid, the square of
// the facet angle where it is inscribed in a round one.
#include "granular/geometry/mass_properties.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "granular/base/random.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(MassProperties, OfABoxAreTheClosedForm) {
  const double rho = 2500.0, a = 0.3, b = 0.7, c = 1.1;
  const MassProperties m = massProperties(makeBox({a, b, c}, 3), rho);
  const double mass = rho * a * b * c;
  EXPECT_NEAR(m.volume, a * b * c, 1e-12 * a * b * c);
  EXPECT_NEAR(m.mass, mass, 1e-12 * mass);
  EXPECT_LT(m.centerOfMass.norm(), 1e-12);
  const Vector3 expected = mass / 12.0 * Vector3(b * b + c * c, a * a + c * c, a * a + b * b);
  EXPECT_LT((m.principalMoments - expected).norm(), 1e-12 * expected.norm());
  EXPECT_EQ(m.principalFrame.orientation.coeffs(), Quaternion::Identity().coeffs());
}

TEST(MassProperties, OfATetrahedronAreTheClosedForm) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const MassProperties m = massProperties(mesh, 6.0);  // mass 1
  EXPECT_NEAR(m.mass, 1.0, 1e-12);
  EXPECT_LT((m.centerOfMass - Vector3::Constant(0.25)).norm(), 1e-12);
  // About the corner: int x^2 = 1/10, int x y = 1/20 (mass 1); shifted to the centre at 1/4: 3/80 and -1/80.
  Matrix3 expected = Matrix3::Constant(1.0 / 80.0);
  expected.diagonal().setConstant(6.0 / 80.0);
  EXPECT_LT((m.inertia - expected).norm(), 1e-12);
}

/// Error of the volume and of the inertia of an inscribed ball.
std::pair<double, double> ballErrors(int subdivisions) {
  const double rho = 1000.0, radius = 0.5;
  const MassProperties m = massProperties(makeIcosphere(radius, subdivisions), rho);
  const double mass = rho * 4.0 / 3.0 * kPi * std::pow(radius, 3);
  return {1.0 - m.mass / mass, 1.0 - m.principalMoments.mean() / (0.4 * mass * radius * radius)};
}

TEST(MassProperties, OfIcospheresConvergeToTheBallWithTheSquareOfTheEdge) {
  const auto [mass3, inertia3] = ballErrors(3);
  const auto [mass4, inertia4] = ballErrors(4);
  EXPECT_NEAR(mass3 / mass4, 4.0, 0.1);
  EXPECT_NEAR(inertia3 / inertia4, 4.0, 0.1);
  EXPECT_LT(inertia4, 0.005);
}

TEST(MassProperties, OfAnIcosphereKeepTheAxes) {
  const MassProperties m = massProperties(makeIcosphere(1.0, 2), 1.0);
  EXPECT_EQ(m.principalFrame.orientation.coeffs(), Quaternion::Identity().coeffs());
}

TEST(MassProperties, OfToriConvergeToTheClosedForm) {
  const double R = 1.0, r = 0.3;
  const double mass = 2.0 * kPi * kPi * R * r * r;
  const double axial = mass * (R * R + 0.75 * r * r), across = mass * (0.5 * R * R + 0.625 * r * r);
  double lastError = 1.0;
  for (int n : {24, 48, 96}) {
    const MassProperties m = massProperties(makeTorus(R, r, 2 * n, n), 1.0);
    const double error = std::max(std::abs(m.principalMoments[2] / axial - 1.0),
                                  std::abs(m.principalMoments[0] / across - 1.0));
    EXPECT_LT(error, 0.3 * lastError) << n;
    lastError = error;
  }
  EXPECT_LT(lastError, 3e-3);
}

TEST(MassProperties, TurnAndMoveWithTheMesh) {
  const TriangleMesh box = makeBox({0.3, 0.7, 1.1});
  const Vector3 moments = massProperties(box, 1000.0).principalMoments;
  Random random(7);
  for (int n = 0; n < 20; ++n) {
    const Pose pose{Vector3(random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(-5, 5)),
                    random.rotation()};
    TriangleMesh placed = box;
    for (Vector3& v : placed.vertices) v = pose.toWorld(v);
    const MassProperties m = massProperties(placed, 1000.0);
    EXPECT_LT((m.centerOfMass - pose.position).norm(), 1e-12);
    const Matrix3 rotation = pose.orientation.toRotationMatrix();
    const Matrix3 expected = rotation * moments.asDiagonal() * rotation.transpose();
    EXPECT_LT((m.inertia - expected).norm(), 1e-12 * moments.norm());
    // The principal frame gives the inertia back, whichever axis it calls first.
    const Matrix3 axes = m.principalFrame.orientation.toRotationMatrix();
    EXPECT_LT((axes * m.principalMoments.asDiagonal() * axes.transpose() - expected).norm(),
              1e-12 * moments.norm());
    EXPECT_NEAR(axes.determinant(), 1.0, 1e-12);
  }
}

TEST(MassProperties, PrincipalFrameTurnsASlightlyTurnedBoxOnlySlightly) {
  const Pose pose{Vector3::Zero(), Quaternion(Eigen::AngleAxisd(0.2, Vector3(1.0, 2.0, -1.0).normalized()))};
  TriangleMesh box = makeBox({0.3, 0.7, 1.1});
  for (Vector3& v : box.vertices) v = pose.toWorld(v);
  EXPECT_NEAR(massProperties(box, 1.0).principalFrame.orientation.angularDistance(pose.orientation), 0.0,
              1e-7);
}

TEST(MassProperties, LoseNoDigitsFarFromTheOrigin) {
  // 1000 sizes away a vertex is rounded to 1e-13 of the size; integrals about the origin would lose six
  // digits more.
  TriangleMesh box = makeBox({0.3, 0.7, 1.1});
  for (Vector3& v : box.vertices) v += Vector3(1000.0, -1000.0, 1000.0);
  const MassProperties m = massProperties(box, 1.0);
  const double expected = 0.3 * 0.7 * 1.1 / 12.0 * (0.7 * 0.7 + 1.1 * 1.1);
  EXPECT_NEAR(m.inertia(0, 0), expected, 1e-11 * expected);
}

TEST(MassProperties, OfAHollowBoxAreTheDifference) {
  TriangleMesh mesh = makeBox({2.0, 2.0, 2.0});
  TriangleMesh hollow = makeBox({1.0, 1.0, 1.0});
  turnInsideOut(hollow);
  append(mesh, hollow);
  EXPECT_NEAR(massProperties(mesh, 1.0).mass, 7.0, 1e-12);
}

TEST(MassProperties, RefuseWhatIsNotASolid) {
  TriangleMesh open = makeBox({1.0, 1.0, 1.0});
  open.triangles.pop_back();
  EXPECT_THROW(massProperties(open, 1.0), std::invalid_argument);
  TriangleMesh inverted = makeBox({1.0, 1.0, 1.0});
  turnInsideOut(inverted);
  EXPECT_THROW(massProperties(inverted, 1.0), std::invalid_argument);
  EXPECT_THROW(massProperties(makeBox({1.0, 1.0, 1.0}), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace granular
