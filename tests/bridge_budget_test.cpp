// SPDX-License-Identifier: MIT
// A budget of work: when it is used up, sand and covered bodies go on in slow motion, and nothing else
// happens.
#include <algorithm>
#include <cmath>

#include "bridge_cubes.h"

namespace bridge_test {
namespace {

using granular::StepFlag;
using granular::StepReport;

/// s; a power of two, so that times add up exactly.
constexpr double kExactTick = 1.0 / 64.0;

std::vector<Vector3> placesOf(const Cubes& stack) {
  std::vector<Vector3> places;
  for (const btRigidBody* cube : stack.cubes) places.push_back(positionOf(*cube));
  return places;
}

/// Three cubes of 1 m on top of each other.
struct Stack : Cubes {
  Stack() : Cubes(1.0) {
    for (int i = 0; i < 3; ++i) add({0.0, 0.5 + i, 0.0});
  }
};

TEST(Budget, LeavesAStackStanding) {
  Stack stack;
  stack.scene.world->setBudget({.evaluations = 60});
  const std::vector<Vector3> before = placesOf(stack);
  bool wasExhausted = false;
  for (int i = 0; i < 240; ++i) {
    stack.run(kTick);
    wasExhausted = wasExhausted || has(stack.scene.world->lastStep().flags, StepFlag::BudgetExhausted);
  }
  const std::vector<Vector3> after = placesOf(stack);
  EXPECT_TRUE(wasExhausted);
  for (std::size_t i = 0; i < after.size(); ++i) {
    EXPECT_LT((after[i] - before[i]).norm(), 0.001) << "cube " << i << ": sinks by some 1e-5 m";
    EXPECT_LT(velocityOf(*stack.cubes[i]).norm(), 0.01);
  }
}

TEST(Budget, NeverReachedChangesNoBit) {
  Stack without, with;
  with.scene.world->setBudget({.evaluations = 1000000000, .seconds = 1e9});
  without.cubes[2]->setLinearVelocity(vec(0.3, 0, 0));
  with.cubes[2]->setLinearVelocity(vec(0.3, 0, 0));
  without.run(0.25);
  with.run(0.25);
  EXPECT_EQ(placesOf(with), placesOf(without));
  EXPECT_EQ(with.scene.world->lastStep().flags, StepFlag::None);
  EXPECT_EQ(with.scene.world->lastStep().droppedTime, 0.0);
}

TEST(Budget, AddsUpWithTheTimeThatWasDropped) {
  Stack stack;
  stack.scene.world->setBudget({.evaluations = 100});
  double dropped = 0.0;
  for (int i = 0; i < 32; ++i) {
    stack.scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
    dropped += stack.scene.world->lastStep().droppedTime;
  }
  EXPECT_GT(dropped, 0.0);
  EXPECT_NEAR(stack.scene.world->grains().time() + dropped, 32 * kExactTick, 1e-12);
}

TEST(Budget, BoundsTheEvaluations) {
  Stack stack;
  stack.scene.world->setBudget({.evaluations = 100});
  for (int i = 0; i < 16; ++i) {
    stack.scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
    const StepReport& report = stack.scene.world->lastStep();
    // Beyond it: the rest of the trial that it ends in (six), or of the first sub-step whatever it takes, and
    // one for the report.
    EXPECT_LE(report.evaluations, report.subSteps == 1 ? 1000 : 107);
  }
}

// The slow motion is a true one: a stack that is pushed has the energy of its push, and loses it.
TEST(Budget, AddsNoEnergy) {
  Stack stack;
  stack.scene.world->setBudget({.evaluations = 300});
  stack.cubes[2]->setLinearVelocity(vec(1, 0, 0));
  const double height = 0.5 + 1.5 + 2.5;
  for (int i = 0; i < 120; ++i) {
    stack.run(kTick);
    const granular::Energy& energy = stack.scene.world->lastStep().energy;
    const double lifted = energy.potential - massOfCube(1.0) * kGravity * height;
    // 500 J of the push; the three lifted by the integrator's tolerance of 1e-4 radii of 0.08 m have 0.2 J.
    ASSERT_LT(energy.kinetic + lifted, 501.0) << "after " << i << " ticks";
  }
  EXPECT_LT(stack.scene.world->lastStep().energy.kinetic, 400.0);
}

TEST(Budget, ThatLastsAgainLetsBodiesGoOnAtFullSpeed) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  ball.setActivationState(DISABLE_DEACTIVATION);
  ball.setLinearVelocity(vec(8, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  scene.world->setBudget({.evaluations = 0});
  double dropped = 0.0;
  for (int i = 0; i < 64; ++i) {
    scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
    dropped += scene.world->lastStep().droppedTime;
  }
  EXPECT_NEAR(positionOf(ball).x(), 8.0 * (1.0 - dropped), 64 * 8.0 * kBulletRounding);
  EXPECT_EQ(velocityOf(ball).x(), 8.0);
  scene.world->setBudget({});
  const double here = positionOf(ball).x();
  for (int i = 0; i < 64; ++i) scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
  EXPECT_NEAR(positionOf(ball).x(), here + 8.0, 64 * 16.0 * kBulletRounding);
}

TEST(Budget, LetsAKinematicBodyArriveWhenItLastsAgain) {
  SandScene scene;
  btRigidBody& pusher = scene.body(0, scene.box(0.1, 0.1, 0.1), at(0, 0, 0), nullptr);
  pusher.setCollisionFlags(pusher.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  pusher.setActivationState(DISABLE_DEACTIVATION);
  scene.world->coverBody(pusher, oneParticle(0.1));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 5, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  const auto coreX = [&] {
    return scene.world->grains().bodyMotion(scene.world->bodyIdOf(pusher)).pose.position.x();
  };
  scene.world->setBudget({.evaluations = 0});
  for (int i = 1; i <= 8; ++i) {
    pusher.setWorldTransform(at(0.01 * i, 0, 0));
    ball.setLinearVelocity(vec(40, 0, 0));  // a sub-step of a quarter radius: 0.6 ms
    scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
  }
  ball.setLinearVelocity(vec(0, 0, 0));
  EXPECT_LT(coreX(), 0.07) << "behind";
  scene.world->setBudget({});
  scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
  scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
  EXPECT_NEAR(coreX(), 0.08, 1e-6);
}

// What Bullet's joints and the core do to a chain stays bounded in slow motion, and it hangs in the end.
TEST(Budget, LeavesAChainHanging) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  std::vector<btRigidBody*> links;
  for (int i = 0; i < 3; ++i) {
    links.push_back(&scene.body(1, scene.box(0.25, 0.1, 0.1), at(0.25 + 0.5 * i, 0, 0)));
    links.back()->setActivationState(DISABLE_DEACTIVATION);
    links.back()->setDamping(0, scalar(0.5));
    scene.world->coverBody(*links.back(), oneParticle(0.01));
  }
  const btVector3 axis(0, 0, 1);
  scene.joints.push_back(std::make_unique<btHingeConstraint>(*links[0], vec(-0.25, 0, 0), axis));
  for (int i = 0; i < 2; ++i) {
    scene.joints.push_back(std::make_unique<btHingeConstraint>(*links[i], *links[i + 1], vec(0.25, 0, 0),
                                                               vec(-0.25, 0, 0), axis, axis));
  }
  for (auto& joint : scene.joints) scene.world->addConstraint(joint.get(), true);
  scene.world->setBudget({.evaluations = 0});
  double highest = 0.0, farthest = 0.0;
  for (int i = 0; i < 64 * 60; ++i) {
    scene.world->stepSimulation(scalar(kExactTick), 1, scalar(kExactTick));
    highest = std::max(highest, positionOf(*links[2]).y());
    farthest = std::max(farthest, positionOf(*links[2]).norm());
  }
  EXPECT_LT(highest, 0.02) << "never above where it began";
  EXPECT_LT(farthest, 1.25 + 0.03);
}

TEST(Budget, MustNotBeNegative) {
  SandScene scene;
  EXPECT_THROW(scene.world->setBudget({.evaluations = -1}), std::invalid_argument);
  EXPECT_THROW(scene.world->setBudget({.seconds = -1.0}), std::invalid_argument);
  EXPECT_THROW(scene.world->setBudget({.seconds = std::nan("")}), std::invalid_argument);
}

}  // namespace
}  // namespace bridge_test
