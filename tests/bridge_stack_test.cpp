// SPDX-License-Identifier: MIT
// Covered bodies on each other: faces that lie flat, friction that holds, stiffness that follows from
// LayerDef::restingDepth.
#include <cmath>
#include <string>
#include <vector>

#include "bridge_cubes.h"

namespace bridge_test {
namespace {

class Column : public testing::TestWithParam<double> {};

/// Cube i carries what stands on it: the contact below it is pressed by (n - i) m g / (k L^2), and it sinks
/// by its own contact's depth and those below.
TEST_P(Column, StandsStillSunkByTheCompressionOfItsFoundations) {
  const double edge = GetParam();
  constexpr int kCount = 5;
  Cubes stack(edge);
  for (int i = 0; i < kCount; ++i) stack.add({0, (i + 0.5) * edge, 0});
  stack.run(0.5);
  double sunk = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const btRigidBody& below = i == 0 ? *stack.ground : *stack.cubes[i - 1];
    sunk +=
        (kCount - i) * massOfCube(edge) * kGravity / (stack.stiffness(*stack.cubes[i], below) * edge * edge);
    const Vector3 position = positionOf(*stack.cubes[i]);
    // Bullet stores heights of some edges to its own rounding; what still swings then is less than 1 %.
    EXPECT_NEAR((i + 0.5) * edge - position.y(), sunk, 0.01 * sunk + 2.0 * kCount * edge * kBulletRounding);
    EXPECT_LT(std::hypot(position.x(), position.z()), 1e-5 * edge);
  }
}

INSTANTIATE_TEST_SUITE_P(OfOneMetreAndOneCentimetre, Column, testing::Values(1.0, 0.01),
                         [](const auto& test) { return test.param > 0.1 ? "metre" : "centimetre"; });

TEST(RestingDepth, IsWhatACubeSinksIntoItsLike) {
  Cubes stack(0.5);
  const btRigidBody& lower = stack.add({0, 0.25, 0});
  const btRigidBody& upper = stack.add({0, 0.75, 0});
  const double depth = massOfCube(0.5) * kGravity / (stack.stiffness(lower, upper) * 0.25) / 0.5;
  EXPECT_LE(depth, bullet_bridge::LayerDef{}.restingDepth * (1.0 + 1e-6));
  EXPECT_GT(depth, 0.5 * bullet_bridge::LayerDef{}.restingDepth);  // rounded to a power of two
}

/// Bullet takes the size of a scaling for boxes, spheres and cylinders: so do surfaces that bodies meet.
TEST(BadInput, NegativeScaleIsAMirrorImage) {
  SandScene scene;
  for (btCollisionShape* shape :
       {static_cast<btCollisionShape*>(&scene.box(0.5, 0.5, 0.5)),
        static_cast<btCollisionShape*>(&scene.shape<btCylinderShape>(vec(0.5, 0.5, 0.5)))}) {
    shape->setLocalScaling(vec(-1, -1, -1));
    btRigidBody& body = scene.body(1, *shape, at(0, 0, 0));
    const granular::BodyId id = scene.world->coverBody(body, {.particleRadius = 0.1});
    for (const Vector3& p : scene.world->grains().covering(id).positions)
      EXPECT_LT(p.cwiseAbs().maxCoeff(), 0.5);
    EXPECT_NEAR(granular::boundingRadius(*scene.world->grains().bodyDef(id).exact),
                0.5 * std::sqrt(shape == scene.shapes[0].get() ? 3.0 : 2.0), 1e-5);
    scene.world->removeRigidBody(&body);
  }
}

TEST(BadInput, CapsuleOfNegativeRadiusIsRefused) {
  SandScene scene;
  auto& capsule = scene.shape<btCapsuleShape>(scalar(0.2), scalar(0.6));
  capsule.setLocalScaling(vec(-1, -1, -1));  // Bullet itself makes its radius and margin negative
  btRigidBody& body = scene.body(1, scene.box(1, 1, 1), at(0, 0, 0));
  body.setCollisionShape(&capsule);
  EXPECT_THROW(scene.world->coverBody(body, {.particleRadius = 0.1}), std::invalid_argument);
  EXPECT_FALSE(scene.world->isCovered(body));
}

TEST(RestingDepth, MustBePositive) {
  BulletScene scene;
  EXPECT_THROW(bullet_bridge::GranularLayer(*scene.world, {.restingDepth = 0.0}), std::invalid_argument);
}

/// A tower that is pushed aside by less than friction takes stands where it stood: law 18 would let it creep
/// at load / kt.
TEST(StaticFriction, HoldsACubeThatIsPushedBelowTheLimit) {
  Cubes stack(1.0);
  btRigidBody& cube = stack.add({0, 0.5, 0});
  const double limit = 0.25 * massOfCube(1.0) * kGravity;  // Bullet's product of 0.5 and 0.5
  Vector3 pushed = Vector3::Zero();
  for (int i = 0; i < 60; ++i) {
    cube.applyCentralForce(vec(0.8 * limit, 0, 0));
    stack.run(kTick);
    if (i == 29) pushed = positionOf(cube);
  }
  EXPECT_LT((positionOf(cube) - pushed).norm(), 1e-6);
  EXPECT_LT(velocityOf(cube).norm(), 1e-5);
}

TEST(StaticFriction, LetsACubeSlideThatIsPushedBeyondTheLimit) {
  Cubes stack(1.0);
  btRigidBody& cube = stack.add({0, 0.5, 0});
  const double limit = 0.25 * massOfCube(1.0) * kGravity;
  for (int i = 0; i < 30; ++i) {
    cube.applyCentralForce(vec(1.2 * limit, 0, 0));
    stack.run(kTick);
  }
  // a = (1.2 - 1) mu g for half a second, once friction is at its limit: some ten milliseconds.
  EXPECT_NEAR(velocityOf(cube).x(), 0.2 * 0.25 * kGravity * 0.5, 0.05 * 0.2 * 0.25 * kGravity * 0.5);
}

/// Three cubes of 1 t, the top one thrown along at 1 m/s: friction turns its 500 J into heat.
TEST(SlidingCubes, EnergyIsAccountedFor) {
  Cubes stack(1.0);
  for (int i = 0; i < 3; ++i) stack.add({0.0, 0.5 + i, 0.0});
  stack.cubes[2]->setLinearVelocity(vec(1, 0, 0));
  const double thrown = 0.5 * massOfCube(1.0);
  const double start = thrown + massOfCube(1.0) * kGravity * (0.5 + 1.5 + 2.5);
  for (int i = 0; i < 18; ++i) {
    stack.run(kTick);
    const granular::StepReport& report = stack.scene.world->lastStep();
    // Springs hold what 3 t weigh and friction bears: some 1 J.
    EXPECT_LT(report.energy.elastic, 0.01 * thrown);
    EXPECT_NEAR(report.energy.total() + report.dissipated, start, 0.02 * thrown);
  }
}

TEST(MeetBodies, BySurfaceIsRefusedByNameForACompoundOfSeveralParts) {
  SandScene scene;
  auto& compound = scene.shape<btCompoundShape>();
  compound.addChildShape(at(-1, 0, 0), &scene.sphere(0.5));
  compound.addChildShape(at(1, 0, 0), &scene.sphere(0.5));
  btRigidBody& body = scene.body(1, compound, at(0, 0, 0));
  try {
    scene.world->coverBody(body, {.meetBodies = bullet_bridge::MeetBodies::Surface, .particleRadius = 0.1});
    FAIL();
  } catch (const std::invalid_argument& refusal) {
    EXPECT_EQ(std::string(refusal.what()).find("CoverBodyDef.meetBodies is Surface for a collision shape "),
              0u)
        << refusal.what();
  }
  EXPECT_NO_THROW(scene.world->coverBody(body, {.particleRadius = 0.1}));
}

/// On a plane of which a patch is covered for grains, bodies stand on the endless plane itself.
TEST(MeetBodies, OnACoveredPlaneIsAtItsHeight) {
  SandScene scene;
  btRigidBody& plane =
      scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0.25)), at(0, 0, 0));
  btRigidBody& box = scene.body(8, scene.box(0.1, 0.1, 0.1), at(0, 0.35, 0));
  box.setActivationState(DISABLE_DEACTIVATION);
  bullet_bridge::CoverBodyDef patch{.particleRadius = 0.05};
  patch.shapeSurface.plane.size = 1.0;
  scene.world->coverBody(plane, patch);
  scene.world->coverBody(box);
  for (int i = 0; i < 30; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_NEAR(positionOf(box).y(), 0.35, 1e-4 * 0.2);
}

}  // namespace
}  // namespace bridge_test
