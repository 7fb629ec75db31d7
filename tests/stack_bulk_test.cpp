// SPDX-License-Identifier: MIT
// Stacks over as long as a program would look at them, with leapfrog: the answers are RKF45's at a sixth of
// the evaluations.
#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include "bridge_cubes.h"

namespace bridge_test {
namespace {

void setLeapfrog(SandScene& scene) {
  granular::IntegratorDef integrator = scene.world->grains().integrator();
  integrator.stepper = granular::Stepper::Leapfrog;
  integrator.contactTimeFraction = 0.3;
  scene.world->grains().setIntegrator(integrator);
}

/// Places of all cubes against where statics says they are, in edges: how far they sink, and how far aside.
void expectStatic(Cubes& stack, double edge, double massOfTop) {
  const std::size_t count = stack.cubes.size();
  double sunk = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const btRigidBody& below = i == 0 ? *stack.ground : *stack.cubes[i - 1];
    const double load = double(count - 1 - i) * massOfCube(edge) + massOfTop;
    sunk += load * kGravity / (stack.stiffness(*stack.cubes[i], below) * edge * edge);
    const Vector3 position = positionOf(*stack.cubes[i]);
    EXPECT_NEAR(((double(i) + 0.5) * edge - position.y()) / edge, sunk / edge,
                0.01 * sunk / edge + 2.0 * double(count) * kBulletRounding);
    EXPECT_LT(std::hypot(position.x(), position.z()), 0.01 * edge) << "cube " << i;
  }
}

class TallColumn : public testing::TestWithParam<std::tuple<int, double>> {};

TEST_P(TallColumn, StandsTwentySeconds) {
  const auto [count, edge] = GetParam();
  Cubes stack(edge);
  setLeapfrog(stack.scene);
  for (int i = 0; i < count; ++i) stack.add({0, (i + 0.5) * edge, 0});
  stack.run(20.0);
  expectStatic(stack, edge, massOfCube(edge));
}

INSTANTIATE_TEST_SUITE_P(OfCubes, TallColumn,
                         testing::Combine(testing::Values(10, 20, 30), testing::Values(1.0, 0.01)));

TEST(HeavyOnLight, OneToAThousandStandsAMinute) {
  Cubes stack(1.0);
  setLeapfrog(stack.scene);
  stack.add({0, 0.5, 0});
  btRigidBody& heavy = stack.add({0, 1.5, 0});
  const double mass = 1000.0 * massOfCube(1.0);
  heavy.setMassProps(scalar(mass), scalar(mass / 6.0) * btVector3(1, 1, 1));
  heavy.updateInertiaTensor();
  stack.run(60.0);
  expectStatic(stack, 1.0, mass);
}

}  // namespace
}  // namespace bridge_test
