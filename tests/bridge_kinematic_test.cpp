// SPDX-License-Identifier: MIT
// Kinematic and static bodies that the program moves. Bullet shows the pose of the frame's end in every tick
// of the frame; grains must feel the steady motion between. One round particle against another, elastic, so
// that a wall of speed u sends a resting grain off with exactly 2 u.
#include <memory>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

constexpr double kTick = 1.0 / 128.0;
constexpr double kSpeed = 2.0;

enum class MovedBy { MotionState, WorldTransform, CenterOfMassTransform };

struct Pusher {
  SandScene scene;
  btDefaultMotionState state{at(0, 0, 0)};
  btRigidBody* wall = nullptr;
  granular::GrainId grain;
  MovedBy how;
  double x = 0.0;

  explicit Pusher(MovedBy movedBy, double gap = 0.1) : how(movedBy) {
    scene.world->setGravity(vec(0, 0, 0));
    wall = &scene.body(0, scene.sphere(0.1), at(0, 0, 0), how == MovedBy::MotionState ? &state : nullptr);
    wall->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    wall->setActivationState(DISABLE_DEACTIVATION);
    granular::GranularSystem& sand = scene.world->grains();
    const auto steel = sand.addMaterial({.restitution = 1.0, .friction = 0.0});
    auto covering = oneParticle(0.1);
    covering.material = steel;
    scene.world->coverBody(*wall, covering);
    granular::GrainDef def;
    def.shape = sand.addGrainShape(granular::sphereShape(0.05));
    def.material = steel;
    def.pose.position = {0.15 + gap, 0, 0};
    grain = sand.addGrain(def);
  }

  void frame(double advance, int ticks) {
    x += advance;
    if (how == MovedBy::MotionState) state.setWorldTransform(at(x, 0, 0));
    if (how == MovedBy::WorldTransform) wall->setWorldTransform(at(x, 0, 0));
    if (how == MovedBy::CenterOfMassTransform) wall->setCenterOfMassTransform(at(x, 0, 0));
    scene.world->stepSimulation(scalar(ticks * kTick), ticks, scalar(kTick));
  }

  Vector3 grainVelocity() { return scene.world->grains().grainMotions()[grain.index].velocity; }
};

class KinematicPusher : public testing::TestWithParam<std::tuple<MovedBy, int>> {};

TEST_P(KinematicPusher, SendsAGrainOffWithTwiceItsSpeed) {
  const auto [how, ticks] = GetParam();
  Pusher pusher(how);
  for (int done = 0; done < 24; done += ticks) pusher.frame(kSpeed * ticks * kTick, ticks);
  EXPECT_NEAR(pusher.grainVelocity().x(), 2.0 * kSpeed, 0.01);
  EXPECT_NEAR(positionOf(*pusher.wall).x(), pusher.x, 1e-6) << "Bullet's pose is the program's";
  EXPECT_NEAR(
      pusher.scene.world->grains().bodyMotion(pusher.scene.world->bodyIdOf(*pusher.wall)).pose.position.x(),
      pusher.x, 1e-6)
      << "and the core is there at the end of the frame";
}

INSTANTIATE_TEST_SUITE_P(AnyWayAndSubSteps, KinematicPusher,
                         testing::Combine(testing::Values(MovedBy::MotionState, MovedBy::WorldTransform,
                                                          MovedBy::CenterOfMassTransform),
                                          testing::Values(1, 2, 3)));

TEST(KinematicBody, ThatStopsHasNoVelocity) {
  Pusher pusher(MovedBy::MotionState, 0.05);
  pusher.frame(0.02, 1);
  pusher.frame(0.0, 1);
  const auto motion = pusher.scene.world->grains().bodyMotion(pusher.scene.world->bodyIdOf(*pusher.wall));
  EXPECT_EQ(motion.velocity, Vector3::Zero());
}

TEST(KinematicBody, ThatTurnsCarriesWhatItTouchesAtItsRim) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btDefaultMotionState state(at(0, 0, 0));
  btRigidBody& arm = scene.body(0, scene.sphere(0.1), at(0, 0, 0), &state);
  arm.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  arm.setActivationState(DISABLE_DEACTIVATION);
  auto covering = oneParticle(0.1);
  covering.covering->positions[0] = {1.0, 0, 0};
  scene.world->coverBody(arm, covering);
  state.setWorldTransform(btTransform(btQuaternion(btVector3(0, 0, 1), scalar(0.5)), btVector3(0, 0, 0)));
  scene.world->stepSimulation(scalar(2 * kTick), 2, scalar(kTick));
  const auto motion = scene.world->grains().bodyMotion(scene.world->bodyIdOf(arm));
  EXPECT_NEAR(motion.angularVelocity.z(), 0.5 / (2 * kTick), 1e-3);
  EXPECT_LT(
      motion.pose.orientation.angularDistance(granular::Quaternion(Eigen::AngleAxisd(0.5, Vector3::UnitZ()))),
      1e-6);
}

TEST(KinematicBody, PutFarAwayJumpsWithoutVelocity) {
  Pusher pusher(MovedBy::WorldTransform);
  pusher.frame(1000.0, 1);  // 128 km/s
  EXPECT_EQ(pusher.grainVelocity(), Vector3::Zero());
  EXPECT_EQ(
      pusher.scene.world->grains().bodyMotion(pusher.scene.world->bodyIdOf(*pusher.wall)).pose.position.x(),
      1000.0);
}

TEST(KinematicBody, MovedInATickCallbackArrivesWithinTheTick) {
  Pusher pusher(MovedBy::WorldTransform);
  struct Mover {
    btRigidBody* wall;
    double x;
  } mover{pusher.wall, 0.0};
  pusher.scene.world->setInternalTickCallback(
      [](btDynamicsWorld* world, btScalar dt) {
        auto* m = static_cast<Mover*>(world->getWorldUserInfo());
        m->x += kSpeed * double(dt);
        m->wall->setWorldTransform(at(m->x, 0, 0));
      },
      &mover, true);
  for (int i = 0; i < 8; ++i) pusher.scene.world->stepSimulation(scalar(3 * kTick), 3, scalar(kTick));
  EXPECT_NEAR(pusher.grainVelocity().x(), 2.0 * kSpeed, 0.01);
}

TEST(KinematicBody, MayBecomeDynamic) {
  Pusher pusher(MovedBy::WorldTransform);
  pusher.frame(0.01, 1);
  pusher.wall->setCollisionFlags(0);
  pusher.wall->setMassProps(1, btVector3(1, 1, 1));
  pusher.wall->setLinearVelocity(vec(0, 3, 0));
  pusher.scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_EQ(pusher.scene.world->grains().bodyMotionType(pusher.scene.world->bodyIdOf(*pusher.wall)),
            granular::BodyMotion::Dynamic);
  EXPECT_NEAR(positionOf(*pusher.wall).y(), 3.0 * kTick, 1e-6);
}

TEST(DynamicBody, MayBecomeKinematic) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  ball.setLinearVelocity(vec(1, 0, 0));
  scene.world->stepSimulation(scalar(16 * kTick), 16, scalar(kTick));
  ball.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  ball.setActivationState(DISABLE_DEACTIVATION);
  for (int i = 0; i < 2; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  const auto motion = scene.world->grains().bodyMotion(scene.world->bodyIdOf(ball));
  EXPECT_NEAR(motion.pose.position.x(), 16 * kTick, 1e-6) << "it stays where it was taken over";
  EXPECT_EQ(motion.velocity, Vector3::Zero());
}

TEST(StaticBody, MovedByHandIsElsewhereAtOnce) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& wall = scene.body(0, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(wall, oneParticle(0.1));
  scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  wall.getWorldTransform().setOrigin(vec(2, 0, 0));
  scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  const auto motion = scene.world->grains().bodyMotion(scene.world->bodyIdOf(wall));
  EXPECT_EQ(motion.pose.position, Vector3(2, 0, 0));
  EXPECT_EQ(motion.velocity, Vector3::Zero());
}

}  // namespace
}  // namespace bridge_test
