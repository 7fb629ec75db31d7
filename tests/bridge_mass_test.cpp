// SPDX-License-Identifier: MIT
// Where covered bodies have their mass: closed forms of the shapes, and motion of bodies whose centre of mass
// is not where their owner drew the origin.
#include <cmath>
#include <numbers>

#include "bridge_fixture.h"
#include "bullet_bridge/pose_algebra.h"

namespace bridge_test {
namespace {

using bullet_bridge::MassSource;
using bullet_bridge::shapeMass;
using granular::MassProperties;

constexpr double kPi = std::numbers::pi;

/// Against the polyhedron of 512 sides, whose moments are short by some (2 pi / 512)^2.
void expectAsItsFineMesh(const btCollisionShape& shape) {
  SCOPED_TRACE(shape.getName());
  const double mass = 2.5;
  const MassProperties exact = shapeMass(shape, mass);
  const MassProperties mesh =
      bullet_bridge::surfaceMass(bullet_bridge::shapeSurface(shape, {.segments = 512}), mass);
  EXPECT_DOUBLE_EQ(exact.mass, mass);
  EXPECT_NEAR(exact.volume / mesh.volume, 1.0, 5e-4);
  EXPECT_LT((exact.centerOfMass - mesh.centerOfMass).norm(), 2e-4);
  EXPECT_LT((exact.inertia - mesh.inertia).norm() / exact.inertia.norm(), 1e-3);
}

TEST(ShapeMass, OfRoundShapesIsThatOfTheirFineMesh) {
  expectAsItsFineMesh(btSphereShape(scalar(0.5)));
  expectAsItsFineMesh(btCapsuleShapeX(scalar(0.25), scalar(1)));
  expectAsItsFineMesh(btCapsuleShape(scalar(0.25), scalar(1)));
  expectAsItsFineMesh(btCylinderShapeX(vec(0.5, 0.25, 0.25)));
  expectAsItsFineMesh(btCylinderShapeZ(vec(0.25, 0.25, 0.5)));
  expectAsItsFineMesh(btConeShape(scalar(0.25), scalar(1)));
  expectAsItsFineMesh(btConeShapeZ(scalar(0.25), scalar(1)));
}

TEST(ShapeMass, OfABoxIsItsClosedForm) {
  const MassProperties box = shapeMass(btBoxShape(vec(0.5, 1, 1.5)), 12.0);
  EXPECT_TRUE(box.principalMoments.isApprox(Vector3(4.0 + 9.0, 1.0 + 9.0, 1.0 + 4.0), 20 * kBulletRounding));
  EXPECT_NEAR(box.volume, 6.0, 1e-5);
}

TEST(ShapeMass, OfAHullIsThatOfItsTetrahedron) {
  btConvexHullShape hull;
  for (const btVector3& p : {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)}) hull.addPoint(p);
  hull.setMargin(scalar(0.2));
  const MassProperties solid = shapeMass(hull, 1.0);
  EXPECT_LT((solid.centerOfMass - Vector3::Constant(0.25)).norm(), 1e-6);
  EXPECT_NEAR(solid.volume, 1.0 / 6.0, 1e-7);
  EXPECT_NEAR(solid.inertia(0, 0), 3.0 / 40.0, 1e-6);  // int x^2 = 1/60 of volume 1/6, less 1/16
  EXPECT_NEAR(solid.inertia(0, 1), 1.0 / 80.0, 1e-6);  // int x y = 1/120 of volume 1/6
}

/// Two unit cubes 3 m apart, one turned by 45 degrees about the line between them, within a turned compound.
TEST(ShapeMass, OfACompoundAddsItsChildrenByTheParallelAxisTheorem) {
  btBoxShape cube(vec(0.5, 0.5, 0.5));
  btCompoundShape inner;
  inner.addChildShape(at(3, 0, 0), &cube);
  btCompoundShape outer;
  outer.addChildShape(btTransform(btQuaternion(btVector3(1, 0, 0), scalar(kPi / 4)), btVector3(0, 0, 0)),
                      &inner);
  outer.addChildShape(at(0, 0, 0), &cube);
  const MassProperties solid = shapeMass(outer, 2.0);
  EXPECT_LT((solid.centerOfMass - Vector3(1.5, 0, 0)).norm(), 1e-6);
  EXPECT_NEAR(solid.inertia(0, 0), 2.0 / 6.0, 1e-5);
  EXPECT_NEAR(solid.inertia(1, 1), 2.0 / 6.0 + 2.0 * 2.25, 1e-5);
  EXPECT_NEAR(solid.inertia(2, 2), 2.0 / 6.0 + 2.0 * 2.25, 1e-5);
}

TEST(ShapeMass, OfAUniformlyScaledShapeGrowsWithTheSquareOfItsSize) {
  btConeShape cone(scalar(0.25), scalar(1));
  const MassProperties small = shapeMass(cone, 1.0);
  const MassProperties large = shapeMass(btUniformScalingShape(&cone, 3), 1.0);
  EXPECT_TRUE(large.inertia.isApprox(9.0 * small.inertia, 10 * kBulletRounding));
  EXPECT_TRUE(large.centerOfMass.isApprox(3.0 * small.centerOfMass, 10 * kBulletRounding));
}

TEST(ShapeMass, RefusesAShapeThatEnclosesNothing) {
  EXPECT_THROW(shapeMass(btStaticPlaneShape(vec(0, 1, 0), 0), 1.0), std::invalid_argument);
}

/// A box whose middle is at `offset` in the body's frame, turned by `turn` in it.
btRigidBody& addOffsetBox(SandScene& scene, double mass, const Vector3& half, const btTransform& offset,
                          const btTransform& pose) {
  auto& compound = scene.shape<btCompoundShape>();
  compound.addChildShape(offset, &scene.box(half.x(), half.y(), half.z()));
  return scene.body(mass, compound, pose);
}

TEST(MassFrame, IsAtTheSolidsCentreAlongItsPrincipalAxes) {
  SandScene scene;
  const btTransform offset(btQuaternion(btVector3(0, 0, 1), scalar(0.3)), vec(0.2, 0.1, 0));
  btRigidBody& body = addOffsetBox(scene, 1, {0.1, 0.2, 0.3}, offset, at(0, 0, 0));
  scene.world->coverBody(body, {.particleRadius = 0.05});
  const granular::Pose frame = scene.world->massFrameOf(body);
  EXPECT_LT((frame.position - Vector3(0.2, 0.1, 0)).norm(), 1e-6);
  const Vector3 axis = frame.orientation * Vector3::UnitX();
  EXPECT_LT((axis - Vector3(std::cos(0.3), std::sin(0.3), 0)).norm(), 1e-5);
}

TEST(MassFrame, IsTheBodysOwnIfTheUserSaysSo) {
  SandScene scene;
  btRigidBody& body = addOffsetBox(scene, 1, {0.1, 0.2, 0.3}, at(0.2, 0, 0), at(0, 0, 0));
  scene.world->coverBody(body, {.particleRadius = 0.05, .mass = MassSource::Body});
  EXPECT_TRUE(scene.world->massFrameOf(body).position.isZero(0.0));
}

TEST(MassFrame, LeavesWhatBulletHasExactAlone) {
  SandScene scene;
  btRigidBody& box = scene.body(3, scene.box(0.1, 0.2, 0.3), at(0, 0, 0));
  btRigidBody& ball = scene.body(3, scene.sphere(0.1), at(1, 0, 0));
  for (btRigidBody* body : {&box, &ball}) {
    scene.world->coverBody(*body, {.particleRadius = 0.02});
    EXPECT_TRUE(scene.world->massFrameOf(*body).position.isZero(0.0));
  }
}

TEST(MassFrame, LeavesABodyAtRestWhereItIsBitForBit) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  const btTransform pose(btQuaternion(btVector3(1, 2, 3).normalized(), scalar(0.7)), vec(1, 2, 3));
  const btTransform offset(btQuaternion(btVector3(0, 0, 1), scalar(0.3)), vec(0.2, 0.1, 0));
  btRigidBody& body = addOffsetBox(scene, 1, {0.1, 0.2, 0.3}, offset, pose);
  const btVector3 inertia = body.getInvInertiaDiagLocal();
  scene.world->coverBody(body, {.particleRadius = 0.05});
  for (int i = 0; i < 10; ++i) scene.world->stepSimulation(scalar(1.0 / 60.0));
  EXPECT_LT((positionOf(body) - fromBullet(pose.getOrigin())).norm(), 10 * kBulletRounding);
  EXPECT_EQ(fromBullet(body.getInvInertiaDiagLocal()), fromBullet(inertia));
}

/// Spun about its principal axis z with its drawn origin at rest at first: the centre of mass, d away, flies
/// straight on at w d, and the origin goes round it.
TEST(MassFrame, FreeSpinOfAnOffCentreCompoundGoesRoundItsCentreOfMass) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  const double d = 0.5;
  const double w = 7.0;
  btDefaultMotionState state(at(1, 2, 3));
  auto& compound = scene.shape<btCompoundShape>();
  compound.addChildShape(at(d, 0, 0), &scene.box(0.1, 0.2, 0.3));
  btRigidBody& body = scene.body(2, compound, at(1, 2, 3), &state);
  body.setAngularVelocity(vec(0, 0, w));
  scene.world->coverBody(body, {.particleRadius = 0.05});
  for (int i = 0; i < 60; ++i) scene.world->stepSimulation(scalar(1.0 / 60.0), 1, scalar(1.0 / 60.0));
  const double t = 1.0;
  const Vector3 center = Vector3(1 + d, 2, 3) + t * Vector3(0, w * d, 0);
  const Vector3 arm = d * Vector3(std::cos(w * t), std::sin(w * t), 0);
  const Vector3 swing = w * d * Vector3(-std::sin(w * t), std::cos(w * t), 0);
  // RKF45 keeps its tolerance, 1e-4 of a particle radius, each sub-step.
  const double tolerance = 1e-4 + 1e3 * kBulletRounding;
  EXPECT_LT((positionOf(body) - (center - arm)).norm(), tolerance);
  EXPECT_LT((velocityOf(body) - (Vector3(0, w * d, 0) - swing)).norm(), w * tolerance);
  EXPECT_LT((fromBullet(body.getAngularVelocity()) - Vector3(0, 0, w)).norm(), tolerance);
  btTransform shown;
  state.getWorldTransform(shown);
  // Bullet shows motion states a tick late by default, and carries them back by the velocity.
  const Vector3 late = positionOf(body) - velocityOf(body) / 60.0;
  EXPECT_LT((fromBullet(shown.getOrigin()) - late).norm(), tolerance) << "what is drawn";
}

/// Released at 0.1 rad from a pivot at the drawn origin; the box's middle is d below. Period 2 pi sqrt(I / (m
/// g d)) (1 + 0.1^2 / 16), I about the pivot. Bullet's own inertia about the origin, without d, would make it
/// swing in 0.47 s in place of 1.49 s.
TEST(MassFrame, HangingBodySwingsWithThePeriodOfAPhysicalPendulum) {
  SandScene scene;
  const double g = 9.81;
  const double d = 0.5;
  scene.world->setGravity(vec(0, -g, 0));
  const btTransform tilted(btQuaternion(btVector3(0, 0, 1), scalar(0.1)), btVector3(0, 0, 0));
  btRigidBody& body = addOffsetBox(scene, 2, {0.1, 0.3, 0.1}, at(0, -d, 0), tilted);
  body.setActivationState(DISABLE_DEACTIVATION);
  scene.world->coverBody(body, {.particleRadius = 0.05});
  scene.joints.push_back(std::make_unique<btPoint2PointConstraint>(body, btVector3(0, 0, 0)));
  scene.world->addConstraint(scene.joints.back().get());

  const double tick = 1.0 / 240.0;
  const auto angle = [&] {
    const btVector3 down = body.getWorldTransform().getBasis() * btVector3(0, -1, 0);
    return std::atan2(double(down.x()), -double(down.y()));
  };
  std::vector<double> crossings;  // falling through zero
  double before = angle();
  double drift = 0.0;
  for (int i = 0; i < 5 * 240; ++i) {
    scene.world->stepSimulation(scalar(tick), 1, scalar(tick));
    const double now = angle();
    if (before > 0.0 && now <= 0.0) crossings.push_back((i + before / (before - now)) * tick);
    before = now;
    drift = std::max(drift, positionOf(body).norm());
  }
  ASSERT_GE(crossings.size(), 3u);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const double moment = (0.2 * 0.2 + 0.6 * 0.6) / 12.0 + d * d;  // per kg
  const double expected = 2.0 * kPi * std::sqrt(moment / (g * d)) * (1.0 + 0.01 / 16.0);
  EXPECT_NEAR(period, expected, 0.01 * expected);  // a joint holds the mean motion of ticks of T/350
  EXPECT_LT(drift, 0.002);
}

/// A ball drawn as a compound, for which Bullet takes the moments of its box, 2/3 m r^2. On Bullet's own
/// slope, friction 1: down at 5/7 g sin(a), not at 3/5.
TEST(MassFrame, RollingBallOfBulletsContactsHasTheMomentOfABall) {
  SandScene scene;
  const double g = 9.81;
  const double slope = 0.2;
  scene.world->setGravity(vec(g * std::sin(slope), -g * std::cos(slope), 0));
  btRigidBody& ground = scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0)), at(0, 0, 0));
  auto& compound = scene.shape<btCompoundShape>();
  compound.addChildShape(at(0, 0, 0), &scene.sphere(0.5));
  btRigidBody& ball = scene.body(2, compound, at(0, 0.5, 0));
  for (btRigidBody* body : {&ground, &ball}) body->setFriction(1);
  scene.world->coverBody(ball, {.particleRadius = 0.1});
  for (int i = 0; i < 240; ++i) scene.world->stepSimulation(scalar(1.0 / 240.0), 1, scalar(1.0 / 240.0));
  const double expected = 5.0 / 7.0 * g * std::sin(slope);
  EXPECT_NEAR(velocityOf(ball).x(), expected, 0.02 * expected);
}

TEST(MassFrame, CentralForceActsAtTheDrawnOrigin) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& body = addOffsetBox(scene, 2, {0.1, 0.1, 0.1}, at(0.5, 0, 0), at(0, 0, 0));
  scene.world->coverBody(body, {.particleRadius = 0.05});
  body.applyCentralForce(vec(0, 3, 0));
  scene.world->stepSimulation(scalar(0.001), 1, scalar(0.001));
  // Torque -0.5 x 3 about z of the centre; moment m s^2 / 6 of a cube of edge s = 0.2.
  const double spin = -0.5 * 3.0 / (2.0 * 0.04 / 6.0) * 0.001;
  EXPECT_NEAR(body.getAngularVelocity().z(), spin, 1e-3 * std::abs(spin));
  const Vector3 center = velocityOf(body) + Vector3(0, 0, spin).cross(Vector3(0.5, 0, 0));
  EXPECT_NEAR(center.y(), 3.0 / 2.0 * 0.001, 1e-5);
}

TEST(MassFrame, GravityTurnsNothing) {
  SandScene scene;
  btRigidBody& body = addOffsetBox(scene, 2, {0.1, 0.1, 0.1}, at(0.5, 0, 0), at(0, 0, 0));
  scene.world->coverBody(body, {.particleRadius = 0.05});
  for (int i = 0; i < 60; ++i) scene.world->stepSimulation(scalar(1.0 / 60.0), 1, scalar(1.0 / 60.0));
  EXPECT_NEAR(positionOf(body).y(), -5.0, 1e-4);  // Bullet's default gravity, 10 m/s^2
  EXPECT_LT(fromBullet(body.getAngularVelocity()).norm(), 1e-5);
}

}  // namespace
}  // namespace bridge_test
