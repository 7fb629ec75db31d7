// SPDX-License-Identifier: MIT
// Joints, motors, springs and breaking of covered bodies, each against its closed form, for a body whose
// centre of mass is at its origin and for one whose is not.
#include <cmath>
#include <numbers>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

constexpr double kTick = 1.0 / 240.0;

/// One covered box of 0.2 m and 2 kg; its middle is `offset` from the drawn origin, which is at (0, 0, 0).
class JointedBox : public testing::TestWithParam<double> {
 protected:
  JointedBox() {
    auto& compound = scene.shape<btCompoundShape>();
    compound.addChildShape(at(GetParam(), 0, 0), &scene.box(0.1, 0.1, 0.1));
    box = &scene.body(2, compound, at(0, 0, 0));
    box->setActivationState(DISABLE_DEACTIVATION);
    scene.world->coverBody(*box, {.particleRadius = 0.05});
  }

  template <class Joint, class... Arguments>
  Joint& join(Arguments&&... arguments) {
    auto joint = std::make_unique<Joint>(*box, std::forward<Arguments>(arguments)...);
    Joint& result = *joint;
    scene.joints.push_back(std::move(joint));
    scene.world->addConstraint(&result);
    return result;
  }
  void run(double seconds) {
    const int ticks = static_cast<int>(std::lround(seconds / kTick));
    for (int i = 0; i < ticks; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  }

  SandScene scene;
  btRigidBody* box = nullptr;
};

/// It hangs by its middle: the impulse of a tick is m g dt.
TEST_P(JointedBox, HangsOnAPointThatBreaksBeyondItsThreshold) {
  scene.world->setGravity(vec(0, -10, 0));
  const double weight = 2.0 * 10.0 * kTick;
  auto& joint = join<btPoint2PointConstraint>(vec(GetParam(), 0, 0));
  joint.setBreakingImpulseThreshold(scalar(2.0 * weight));
  btJointFeedback feedback;
  joint.setJointFeedback(&feedback);
  run(1.0);
  EXPECT_TRUE(joint.isEnabled());
  EXPECT_NEAR(feedback.m_appliedForceBodyA.y(), 20.0, 0.2);
  joint.setJointFeedback(nullptr);
  EXPECT_LT(positionOf(*box).norm(), 1e-3);
  joint.setBreakingImpulseThreshold(scalar(0.5 * weight));
  run(0.5);
  EXPECT_FALSE(joint.isEnabled());
  EXPECT_NEAR(positionOf(*box).y(), -0.5 * 10.0 * 0.25, 0.1);
}

TEST_P(JointedBox, SlidesAlongItsRailAsAPointMass) {
  scene.world->setGravity(vec(3, -10, 0));
  auto& rail = join<btSliderConstraint>(btTransform::getIdentity(), true);
  rail.setLowerLinLimit(-10);
  rail.setUpperLinLimit(10);
  rail.setLowerAngLimit(0);
  rail.setUpperAngLimit(0);
  run(1.0);
  EXPECT_NEAR(positionOf(*box).x(), 0.5 * 3.0, 0.02);
  EXPECT_LT(std::hypot(positionOf(*box).y(), positionOf(*box).z()), 2e-3) << "g dt^2 = 0.2 mm is the layer's";
}

TEST_P(JointedBox, IsTurnedByAHingeMotorAtItsSpeed) {
  scene.world->setGravity(vec(0, 0, 0));
  auto& hinge = join<btHingeConstraint>(btVector3(0, 0, 0), btVector3(0, 0, 1));
  hinge.enableAngularMotor(true, 3, 10);
  run(1.0);
  EXPECT_NEAR(std::abs(double(box->getAngularVelocity().z())), 3.0, 0.02);
  EXPECT_LT(positionOf(*box).norm(), 2e-3);
}

/// Period 2 pi sqrt(m / k); the spring acts on the line through the middle, so nothing turns.
TEST_P(JointedBox, SwingsOnASpringWithItsPeriod) {
  scene.world->setGravity(vec(0, 0, 0));
  const btTransform middle = at(GetParam(), 0, 0);
  auto& spring = join<btGeneric6DofSpring2Constraint>(middle);
  spring.setLinearLowerLimit(vec(0, 1, 0));  // lower above upper: free
  spring.setLinearUpperLimit(vec(0, -1, 0));
  spring.enableSpring(1, true);
  spring.setStiffness(1, 200);
  spring.setDamping(1, 0);
  spring.setEquilibriumPoint(1, 0);
  box->setLinearVelocity(vec(0, 0.5, 0));
  std::vector<double> crossings;  // upwards through zero
  double before = 0.0;
  for (int i = 0; i < 720; ++i) {
    run(kTick);
    const double now = positionOf(*box).y();
    if (before < 0.0 && now >= 0.0) crossings.push_back((i - now / (now - before)) * kTick);
    before = now;
  }
  ASSERT_GE(crossings.size(), 3u);
  const double period = (crossings.back() - crossings.front()) / static_cast<double>(crossings.size() - 1);
  const double expected = 2.0 * std::numbers::pi * std::sqrt(2.0 / 200.0);
  EXPECT_NEAR(period, expected, 0.02 * expected);  // (w dt)^2 / 24 is 1e-4; the joint's own softness the rest
}

INSTANTIATE_TEST_SUITE_P(CentredAndNot, JointedBox, testing::Values(0.0, 0.3));

}  // namespace
}  // namespace bridge_test
