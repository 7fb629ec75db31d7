// SPDX-License-Identifier: MIT
// Sleep: as in Bullet between covered bodies, never above sand, and nothing hangs in mid-air.
#include "bridge_fixture.h"

namespace bridge_test {
namespace {

constexpr double kTick = 1.0 / 64.0;

void run(SandScene& scene, int ticks) {
  for (int i = 0; i < ticks; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
}

/// A covered box on a covered slab whose upper face is at 0.
struct BoxOnSlab {
  SandScene scene;
  btRigidBody& slab = scene.body(0, scene.box(0.5, 0.1, 0.5), at(0, -0.1, 0));
  btRigidBody& box = scene.body(1, scene.box(0.1, 0.1, 0.1), at(0, 0.1, 0));

  BoxOnSlab() {
    scene.world->coverBody(slab, {.particleRadius = 0.04});
    scene.world->coverBody(box, {.particleRadius = 0.04});
  }
};

TEST(Sleep, ComesToACoveredBodyAtRestAsInBullet) {
  BoxOnSlab rest;
  run(rest.scene, 64 * 4);
  EXPECT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  const Vector3 asleep = positionOf(rest.box);
  run(rest.scene, 64);
  EXPECT_EQ(positionOf(rest.box), asleep) << "it is held where it is";
  EXPECT_NEAR(asleep.y(), 0.1, 0.02);
}

TEST(Sleep, EndsWhenTheGroundIsTakenAway) {
  BoxOnSlab rest;
  run(rest.scene, 64 * 4);
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  const double height = positionOf(rest.box).y();
  rest.scene.world->removeRigidBody(&rest.slab);
  run(rest.scene, 64);
  EXPECT_NEAR(positionOf(rest.box).y(), height - 5.0, 0.01) << "a second of free fall at 10 m/s^2";
}

TEST(Sleep, EndsWhenTheGroundIsPutElsewhere) {
  BoxOnSlab rest;
  run(rest.scene, 64 * 4);
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  const double height = positionOf(rest.box).y();
  rest.slab.setWorldTransform(at(50, 0, 0));
  run(rest.scene, 64);
  EXPECT_NEAR(positionOf(rest.box).y(), height - 5.0, 0.01);
}

TEST(Sleep, EndsWhenAGrainComesNear) {
  BoxOnSlab rest;
  run(rest.scene, 64 * 4);
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  const double before = positionOf(rest.box).x();
  granular::GranularSystem& sand = rest.scene.world->grains();
  granular::GrainDef def;
  def.shape = sand.addGrainShape(granular::sphereShape(0.04));
  def.material = sand.addMaterial({});
  def.pose.position = {0.6, 0.12, 0};
  def.velocity = {-10, 0, 0};
  sand.addGrain(def);
  run(rest.scene, 16);
  EXPECT_TRUE(rest.box.isActive());
  EXPECT_LT(positionOf(rest.box).x(), before - 0.001) << "the grain pushed it";
}

TEST(Sleep, EndsWhenACoveredBodyFliesIn) {
  BoxOnSlab rest;
  run(rest.scene, 64 * 4);
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  const double before = positionOf(rest.box).x();
  btRigidBody& ball = rest.scene.body(1, rest.scene.sphere(0.05), at(1, 0.15, 0));
  rest.scene.world->coverBody(ball, oneParticle(0.05));
  ball.setLinearVelocity(vec(-10, 1, 0));
  run(rest.scene, 16);
  EXPECT_LT(positionOf(rest.box).x(), before - 0.01);
}

TEST(Sleep, EndsWithTheWholeImpulseWhenAnUncoveredBodyHits) {
  BoxOnSlab rest;
  run(rest.scene, 64 * 4);
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  rest.scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = rest.scene.body(4, rest.scene.sphere(0.05), at(1, 0.1, 0));
  ball.setLinearVelocity(vec(-10, 0, 0));
  run(rest.scene, 12);
  EXPECT_LT(velocityOf(rest.box).x(), -2.0);
}

}  // namespace
}  // namespace bridge_test
