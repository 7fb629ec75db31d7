// SPDX-License-Identifier: MIT
// A step that may not cost more than so much goes less far, and no less exactly.
#include <gtest/gtest.h>

#include <cmath>

#include "granular/system/granular_system.h"

namespace granular {
namespace {

constexpr double kRadius = 0.01;

/// A sphere at rest on another that cannot move, and one that falls beside them: the contact bounds every
/// sub-step.
struct Spheres {
  Spheres() {
    const MaterialId stone = system.addMaterial({});
    const GrainShapeId sphere = system.addGrainShape(sphereShape(kRadius));
    Covering one;
    one.positions = {Vector3::Zero()};
    one.radii = {kRadius};
    system.addBody({.covering = one, .material = stone});
    system.addGrain({.shape = sphere, .material = stone, .pose = {.position = {0, 2 * kRadius, 0}}});
    falling = system.addGrain({.shape = sphere, .material = stone, .pose = {.position = {1, 0, 0}}});
  }
  const RigidMotion& motion() const { return system.grainMotions()[falling.index]; }

  GranularSystem system;
  GrainId falling;
};

TEST(WorkBudget, DropsTheTimeThatItIsNotEnoughFor) {
  Spheres spheres;
  const StepReport report = spheres.system.step(0.1, {.evaluations = 100});
  EXPECT_TRUE(has(report.flags, StepFlag::BudgetExhausted));
  EXPECT_GT(report.droppedTime, 0.0);
  EXPECT_NEAR(report.time + report.droppedTime, 0.1, 1e-15);
  EXPECT_EQ(report.time, spheres.system.time());
  EXPECT_GE(report.evaluations, 100);
  EXPECT_LE(report.evaluations, 107) << "a trial of six may end beyond it, and the report takes one";
}

TEST(WorkBudget, LeavesWhatIsSimulatedExact) {
  Spheres spheres;
  for (int i = 0; i < 10; ++i) spheres.system.step(0.1, {.evaluations = 100});
  const double t = spheres.system.time();
  ASSERT_LT(t, 0.5);
  EXPECT_NEAR(spheres.motion().pose.position.y(), -0.5 * 9.81 * t * t, 1e-12);
  EXPECT_NEAR(spheres.motion().velocity.y(), -9.81 * t, 1e-12);
}

TEST(WorkBudget, OfNothingStillMakesASubStep) {
  Spheres spheres;
  const StepReport report = spheres.system.step(0.1, {.evaluations = 0});
  EXPECT_EQ(report.subSteps, 1);
  EXPECT_GT(report.time, 0.0);
  EXPECT_EQ(spheres.system.step(0.1, {.seconds = 0.0}).subSteps, 1);
}

TEST(WorkBudget, ThatIsEnoughChangesNothing) {
  Spheres with, without;
  const StepReport report = with.system.step(0.1, {.evaluations = 1000000, .seconds = 1e6});
  without.system.step(0.1);
  EXPECT_EQ(report.flags, StepFlag::None);
  EXPECT_EQ(report.droppedTime, 0.0);
  EXPECT_EQ(with.motion().pose.position, without.motion().pose.position);
  EXPECT_EQ(with.system.grainMotions()[0].velocity, without.system.grainMotions()[0].velocity);
}

}  // namespace
}  // namespace granular
