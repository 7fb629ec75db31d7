// SPDX-License-Identifier: MIT
// Joints between covered bodies are solved by Bullet on the mean motion of the tick.
#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

/// Four boxes on hinges, one end pinned to the world at this height, m, falling from the horizontal onto the
/// ground. Returns the largest distance of any joint's two ends over four seconds, m.
template <class World>
double worstJointError(double height, bool covered) {
  Scene<World> scene;
  btRigidBody& ground = scene.body(0, scene.box(5, 0.5, 5), at(0, -0.5, 0));
  std::vector<btRigidBody*> links;
  for (int i = 0; i < 4; ++i) {
    links.push_back(&scene.body(1, scene.box(0.25, 0.1, 0.1), at(0.25 + 0.5 * i, height, 0)));
    links.back()->setActivationState(DISABLE_DEACTIVATION);
  }
  const btVector3 axis(0, 0, 1);
  scene.joints.push_back(std::make_unique<btHingeConstraint>(*links[0], vec(-0.25, 0, 0), axis));
  for (int i = 0; i < 3; ++i) {
    scene.joints.push_back(std::make_unique<btHingeConstraint>(*links[i], *links[i + 1], vec(0.25, 0, 0),
                                                               vec(-0.25, 0, 0), axis, axis));
  }
  for (auto& joint : scene.joints) scene.world->addConstraint(joint.get(), true);
  if constexpr (std::is_same_v<World, bullet_bridge::GranularDynamicsWorld>) {
    if (covered) {
      scene.world->coverBody(ground, {.particleRadius = 0.1});
      for (btRigidBody* link : links) scene.world->coverBody(*link, {.particleRadius = 0.05});
    }
  }
  double worst = 0.0;
  for (int i = 0; i < 240; ++i) {
    scene.world->stepSimulation(scalar(1.0 / 60.0), 1, scalar(1.0 / 60.0));
    worst = std::max(
        worst, (fromBullet(links[0]->getWorldTransform() * vec(-0.25, 0, 0)) - Vector3(0, height, 0)).norm());
    for (int k = 0; k < 3; ++k) {
      worst = std::max(worst, fromBullet(links[k]->getWorldTransform() * vec(0.25, 0, 0) -
                                         links[k + 1]->getWorldTransform() * vec(-0.25, 0, 0))
                                  .norm());
    }
  }
  return worst;
}

TEST(HingeChain, OfCoveredBodiesIsNoWorseThanBulletsOwn) {
  for (const double height : {0.9, 1.0, 1.1, 1.2, 1.35, 1.5}) {
    EXPECT_LE(worstJointError<bullet_bridge::GranularDynamicsWorld>(height, true),
              worstJointError<btDiscreteDynamicsWorld>(height, false))
        << "from " << height << " m";
  }
}

/// A bar turning at 9 rad/s about a pin at its end, 0.5 m from its centre, without gravity: how far the end
/// is from the pin at most in the second half of a second, m.
template <class World>
double latePinError(bool covered) {
  Scene<World> scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& bar = scene.body(1, scene.box(0.5, 0.1, 0.1), at(0.5, 0, 0));
  bar.setActivationState(DISABLE_DEACTIVATION);
  bar.setLinearVelocity(vec(0, 4.5, 0));
  bar.setAngularVelocity(vec(0, 0, 9));
  if constexpr (std::is_same_v<World, bullet_bridge::GranularDynamicsWorld>) {
    if (covered) scene.world->coverBody(bar, oneParticle(0.1));
  }
  scene.joints.push_back(std::make_unique<btPoint2PointConstraint>(bar, vec(-0.5, 0, 0)));
  scene.world->addConstraint(scene.joints[0].get());
  double late = 0.0;
  for (int i = 0; i < 60; ++i) {
    scene.world->stepSimulation(scalar(1.0 / 60.0), 1, scalar(1.0 / 60.0));
    if (i >= 30) late = std::max(late, fromBullet(bar.getWorldTransform() * vec(-0.5, 0, 0)).norm());
  }
  return late;
}

// Bullet's pin pulls along the lever that the bar has when the tick begins: the bar leaves its arc by
// r (w dt)^2 / 2 in every tick. The lever in mid-tick leaves the third order, a factor of w dt = 0.15 less;
// it is known as well as the load, which lags the turning pull: half of that again is allowed for it.
TEST(Pin, KeepsACoveredBarOnItsArc) {
  EXPECT_LT(latePinError<bullet_bridge::GranularDynamicsWorld>(true),
            1.5 * 0.15 * latePinError<btDiscreteDynamicsWorld>(false));
}

/// Two covered boxes on a hinge between them, sliding over uncovered ground without friction.
double heightOfSlidingPair(double speed) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ground = scene.body(0, scene.box(100, 0.1, 5), at(0, -0.1, 0));
  ground.setFriction(0);
  btRigidBody* boxes[2];
  for (int i = 0; i < 2; ++i) {
    boxes[i] = &scene.body(1, scene.box(0.1, 0.1, 0.1), at(0.3 * i, 0.1, 0));
    boxes[i]->setActivationState(DISABLE_DEACTIVATION);
    boxes[i]->setFriction(0);
    boxes[i]->setLinearVelocity(vec(speed, 0, 0));
    scene.world->coverBody(*boxes[i], oneParticle(0.1));
  }
  const btVector3 axis(0, 0, 1);
  scene.joints.push_back(std::make_unique<btHingeConstraint>(*boxes[0], *boxes[1], vec(0.15, 0, 0),
                                                             vec(-0.15, 0, 0), axis, axis));
  scene.world->addConstraint(scene.joints[0].get(), true);
  double highest = 0.0;
  for (int i = 0; i < 64; ++i) {
    scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
    highest = std::max({highest, positionOf(*boxes[0]).y(), positionOf(*boxes[1]).y()});
  }
  return highest;
}

// Joints see bodies in mid-tick, by 0.16 m farther on; contacts must not take that for a lever.
TEST(JointedBody, SlidesOnUncoveredGroundAtAnySpeed) {
  EXPECT_NEAR(heightOfSlidingPair(20.0), heightOfSlidingPair(0.0), 1e-3);
}

// Bullet shows the other one at the start of the tick, where the two fit together.
TEST(JointedBody, StaysWithAnUncoveredPartnerAtAnySpeed) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody* boxes[3];
  for (int i = 0; i < 3; ++i) {
    boxes[i] = &scene.body(1, scene.box(0.1, 0.1, 0.1), at(0.3 * i, 0, 0));
    boxes[i]->setLinearVelocity(vec(20, 0, 0));
  }
  scene.world->coverBody(*boxes[0], oneParticle(0.1));
  scene.world->coverBody(*boxes[1], oneParticle(0.1));
  for (int i = 0; i < 2; ++i) {
    scene.joints.push_back(std::make_unique<btPoint2PointConstraint>(*boxes[i], *boxes[i + 1],
                                                                     vec(0.15, 0, 0), vec(-0.15, 0, 0)));
    scene.world->addConstraint(scene.joints.back().get(), true);
  }
  for (int i = 0; i < 64; ++i) scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(positionOf(*boxes[i]).x(), 20.0 + 0.3 * i, 1e-4);
}

/// A bar pinned at one end, of length 1 m: a physical pendulum of I = m L^2 / 3 about the pin. Small swings
/// have the period 2 pi sqrt(2 L / (3 g)) = 1.6223 s at g = 10 m/s^2 (swing of 0.1 rad: 0.06 % longer).
TEST(Pendulum, OfACoveredBarKeepsItsPeriod) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  const double angle = 0.1;
  const btTransform start(btQuaternion(btVector3(0, 0, 1), scalar(angle)),
                          vec(0.5 * std::sin(angle), -0.5 * std::cos(angle), 0));
  btRigidBody& bar = scene.body(1, scene.box(0.005, 0.5, 0.005), start);
  bar.setMassProps(1, vec(1.0 / 12, 1e-3, 1.0 / 12));
  bar.setActivationState(DISABLE_DEACTIVATION);
  scene.world->coverBody(bar, oneParticle(0.005));
  scene.joints.push_back(std::make_unique<btPoint2PointConstraint>(bar, vec(0, 0.5, 0)));
  scene.world->addConstraint(scene.joints[0].get());
  double lastX = positionOf(bar).x();
  std::vector<double> crossings;  // times at which the bar hangs straight, going left
  for (int i = 1; i <= 60 * 8; ++i) {
    scene.world->stepSimulation(scalar(1.0 / 60.0), 1, scalar(1.0 / 60.0));
    const double x = positionOf(bar).x();
    if (lastX > 0 && x <= 0) crossings.push_back((i - x / (x - lastX)) / 60.0);
    lastX = x;
  }
  ASSERT_GE(crossings.size(), 4u);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  EXPECT_NEAR(period, 1.6223 * 1.0006, 0.005);
}

// What a joint bears all the time acts on it within the tick too, so it neither falls nor is put back.
TEST(JointedBody, HangsStill) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& body = scene.body(1, scene.box(0.1, 0.1, 0.1), at(0, 0, 0));
  body.setActivationState(DISABLE_DEACTIVATION);
  scene.world->coverBody(body, oneParticle(0.1));
  scene.joints.push_back(std::make_unique<btPoint2PointConstraint>(body, vec(0, 0.5, 0)));
  scene.world->addConstraint(scene.joints[0].get());
  for (int i = 0; i < 256; ++i) scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
  EXPECT_LT(positionOf(body).norm(), 1e-5);
  EXPECT_NEAR(velocityOf(body).y(), 0.0, 1e-6 * 10.0 / 64.0);
}

TEST(CoveredBody, StandsOnUncoveredGroundThroughBulletsContact) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  scene.body(0, scene.box(0.5, 0.1, 0.5), at(0, -0.1, 0));
  btRigidBody& box = scene.body(1, scene.box(0.1, 0.1, 0.1), at(0, 0.3, 0));
  box.setActivationState(DISABLE_DEACTIVATION);
  scene.world->coverBody(box, oneParticle(0.1));
  for (int i = 0; i < 256; ++i) scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
  EXPECT_NEAR(positionOf(box).y(), 0.1, 10.0 / (64.0 * 64.0)) << "within the fall of a tick, g dt^2";
}

TEST(BreakableJoint, OfACoveredBodyBreaksUnderItsLoad) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& body = scene.body(1, scene.box(0.1, 0.1, 0.1), at(0, 0, 0));
  scene.world->coverBody(body, oneParticle(0.1));
  scene.joints.push_back(std::make_unique<btPoint2PointConstraint>(body, vec(0, 0, 0)));
  scene.joints[0]->setBreakingImpulseThreshold(scalar(1.5 * 10.0 / 64.0));  // holds 1.5 times its weight
  scene.world->addConstraint(scene.joints[0].get());
  for (int i = 0; i < 16; ++i) scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
  EXPECT_TRUE(scene.joints[0]->isEnabled());
  for (int i = 0; i < 16; ++i) {
    body.applyCentralForce(vec(0, -10, 0));
    scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
  }
  EXPECT_FALSE(scene.joints[0]->isEnabled());
  EXPECT_LT(positionOf(body).y(), -0.05);
}

}  // namespace
}  // namespace bridge_test
