// SPDX-License-Identifier: MIT
// Grains and covered bodies push each other.
#include <algorithm>
#include <cmath>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

constexpr double kTick = 1.0 / 64.0;

void run(SandScene& scene, int ticks) {
  for (int i = 0; i < ticks; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
}

/// A ball that rests on a bed of sand in a box without lid: floor at 0, ball of radius 0.05.
struct BallOnSand {
  SandScene scene;
  btRigidBody& floor = scene.body(0, scene.box(0.14, 0.02, 0.14), at(0, -0.02, 0));
  std::vector<btRigidBody*> walls;
  btRigidBody& ball = scene.body(0.3, scene.sphere(0.05), at(0, 0.17, 0));
  std::vector<granular::GrainId> grains =
      scene.world->addPile({.region = {{-0.1, 0.0, -0.1}, {0.1, 0.1, 0.1}}, .particleRadius = 0.01});

  BallOnSand() {
    // All of the sand's stone: the ball may lean against a wall, and a body's own stiffness is for stacks.
    const bullet_bridge::CoverBodyDef stone{.material = scene.world->grains().addMaterial({})};
    for (const double side : {-1.0, 1.0}) {
      walls.push_back(&scene.body(0, scene.box(0.02, 0.06, 0.14), at(side * 0.12, 0.06, 0)));
      walls.push_back(&scene.body(0, scene.box(0.1, 0.06, 0.02), at(0, 0.06, side * 0.12)));
    }
    for (btRigidBody* wall : walls) scene.world->coverBody(*wall, stone);
    scene.world->coverBody(floor, stone);
    scene.world->coverBody(ball, stone);
  }
};

TEST(BulletBridge, MomentumOfBallPlusGrainsIsConserved) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.05), at(0, 0.2, 0));
  ball.setLinearVelocity(vec(0.25, -2, 0.5));
  scene.world->addPile({.region = {{-0.08, 0.0, -0.08}, {0.08, 0.1, 0.08}}, .particleRadius = 0.01});
  scene.world->coverBody(ball);
  const Vector3 start = scene.world->grains().measure().momentum;
  ASSERT_NEAR(start.y(), -2.0, 1e-12);
  run(scene, 32);
  EXPECT_GT(std::abs(velocityOf(ball).y() + 2.0), 0.1) << "the ball must have met grains";
  EXPECT_LT((scene.world->grains().measure().momentum - start).norm(), 1e-12 * start.norm());
}

TEST(BulletBridge, BallRestsOnSandAndStaysAwake) {
  BallOnSand heap;
  run(heap.scene, 5 * 64);
  EXPECT_GT(positionOf(heap.ball).y(), 0.07);
  EXPECT_LT(velocityOf(heap.ball).norm(), 0.05);
  EXPECT_TRUE(heap.ball.isActive())
      << "grains are in none of Bullet's islands: asleep it would hang when they leave";
}

TEST(BulletBridge, BallFallsWhenTheSandUnderItIsRemoved) {
  BallOnSand heap;
  run(heap.scene, 3 * 64);
  const double height = positionOf(heap.ball).y();
  const double speed = velocityOf(heap.ball).y();
  ASSERT_GT(height, 0.07) << "the ball must rest above the slab";
  for (const granular::GrainId grain : heap.grains) heap.scene.world->grains().removeGrain(grain);
  // It may lean against a wall, which would rub.
  for (btRigidBody* wall : heap.walls) heap.scene.world->removeRigidBody(wall);
  const int ticks = 3;  // 1/64 s each: 1.1 cm at 10 m/s^2
  run(heap.scene, ticks);
  const double t = ticks * kTick;
  EXPECT_NEAR(positionOf(heap.ball).y(), height + speed * t - 0.5 * 10.0 * t * t, 1e-6);
}

TEST(BulletBridge, BodyDroppedFromRestNeverRisesAboveItsStart) {
  for (const double tolerance : {1e-2, 1e-4}) {
    SandScene scene;
    btRigidBody& slab = scene.body(0, scene.box(0.5, 0.1, 0.5), at(0, -0.1, 0));
    btRigidBody& box = scene.body(1, scene.box(0.1, 0.1, 0.1), at(0, 0.4, 0));
    scene.world->coverBody(slab, {.particleRadius = 0.04});
    scene.world->coverBody(box, {.particleRadius = 0.04});
    granular::IntegratorDef integrator;
    integrator.tolerance = tolerance;
    scene.world->grains().setIntegrator(integrator);
    double highest = 0.0;
    double lowest = 1.0;
    for (int i = 0; i < 128; ++i) {
      run(scene, 1);
      highest = std::max(highest, positionOf(box).y());
      lowest = std::min(lowest, positionOf(box).y());
    }
    EXPECT_LE(highest, 0.4) << tolerance;
    EXPECT_LT(lowest, 0.15) << "it must have reached the slab";
    EXPECT_GT(lowest, 0.05) << "and not passed into it";
  }
}

TEST(BulletBridge, LockedAxesStayWhereTheyAre) {
  BallOnSand heap;
  heap.ball.setWorldTransform(at(0, 0.13, 0));
  heap.ball.setLinearFactor(vec(0, 1, 0));
  heap.ball.setAngularFactor(vec(0, 0, 0));
  run(heap.scene, 32);
  EXPECT_EQ(positionOf(heap.ball).x(), 0.0);
  EXPECT_EQ(positionOf(heap.ball).z(), 0.0);
  EXPECT_NE(positionOf(heap.ball).y(), 0.13);
  EXPECT_EQ(fromBullet(heap.ball.getWorldTransform().getBasis()).vec(), Vector3::Zero());
}

TEST(BulletBridge, ContactImpulseIsTheChangeOfMomentum) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(2, scene.sphere(0.1), at(0, 0.3, 0));
  btRigidBody& target = scene.body(2, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  scene.world->coverBody(target, oneParticle(0.1));
  ball.setLinearVelocity(vec(0, -1, 0));
  Vector3 impulse = Vector3::Zero();
  for (int i = 0; i < 64; ++i) {
    run(scene, 1);
    impulse += scene.world->grains().contactImpulse(scene.world->bodyIdOf(target)).force;
  }
  EXPECT_LT(velocityOf(target).y(), -0.3);
  EXPECT_NEAR(impulse.y(), 2.0 * velocityOf(target).y(), 1e-5);
}

TEST(BulletBridge, BodiesTakeTheirRestitutionProductFromBullet) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0.25, 0));
  btRigidBody& wall = scene.body(0, scene.sphere(0.1), at(0, 0, 0));
  ball.setRestitution(scalar(0.9));
  wall.setRestitution(scalar(0.8));
  scene.world->coverBody(ball, oneParticle(0.1));
  scene.world->coverBody(wall, oneParticle(0.1));
  ball.setLinearVelocity(vec(0, -1, 0));
  run(scene, 32);
  EXPECT_NEAR(velocityOf(ball).y(), 0.72, 0.01);
}

TEST(BulletBridge, BodiesTakeTheirFrictionProductFromBullet) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ground = scene.body(0, scene.box(1, 1, 1), at(0, -1000, 0));
  btRigidBody& sledge = scene.body(1, scene.sphere(0.1), at(0, 0.0999, 0));
  ground.setFriction(scalar(0.5));
  sledge.setFriction(scalar(0.8));
  sledge.setAngularFactor(0);                         // slides, does not roll
  scene.world->coverBody(ground, oneParticle(1000));  // flat to 1e-3 over the way
  scene.world->coverBody(sledge, oneParticle(0.1));
  run(scene, 32);
  sledge.setLinearVelocity(vec(2, 0, 0));
  run(scene, 16);
  EXPECT_NEAR(velocityOf(sledge).x(), 2.0 - 0.5 * 0.8 * 10.0 * 16 * kTick, 0.02);
}

TEST(BulletBridge, AFrictionChangedLaterIsFollowed) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ground = scene.body(0, scene.box(1, 1, 1), at(0, -1000, 0));
  btRigidBody& sledge = scene.body(1, scene.sphere(0.1), at(0, 0.0999, 0));
  sledge.setAngularFactor(0);
  scene.world->coverBody(ground, oneParticle(1000));
  scene.world->coverBody(sledge, oneParticle(0.1));
  run(scene, 32);
  sledge.setFriction(0);
  sledge.setLinearVelocity(vec(2, 0, 0));
  run(scene, 16);
  EXPECT_NEAR(velocityOf(sledge).x(), 2.0, 1e-3);
}

}  // namespace
}  // namespace bridge_test
