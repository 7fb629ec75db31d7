// SPDX-License-Identifier: MIT
// Motion of covered bodies that nothing touches: Newton's laws, and Bullet's knobs.
// Free flight is integrated by RKF45, exact for constant forces up to rounding; what Bullet shows of it is
// rounded to its own precision.
#include <cmath>
#include <functional>
#include <numbers>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

constexpr double kTick = 1.0 / 64.0;  // exact in float too

void run(SandScene& scene, int ticks) {
  for (int i = 0; i < ticks; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
}

btRigidBody& freeBall(SandScene& scene, double mass = 1.0) {
  btRigidBody& ball = scene.body(mass, scene.sphere(0.25), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.25));
  return ball;
}

TEST(CoveredBody, FallsOnTheParabola) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ball = freeBall(scene);
  run(scene, 64);
  EXPECT_NEAR(positionOf(ball).y(), -5.0, 5.0 * 10 * kBulletRounding + 1e-12);
  EXPECT_NEAR(velocityOf(ball).y(), -10.0, 10.0 * 10 * kBulletRounding + 1e-12);
}

TEST(CoveredBody, FollowsAChangeOfGravity) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ball = freeBall(scene);
  run(scene, 64);
  scene.world->setGravity(vec(10, 0, 0));
  run(scene, 64);
  EXPECT_NEAR(positionOf(ball).x(), 5.0, 1e-5);
  EXPECT_NEAR(positionOf(ball).y(), -15.0, 1e-5);
}

TEST(CoveredBody, KeepsAGravityOfItsOwn) {
  SandScene scene;
  btRigidBody& ball = freeBall(scene);
  ball.setFlags(ball.getFlags() | BT_DISABLE_WORLD_GRAVITY);
  ball.setGravity(vec(0, 2, 0));
  run(scene, 64);
  EXPECT_NEAR(positionOf(ball).y(), 1.0, 1e-6);
}

TEST(CoveredBody, LandsOnTheCoresPoseWithoutBulletsRotationLimit) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  ball.setDamping(0, 0);
  ball.setAngularVelocity(vec(0, 128, 0));  // two rad a tick; Bullet stops at pi / 4
  run(scene, 16);
  // Angle 32 rad about y.
  const granular::Quaternion turned(Eigen::AngleAxisd(32.0, Vector3::UnitY()));
  EXPECT_LT(fromBullet(ball.getWorldTransform().getBasis()).angularDistance(turned), 1e-3);
  EXPECT_NEAR(ball.getAngularVelocity().y(), 128.0, 1e-4);
}

TEST(CoveredBody, KeepsTheCoresDoublesUnderFloatBullet) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  const granular::BodyId id = scene.world->bodyIdOf(ball);
  ball.getWorldTransform().setOrigin(vec(4096, 0, 0));  // a float there is 2e-4 m coarse
  ball.setLinearVelocity(vec(0.0009765625, 0, 0));      // 2^-10 m/s
  ball.activate();
  run(scene, 64);
  EXPECT_NEAR(scene.world->grains().bodyMotion(id).pose.position.x(), 4096.0 + 0.0009765625, 1e-10);
}

TEST(CoveredBody, TumblesWithConstantAngularMomentumAndEnergy) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& brick = scene.body(1, scene.box(0.5, 0.3, 0.1), at(0, 0, 0));
  scene.world->coverBody(brick, oneParticle(0.1));
  brick.setAngularVelocity(vec(0.05, 6, 0.05));  // about the middle axis: unstable, tumbles
  brick.setActivationState(DISABLE_DEACTIVATION);
  const Vector3 inertia = fromBullet(brick.getLocalInertia());
  const auto momentum = [&] {
    const auto m = scene.world->grains().bodyMotion(scene.world->bodyIdOf(brick));
    const auto& q = m.pose.orientation;
    return Vector3(q * inertia.cwiseProduct(q.conjugate() * m.angularVelocity));
  };
  const auto energy = [&] { return scene.world->grains().measure().energy.kinetic; };
  run(scene, 1);
  const Vector3 startMomentum = momentum();
  const double startEnergy = energy();
  const Vector3 startAxis = fromBullet(brick.getWorldTransform().getBasis()) * Vector3::UnitY();
  double leastAlignment = 1.0;
  for (int i = 0; i < 640; ++i) {
    run(scene, 1);
    const Vector3 axis = fromBullet(brick.getWorldTransform().getBasis()) * Vector3::UnitY();
    leastAlignment = std::min(leastAlignment, axis.dot(startAxis));
  }
  EXPECT_LT(leastAlignment, -0.9) << "it must turn over for the test to mean anything";
  // Bound: the integrator's tolerance, 1e-4 radii of 0.1 m per sub-step at a reach of 0.1 m, over 640 ticks.
  EXPECT_LT((momentum() - startMomentum).norm() / startMomentum.norm(), 1e-3);
  EXPECT_NEAR(energy() / startEnergy, 1.0, 1e-3);
  EXPECT_EQ(brick.getFlags() & BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY,
            BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY)
      << "the program's flag is left as it was";
}

TEST(CoveredBody, TakesForcesOnce) {
  for (const int ticks : {1, 2, 3}) {
    SandScene scene;
    scene.world->setGravity(vec(0, 0, 0));
    btRigidBody& ball = freeBall(scene, 2.0);
    ball.applyCentralForce(vec(8, 0, 0));  // lasts one stepSimulation, in all of its ticks
    scene.world->stepSimulation(scalar(ticks * kTick), 4, scalar(kTick));
    run(scene, 1);
    EXPECT_NEAR(velocityOf(ball).x(), 4.0 * ticks * kTick, 1e-6) << ticks;
  }
}

TEST(CoveredBody, TakesTorqueAboutItsOwnInertia) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  ball.applyTorque(vec(0, 0, 3));
  run(scene, 1);
  EXPECT_NEAR(ball.getAngularVelocity().z(), 3.0 * kTick / ball.getLocalInertia().z(), 1e-5);
}

TEST(CoveredBody, TakesImpulses) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene, 2.0);
  run(scene, 1);
  ball.applyCentralImpulse(vec(3, 0, 0));
  run(scene, 1);
  EXPECT_NEAR(velocityOf(ball).x(), 1.5, 1e-6);
}

TEST(CoveredBody, TakesATeleport) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  run(scene, 1);
  ball.setWorldTransform(at(1, 2, 3));
  run(scene, 1);
  EXPECT_EQ(positionOf(ball), Vector3(1, 2, 3));
}

TEST(CoveredBody, IgnoresATransformThatIsNotFinite) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  run(scene, 1);
  ball.getWorldTransform().setOrigin(vec(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  run(scene, 1);
  EXPECT_EQ(positionOf(ball), Vector3(0, 0, 0));
}

TEST(CoveredBody, IsDampedAsInBullet) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  ball.setDamping(scalar(0.5), 0);
  ball.setLinearVelocity(vec(2, 0, 0));
  run(scene, 64);
  EXPECT_NEAR(velocityOf(ball).x(), 1.0, 1e-5);  // half is left after a second
}

TEST(CoveredBody, ObeysItsFactorsAsInBullet) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ball = freeBall(scene);
  ball.setLinearFactor(vec(0.5, 0, 1));
  ball.setAngularFactor(vec(0, 1, 0));
  ball.applyCentralForce(vec(4, 0, 0));
  ball.applyTorque(vec(1, 1, 1));
  run(scene, 1);
  EXPECT_NEAR(velocityOf(ball).x(), 0.5 * 4.0 * kTick, 1e-6);
  EXPECT_EQ(velocityOf(ball).y(), 0.0);
  EXPECT_EQ(positionOf(ball).y(), 0.0);
  EXPECT_NEAR(ball.getAngularVelocity().y(), kTick / ball.getLocalInertia().y(), 1e-5);
  EXPECT_EQ(ball.getAngularVelocity().x(), 0.0);
}

// The factor belongs to the torque: multiplied into the angular velocity as well it would count twice.
TEST(CoveredBody, TakesHalfTheTorqueAtAnAngularFactorOfHalf) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  ball.setAngularFactor(scalar(0.5));
  ball.applyTorque(vec(0, 1, 0));
  run(scene, 1);
  EXPECT_NEAR(ball.getAngularVelocity().y(), 0.5 * kTick / ball.getLocalInertia().y(), 1e-5);
}

TEST(CoveredBody, FollowsAChangeOfMass) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  run(scene, 1);
  ball.setMassProps(4, vec(1, 1, 1));
  ball.updateInertiaTensor();
  ball.applyCentralForce(vec(8, 0, 0));
  run(scene, 1);
  EXPECT_NEAR(velocityOf(ball).x(), 2.0 * kTick, 1e-6);
}

TEST(CoveredBody, IsNotCutShortByContinuousCollision) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = freeBall(scene);
  btRigidBody& wall = scene.body(0, scene.box(0.25, 5, 5), at(4, 0, 0));
  scene.world->coverBody(wall, oneParticle(0.01));
  ball.setCcdMotionThreshold(scalar(0.1));
  ball.setCcdSweptSphereRadius(scalar(0.2));
  ball.setLinearVelocity(vec(128, 0, 0));  // 2 m a tick; passes the wall's particle at 0.25 m
  ball.getWorldTransform().setOrigin(vec(0, 1, 0));
  run(scene, 4);
  EXPECT_NEAR(positionOf(ball).x(), 8.0, 1e-5);
  EXPECT_EQ(ball.getCcdMotionThreshold(), scalar(0.1)) << "the program's setting is left as it was";
}

TEST(CoveredBody, GivesItsPoseToTheMotionState) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btDefaultMotionState state(at(1, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.25), at(0, 0, 0), &state);
  scene.world->coverBody(ball, oneParticle(0.25));
  ball.setLinearVelocity(vec(64, 0, 0));
  scene.world->setLatencyMotionStateInterpolation(false);  // else Bullet shows the tick before
  run(scene, 3);
  btTransform shown;
  state.getWorldTransform(shown);
  EXPECT_NEAR(shown.getOrigin().x(), 4.0, 1e-5);
}

TEST(CoveredBody, MovesAlikeInFourSubStepsAndFourSteps) {
  const auto drop = [](bool inOne) {
    SandScene scene;
    btRigidBody& slab = scene.body(0, scene.box(0.2, 0.05, 0.2), at(0, -0.05, 0));
    btRigidBody& ball = scene.body(1, scene.sphere(0.05), at(0.01, 0.13, 0));
    scene.world->addPile({.region = {{-0.06, 0.0, -0.06}, {0.06, 0.07, 0.06}}, .particleRadius = 0.01});
    scene.world->coverBody(slab);
    scene.world->coverBody(ball);
    for (int i = 0; i < 10; ++i) {
      if (inOne) {
        scene.world->stepSimulation(scalar(4.0 / 256.0), 4, scalar(1.0 / 256.0));
      } else {
        for (int k = 0; k < 4; ++k) scene.world->stepSimulation(scalar(1.0 / 256.0), 1, scalar(1.0 / 256.0));
      }
    }
    std::vector<Vector3> positions{positionOf(ball), velocityOf(ball)};
    for (const auto& grain : scene.world->grains().grainMotions()) positions.push_back(grain.pose.position);
    return positions;
  };
  EXPECT_EQ(drop(true), drop(false));
}

TEST(BadInput, WhileRunningNeverThrowsNorLeavesTheCoreNotFinite) {
  const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
  const btVector3 nans(nan, nan, nan);
  const std::vector<std::function<void(SandScene&, btRigidBody&)>> deeds{
      [&](SandScene&, btRigidBody& body) { body.applyCentralForce(nans); },
      [&](SandScene&, btRigidBody& body) { body.applyTorque(nans); },
      [&](SandScene&, btRigidBody& body) { body.setLinearVelocity(nans); },
      [&](SandScene&, btRigidBody& body) { body.getWorldTransform().setOrigin(nans); },
      [&](SandScene&, btRigidBody& body) { body.setGravity(nans); },
      [&](SandScene&, btRigidBody& body) { body.setLinearFactor(nans); },
      [&](SandScene&, btRigidBody& body) { body.setMassProps(nan, nans); },
      [&](SandScene&, btRigidBody& body) { body.setFriction(nan); },
      [&](SandScene&, btRigidBody& body) { body.setRestitution(nan); },
  };
  for (std::size_t i = 0; i < deeds.size(); ++i) {
    SCOPED_TRACE(i);
    SandScene scene;
    btRigidBody& body = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
    scene.world->coverBody(body, oneParticle(0.1));
    scene.world->stepSimulation(scalar(1.0 / 60.0));
    deeds[i](scene, body);
    EXPECT_NO_THROW(scene.world->stepSimulation(scalar(1.0 / 60.0)));
    EXPECT_NO_THROW(scene.world->stepSimulation(scalar(1.0 / 60.0)));
    const granular::RigidMotion motion = scene.world->grains().bodyMotion(scene.world->bodyIdOf(body));
    EXPECT_TRUE(motion.pose.position.allFinite() && motion.velocity.allFinite());
  }
}

}  // namespace
}  // namespace bridge_test
