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

/// A covered box on four cubes of sand on a smooth floor, after six seconds with sleep in the core: all of it
/// has come to rest after a fraction of one, and Bullet takes two to put a body to sleep.
struct BoxOnSand {
  SandScene scene;
  btRigidBody& floor = scene.body(0, scene.box(0.5, 0.1, 0.5), at(0, -0.1, 0));
  btRigidBody& box = scene.body(0.2, scene.box(0.05, 0.02, 0.05), at(0, 0.06, 0));
  std::vector<granular::GrainId> grains;

  BoxOnSand() {
    granular::GranularSystem& sand = scene.world->grains();
    sand.setSleep({.enabled = true});
    const granular::GrainShapeId cube = sand.addGrainShape(granular::cubeShape(0.01));
    const granular::MaterialId stone = sand.addMaterial({});
    for (int i = 0; i < 4; ++i) {
      grains.push_back(
          sand.addGrain({.shape = cube,
                         .material = stone,
                         .pose = {.position = {i % 2 ? 0.03 : -0.03, 0.02, i / 2 ? 0.03 : -0.03}}}));
    }
    scene.world->coverBody(floor, {.contact = bullet_bridge::SurfaceContact::Exact});
    scene.world->coverBody(box);
    run(scene, 64 * 6);
  }
  bool isAwakeInCore() { return scene.world->grains().isAwake(scene.world->bodyIdOf(box)); }
};

TEST(CoreSleep, OfABodyInSleepingSandIsBulletsToo) {
  BoxOnSand rest;
  EXPECT_FALSE(rest.isAwakeInCore());
  EXPECT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  const Vector3 asleep = positionOf(rest.box);
  EXPECT_NEAR(asleep.y(), 0.06, 0.002);
  run(rest.scene, 64);
  EXPECT_EQ(positionOf(rest.box), asleep);
  EXPECT_FALSE(rest.isAwakeInCore()) << "Bullet's sleep disturbs the core's in nothing";
  EXPECT_LE(rest.scene.world->lastStep().evaluations, 7) << "one trial of nothing, and the report";
}

TEST(CoreSleep, EndsInBulletWhenTheSandIsTakenAway) {
  BoxOnSand rest;
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  for (const granular::GrainId grain : rest.grains) rest.scene.world->grains().removeGrain(grain);
  run(rest.scene, 64);
  EXPECT_NEAR(positionOf(rest.box).y(), 0.02, 0.002) << "on the floor";
}

TEST(CoreSleep, EndsInBulletWhenAGrainHits) {
  BoxOnSand rest;
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  granular::GranularSystem& sand = rest.scene.world->grains();
  granular::GrainDef def;
  def.shape = sand.addGrainShape(granular::sphereShape(0.01));
  def.material = sand.addMaterial({});
  def.pose.position = {0.5, 0.065, 0};
  def.velocity = {-10, 0, 0};
  sand.addGrain(def);
  const double before = positionOf(rest.box).x();
  for (int i = 0; i < 4; ++i) {
    run(rest.scene, 1);
    const double seen = positionOf(rest.box).x();
    const double moved = sand.bodyMotion(rest.scene.world->bodyIdOf(rest.box)).pose.position.x();
    EXPECT_NEAR(seen, moved, 1e-6)
        << "Bullet's body is where the core has it, also in the tick that wakes it";
  }
  EXPECT_TRUE(rest.box.isActive());
  EXPECT_LT(positionOf(rest.box).x(), before - 0.001);
}

TEST(CoreSleep, EndsForWhatAPushedBodyTouches) {
  BoxOnSand rest;
  ASSERT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
  ASSERT_FALSE(rest.scene.world->grains().isAwake(rest.grains[0]));
  const double before = positionOf(rest.box).x();
  for (int i = 0; i < 8; ++i) {
    rest.box.activate();
    rest.box.applyCentralForce(vec(4, 0, 0));
    run(rest.scene, 1);
  }
  EXPECT_GT(positionOf(rest.box).x(), before + 0.01) << "twice its weight, against friction";
  EXPECT_TRUE(rest.scene.world->grains().isAwake(rest.grains[0]));
}

// Bullet's call without a push moves nothing, and both sleep on.
TEST(CoreSleep, OutlastsActivationWithoutAForce) {
  BoxOnSand rest;
  const Vector3 before = positionOf(rest.box);
  rest.box.activate();
  run(rest.scene, 64);
  EXPECT_TRUE(rest.box.isActive()) << "for two seconds";
  EXPECT_FALSE(rest.isAwakeInCore());
  EXPECT_EQ(positionOf(rest.box), before);
  run(rest.scene, 64 * 2);
  EXPECT_EQ(rest.box.getActivationState(), ISLAND_SLEEPING);
}

}  // namespace
}  // namespace bridge_test
