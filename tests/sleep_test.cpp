// SPDX-License-Identifier: MIT
// Sleep must not change what happens, only what it costs: nothing sleeps that is not carried, what slept
// moves again when its balance is lost, and forces, energies, momentum and memories are those of an awake
// scene.
#include "granular/system/sleep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <vector>

#include "granular/system/granular_system.h"

namespace granular {
namespace {

constexpr double kRadius = 0.01, kGravity = 9.81, kFriction = 0.5, kFrame = 1.0 / 60.0;

/// A floor at y = 0 and one material that holds at rest (Bell 2005, eq. 19).
struct Scene {
  explicit Scene(bool sleeps, Vector3 gravity = {0.0, -kGravity, 0.0}, int threads = 1)
      : system({.gravity = gravity, .sleep = {.enabled = sleeps}, .threads = threads}),
        stone(system.addMaterial({.friction = kFriction})),
        ball(system.addGrainShape(sphereShape(kRadius))) {
    system.setMaterialPair(stone, stone, {.shear = {.law = ShearLaw::StaticFriction}});
    floor = addPlane({0, 0, 0}, Vector3::UnitY());
  }

  BodyId addPlane(const Vector3& at, const Vector3& normal) {
    return system.addBody({.motion = held,
                           .exact = HalfSpace{},
                           .material = stone,
                           .pose = {at, Quaternion::FromTwoVectors(Vector3::UnitY(), normal)}});
  }
  GrainId addBall(const Vector3& at, const Vector3& velocity = Vector3::Zero()) {
    return system.addGrain(
        {.shape = ball, .material = stone, .pose = {.position = at}, .velocity = velocity});
  }
  /// n x n balls between walls, and (n - 1) x (n - 1) in the hollows between them.
  void addBed(int n) {
    for (const double side : {-1.0, 1.0}) {
      walls.push_back(addPlane({side * n * kRadius, 0, 0}, {-side, 0, 0}));
      walls.push_back(addPlane({0, 0, side * n * kRadius}, {0, 0, -side}));
    }
    for (int layer = 0; layer < 2; ++layer) {
      for (int i = 0; i < (n - layer) * (n - layer); ++i) {
        const Vector3 site(i % (n - layer), 0.0, i / (n - layer));
        Vector3 at =
            kRadius * (2.0 * site + Vector3(layer + 1 - n, 1.0 + layer * std::sqrt(2.0), layer + 1 - n));
        grains.push_back(addBall(at));
      }
    }
  }
  /// Four balls side by side and one on them.
  void addHeap(const Vector3& middle) {
    for (const double x : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) grains.push_back(addBall(middle + kRadius * Vector3(x, 1, z)));
    }
    grains.push_back(addBall(middle + kRadius * Vector3(0, 1.0 + std::sqrt(2.0), 0)));
  }
  StepReport run(double seconds) {
    StepReport report;
    for (int i = 0; i < std::max(1, static_cast<int>(std::lround(seconds / kFrame))); ++i)
      report = system.step(kFrame);
    return report;
  }
  double weight() {
    double sum = 0.0;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(system.grainMotions().size()); ++i) {
      if (const GrainId id = system.grainAt(i); id.index >= 0) sum += system.massOf(id) * kGravity;
    }
    return sum;
  }
  double forceOnFloor() { return -system.contactWrench(floor).force.y(); }

  GranularSystem system;
  MaterialId stone;
  GrainShapeId ball;
  BodyMotion held = BodyMotion::Static;
  BodyId floor;
  std::vector<BodyId> walls;
  std::vector<GrainId> grains;
};

/// Where a ball touches the four below it on a bed; x and z in radii, of the parity of the third layer.
Vector3 inAHollow(double x, double z) {
  return kRadius * Vector3(x, 1.0 + 2.0 * std::sqrt(2.0), z);
}

TEST(Sleep, GrainOnTheFloorFallsAsleep) {
  Scene scene(true);
  const GrainId grain = scene.addBall({0, kRadius, 0});
  const StepReport report = scene.run(1.0);
  EXPECT_FALSE(scene.system.isAwake(grain));
  EXPECT_EQ(report.awakeGrains, 0);
  EXPECT_EQ(report.frozenContacts, 1);
  EXPECT_EQ(report.contacts, 1);
  EXPECT_EQ(report.candidates, 0);
  EXPECT_EQ(report.energy.kinetic, 0.0);
}

TEST(Sleep, IsOffUnlessAskedFor) {
  Scene scene(false);
  const GrainId grain = scene.addBall({0, kRadius, 0});
  scene.run(1.0);
  EXPECT_TRUE(scene.system.isAwake(grain));
}

TEST(Sleep, FloorUnderASleeperBearsItsWeight) {
  Scene scene(true);
  scene.addBall({0, kRadius, 0});
  scene.run(1.0);
  EXPECT_NEAR(scene.forceOnFloor(), scene.weight(), scene.system.sleep().balance * scene.weight());
}

TEST(Sleep, GrainNearTheTopOfItsFlightStaysAwake) {
  // So weak a gravity that it moves less than restWay in restTime there: g (0.05 s)^2 / 2 = 1e-6 m of 1e-5 m.
  Scene scene(true, {0, -1e-3, 0});
  const GrainId grain = scene.addBall({0, 3 * kRadius, 0}, {0, 0.5e-3, 0});
  for (int i = 0; i < 60; ++i) {
    scene.run(kFrame);
    ASSERT_TRUE(scene.system.isAwake(grain));
  }
}

TEST(Sleep, GrainAdriftWithoutGravityStaysAwake) {
  Scene scene(true, Vector3::Zero());
  const GrainId grain = scene.addBall({0, 3 * kRadius, 0});
  scene.run(1.0);
  EXPECT_TRUE(scene.system.isAwake(grain));
}

TEST(Sleep, BallThatRollsStaysAwake) {
  // Forces balance on it; it moves ten times restWay in restTime.
  Scene scene(true);
  const double speed = 10.0 * SleepDef{}.restWay * kRadius / SleepDef{}.restTime;
  const GrainId grain = scene.addBall({0, kRadius, 0});
  scene.system.step(0.5 * kFrame);
  scene.system.setGrainMotion(grain, {.pose = scene.system.grainMotions()[0].pose,
                                      .velocity = {speed, 0, 0},
                                      .angularVelocity = {0, 0, -speed / kRadius}});
  scene.run(1.0);
  EXPECT_TRUE(scene.system.isAwake(grain));
  EXPECT_NEAR(scene.system.grainMotions()[0].velocity.x(), speed, 0.05 * speed);  // damped in its contact
}

TEST(Sleep, GrainThatMayNotSleepStaysAwake) {
  Scene scene(true);
  const GrainId grain = scene.system.addGrain({.shape = scene.ball,
                                               .material = scene.stone,
                                               .pose = {.position = {0, kRadius, 0}},
                                               .maySleep = false});
  scene.run(1.0);
  EXPECT_TRUE(scene.system.isAwake(grain));
}

TEST(Sleep, GrainFallsWhenTheFloorIsTakenAway) {
  Scene scene(true);
  const GrainId grain = scene.addBall({0, kRadius, 0});
  scene.run(1.0);
  ASSERT_FALSE(scene.system.isAwake(grain));
  scene.system.removeBody(scene.floor);
  const double before = scene.system.grainMotions()[0].pose.position.y();
  scene.run(0.5);
  const double fallen = before - scene.system.grainMotions()[0].pose.position.y();
  EXPECT_NEAR(fallen, 0.5 * kGravity * 0.25, 1e-9);  // from the very start of the step after
}

TEST(Sleep, GrainsFallWhenThoseBelowAreTakenAway) {
  Scene scene(true);
  scene.addBed(4);
  scene.run(1.0);
  ASSERT_EQ(scene.system.measure().awakeGrains, 0);
  for (int below = 0; below < 16; ++below) scene.system.removeGrain(scene.grains[below]);
  const StepReport report = scene.run(kFrame);
  EXPECT_EQ(report.awakeGrains, 9);
  const double mass = 9 * scene.system.massOf(scene.grains.back());
  EXPECT_NEAR(report.momentum.y(), -mass * kGravity * kFrame, 1e-3 * mass * kGravity * kFrame);
}

TEST(Sleep, ChangeOfGravityWakesEverything) {
  Scene scene(true);
  scene.addBed(3);
  scene.run(1.0);
  ASSERT_EQ(scene.system.measure().awakeGrains, 0);
  scene.system.setGravity({0.1, -kGravity, 0});
  EXPECT_EQ(scene.system.measure().awakeGrains, scene.system.grainCount());
}

TEST(Sleep, RegionIsWoken) {
  Scene scene(true);
  scene.addBed(4);
  scene.run(1.0);
  scene.system.wakeRegion({{-1, -1, -1}, {0, 1, 1}});
  for (const GrainId id : scene.grains) {
    EXPECT_EQ(scene.system.isAwake(id), scene.system.grainMotions()[id.index].pose.position.x() <= 0.0);
  }
}

TEST(Sleep, WokenBedIsInTheSameBalance) {
  // Memories come back: else friction would be gone, and forces with it.
  Scene scene(true);
  scene.addBed(4);
  scene.run(1.0);
  std::vector<ContactView> asleep, awake;
  scene.system.readContacts(asleep);
  scene.system.wakeAll();
  scene.system.readContacts(awake);
  ASSERT_EQ(asleep.size(), awake.size());
  double largest = 0.0;
  for (const ContactView& contact : asleep) largest = std::max(largest, contact.force.norm());
  for (std::size_t i = 0; i < asleep.size(); ++i) {
    EXPECT_EQ(asleep[i].ownerKind[1], awake[i].ownerKind[1]);
    EXPECT_EQ(asleep[i].ownerIndex[0], awake[i].ownerIndex[0]);
    EXPECT_EQ(asleep[i].ownerIndex[1], awake[i].ownerIndex[1]);
    EXPECT_LT((asleep[i].force - awake[i].force).norm(), 2.0 * scene.system.sleep().balance * largest);
  }
}

TEST(Sleep, MemoryToBeSavedIsThatOfAllContacts) {
  Scene scene(true);
  scene.addBed(4);
  const StepReport report = scene.run(1.0);
  ASSERT_EQ(report.awakeGrains, 0);
  EXPECT_EQ(static_cast<std::int64_t>(scene.system.contactMemory().size()), report.contacts);
}

/// A scene with the same owners, that goes on where the other is.
Scene resumed(Scene& from, int across) {
  Scene scene(true);
  scene.addBed(across);
  for (const GrainId id : scene.grains) scene.system.setGrainMotion(id, from.system.grainMotions()[id.index]);
  scene.system.setContactMemory(from.system.contactMemory());
  scene.system.setSleepState(from.system.sleepState());
  return scene;
}

TEST(Sleep, SavedSleepersPressAsTheyDid) {
  Scene scene(true);
  scene.addBed(4);
  const StepReport before = scene.run(1.0);
  ASSERT_EQ(before.awakeGrains, 0);
  Scene again = resumed(scene, 4);
  const StepReport after = again.system.measure();
  EXPECT_EQ(after.awakeGrains, 0);
  EXPECT_EQ(after.frozenContacts, before.frozenContacts);
  EXPECT_EQ(after.energy.elastic, before.energy.elastic);
  EXPECT_EQ(again.forceOnFloor(), scene.forceOnFloor());
  EXPECT_EQ(again.run(0.5).fellAsleep, 0);
  EXPECT_EQ(again.system.measure().awakeGrains, 0);
}

TEST(Sleep, SavedSleepersWakeWithWhatTheyRemembered) {
  Scene scene(true);
  scene.addBed(4);
  scene.run(1.0);
  Scene again = resumed(scene, 4);
  std::vector<ContactView> contacts[2];
  for (Scene* s : {&scene, &again}) {
    s->system.wakeAll();
    s->system.readContacts(contacts[s == &again]);
  }
  ASSERT_EQ(contacts[0].size(), contacts[1].size());
  for (std::size_t i = 0; i < contacts[0].size(); ++i) EXPECT_EQ(contacts[0][i].force, contacts[1][i].force);
}

TEST(Sleep, RunThatGoesOnFromAStateFallsAsleepWhenTheOneThatNeverStoppedDoes) {
  // Equal sub-steps, as step control begins anew, and balls that do not turn, whose spin would be rounded.
  // The state is saved when they have rested for a part of restTime: without what is kept of that the second
  // one would rest for all of it once more.
  const auto prepare = [](Scene& scene) {
    scene.system.setIntegrator({.fixedSubStep = 2e-4});
    scene.system.setSleep({.enabled = true, .restTime = 0.08});
  };
  Scene scene(true);
  prepare(scene);
  for (const double x : {-0.1, 0.1}) scene.grains.push_back(scene.addBall({x, kRadius + 1e-5 * (x > 0), 0}));
  for (int i = 0; i < 11; ++i) scene.system.step(0.005);
  Scene again(true);
  prepare(again);
  for (const double x : {-0.1, 0.1}) again.grains.push_back(again.addBall({x, kRadius, 0}));
  for (const GrainId id : again.grains) {
    again.system.setGrainMotion(id, scene.system.grainMotions()[id.index]);
  }
  again.system.setContactMemory(scene.system.contactMemory());
  again.system.setSleepState(scene.system.sleepState());
  ASSERT_EQ(scene.system.measure().awakeGrains, 2);
  for (int i = 0; i < 60; ++i) {
    EXPECT_EQ(scene.system.step(0.005).awakeGrains, again.system.step(0.005).awakeGrains) << i;
    for (const GrainId id : scene.grains) {
      EXPECT_EQ(scene.system.grainMotions()[id.index].pose.position,
                again.system.grainMotions()[id.index].pose.position);
    }
  }
  EXPECT_EQ(scene.system.measure().awakeGrains, 0);
}

TEST(Sleep, SavedStateIsRefusedIfItIsNotFinite) {
  Scene scene(true);
  scene.addBall({0, kRadius, 0});
  scene.run(1.0);
  SleepState state = scene.system.sleepState();
  ASSERT_EQ(state.frozen.size(), 1u);
  state.frozen[0].force.x() = NAN;
  EXPECT_THROW(scene.system.setSleepState(state), std::invalid_argument);
  state = scene.system.sleepState();
  state.resters.emplace_back().seconds = -1.0;
  EXPECT_THROW(scene.system.setSleepState(state), std::invalid_argument);
}

/// A push that is over before it has moved anything for good is held; the same push kept up is not.
TEST(Sleep, BriefPushIsHeldALastingOneWakes) {
  Scene scene(true);
  const GrainId sleeper = scene.addBall({0, kRadius, 0});
  scene.run(1.0);
  ASSERT_FALSE(scene.system.isAwake(sleeper));
  // Weightless and light, it comes down on the sleeper at 0.1 m/s and bounces: an impulse of at most
  // 2 m v = 2e-3 of the sleeper's m at 0.1 m/s, of the weight over restTime: 2e-4.
  const double mass = 1e-3 * scene.system.massOf(sleeper);
  const BodyId hammer =
      scene.system.addBody({.motion = BodyMotion::Dynamic,
                            .covering = {.positions = {Vector3::Zero()}, .radii = {kRadius}},
                            .material = scene.stone,
                            .mass = mass,
                            .principalInertia = Vector3::Constant(mass * 4e-5),
                            .pose = {.position = {0, 3.01 * kRadius, 0}},
                            .velocity = {0, -0.1, 0},
                            .maySleep = false});
  scene.system.setBodyGravity(hammer, Vector3::Zero());
  double largest = 0.0;
  for (int i = 0; i < 50; ++i) {
    scene.system.step(2e-4);
    largest = std::max(largest, scene.system.contactWrench(hammer).force.norm());
    ASSERT_FALSE(scene.system.isAwake(sleeper));
  }
  EXPECT_GT(largest, 10.0 * SleepDef{}.wakeImbalance * scene.weight());
  ASSERT_GT(scene.system.bodyMotion(hammer).velocity.y(), 0.0);
  // Lying on it, a hundredth of its weight, it wakes it.
  scene.system.setBodyMotion(hammer, {.pose = {.position = {0, 3.0 * kRadius, 0}}});
  scene.system.setBodyGravity(hammer, {0, -10.0 * kGravity, 0});
  scene.run(SleepDef{}.restTime);
  EXPECT_TRUE(scene.system.isAwake(sleeper));
}

TEST(Sleep, ElasticEnergyCountsSleepers) {
  Scene scene(true), reference(false);
  for (Scene* s : {&scene, &reference}) s->addBed(4);
  const StepReport asleep = scene.run(1.0), awake = reference.run(1.0);
  ASSERT_EQ(asleep.awakeGrains, 0);
  EXPECT_NEAR(asleep.energy.elastic, awake.energy.elastic, 0.005 * awake.energy.elastic);
  EXPECT_NEAR(asleep.energy.potential, awake.energy.potential, 1e-4 * awake.energy.potential);
  EXPECT_NEAR(asleep.meanOverlap, awake.meanOverlap, 0.005 * awake.meanOverlap);
}

TEST(Sleep, EnergyIsAccountedForWhileABallLandsOnSleepers) {
  Scene scene(true);
  scene.addBed(6);
  scene.run(1.0);
  scene.addBall({0, 8 * kRadius, 0}, {0, -0.5, 0});
  const StepReport before = scene.system.measure();
  const StepReport after = scene.run(1.0);
  const double moved = before.energy.total() - after.energy.total();
  EXPECT_NEAR(after.dissipated - before.dissipated, moved, 0.01 * moved);  // the integrator's share
}

/// Impulse of gravity and of floor and walls that count it, against the momentum that is there and that
/// sleepers hold.
TEST(Sleep, MomentumIsAccountedForWhileABallLandsOnSleepers) {
  Scene scene(true);
  // What sleepers take up is summed by the trapezoidal rule: of a blow, half a sine in steps of at most 1.5
  // of these fractions, it misses (1.5 pi 0.05)^2 / 12 = 0.5 %.
  scene.system.setIntegrator({.contactTimeFraction = 0.05});
  scene.system.removeBody(scene.floor);
  scene.held = BodyMotion::Kinematic;
  scene.floor = scene.addPlane({0, 0, 0}, Vector3::UnitY());
  scene.addBed(6);
  scene.walls.push_back(scene.floor);
  scene.run(1.0);
  scene.addBall({0, 8 * kRadius, 0}, {0, -0.5, 0});
  const StepReport before = scene.system.measure();
  ASSERT_LT(before.awakeGrains, 2);
  double impulse = 0.0;
  StepReport after;
  for (int i = 0; i < 12; ++i) {
    after = scene.system.step(kFrame);
    impulse -= scene.weight() * kFrame;
    for (const BodyId wall : scene.walls) impulse -= scene.system.contactImpulse(wall).force.y();
  }
  const double change = after.momentum.y() - before.momentum.y();
  const double held = after.heldImpulse.y() - before.heldImpulse.y();
  const double ball = scene.system.massOf(scene.grains[0]) * 0.5;
  EXPECT_NEAR(change + held, impulse, 0.01 * ball);
}

TEST(Sleep, BallThatLandsWakesOnlyWhatFeelsIt) {
  Scene scene(true);
  for (int heap = 0; heap < 6; ++heap) scene.addHeap({8.0 * heap * kRadius, 0, 0});
  scene.run(1.0);
  ASSERT_EQ(scene.system.measure().awakeGrains, 0);
  scene.addBall({0.1 * kRadius, 6 * kRadius, 0.1 * kRadius});
  std::int64_t mostAwake = 0;
  for (int i = 0; i < 15; ++i) mostAwake = std::max(mostAwake, scene.run(kFrame).awakeGrains);
  EXPECT_EQ(mostAwake, 1 + 5);
  for (std::size_t i = 5; i < scene.grains.size(); ++i) EXPECT_FALSE(scene.system.isAwake(scene.grains[i]));
}

TEST(Sleep, BallThatFliesOverSleepersWakesThoseThatItHits) {
  // It starts where a layout made about it holds none of those in its way, and hits the top of the last heap.
  constexpr double kTime = 0.1, kFar = 0.8;  // s, m
  Scene scene(true);
  for (int heap = 0; heap < 6; ++heap) scene.addHeap({8.0 * heap * kRadius, 0, 0});
  scene.addHeap({kFar, 0, 0});
  scene.run(1.0);
  ASSERT_EQ(scene.system.measure().awakeGrains, 0);
  const double top = (1.0 + std::sqrt(2.0)) * kRadius;
  const GrainId ball = scene.addBall({0, top + 0.5 * kGravity * kTime * kTime, 0}, {kFar / kTime, 0, 0});
  for (int i = 0; i < 12; ++i) scene.system.step(0.01);
  EXPECT_LT(scene.system.grainMotions()[ball.index].velocity.x(), 0.9 * kFar / kTime);
  EXPECT_TRUE(scene.system.isAwake(scene.grains.back()));
  for (std::size_t i = 0; i < 30; ++i) EXPECT_FALSE(scene.system.isAwake(scene.grains[i]));
}

TEST(Sleep, BallLandingOnSleepersRestsWhereItRestsOnAwakeOnes) {
  double height[2];
  for (const bool sleeps : {false, true}) {
    Scene scene(sleeps);
    scene.addBed(5);
    scene.run(1.0);
    const GrainId ball = scene.addBall({kRadius, 5 * kRadius, kRadius});
    scene.run(1.5);
    height[sleeps] = scene.system.grainMotions()[ball.index].pose.position.y();
  }
  EXPECT_NEAR(height[1], height[0], 1e-3 * kRadius);
}

TEST(Sleep, ExactBodyDoesNotSinkIntoSleepers) {
  // A ball without particles: only the grains' particles meet it, and sleepers have none in the search.
  double height[2];
  for (const bool sleeps : {false, true}) {
    Scene scene(sleeps);
    scene.addBed(5);
    scene.run(1.0);
    const double r = 3 * kRadius, mass = 2500.0 * 4.0 / 3.0 * M_PI * r * r * r;
    const BodyId ball = scene.system.addBody({.motion = BodyMotion::Dynamic,
                                              .exact = ExactSphere{r},
                                              .material = scene.stone,
                                              .mass = mass,
                                              .principalInertia = Vector3::Constant(0.4 * mass * r * r),
                                              .pose = {.position = {0, 8 * kRadius, 0}}});
    scene.run(2.0);
    height[sleeps] = scene.system.bodyMotion(ball).pose.position.y();
    EXPECT_EQ(scene.system.isAwake(ball), !sleeps);
  }
  EXPECT_NEAR(height[1], height[0], 1e-2 * kRadius);
}

TEST(Sleep, KinematicBodyPushesSleepersAhead) {
  Scene scene(true);
  scene.system.setIntegrator({.tolerance = 1e-3});
  const GrainId grain = scene.addBall({0, kRadius, 0});
  const BodyId blade = scene.system.addBody({.motion = BodyMotion::Kinematic,
                                             .exact = ExactBox{{kRadius, 5 * kRadius, 5 * kRadius}},
                                             .material = scene.stone,
                                             .pose = {.position = {-5 * kRadius, 5 * kRadius, 0}}});
  scene.run(0.5);
  ASSERT_FALSE(scene.system.isAwake(grain));
  scene.system.setBodyMotion(blade,
                             {.pose = scene.system.bodyMotion(blade).pose, .velocity = {10 * kRadius, 0, 0}});
  scene.run(0.6);  // its face is then at 2 radii
  EXPECT_TRUE(scene.system.isAwake(grain));
  EXPECT_GT(scene.system.grainMotions()[0].pose.position.x(), 2.9 * kRadius);
}

TEST(Sleep, StaticBodyPutIntoSleepersWakesThem) {
  Scene scene(true);
  const GrainId grain = scene.addBall({0, kRadius, 0});
  const BodyId wall = scene.system.addBody({.exact = ExactBox{{kRadius, kRadius, kRadius}},
                                            .material = scene.stone,
                                            .pose = {.position = {-9 * kRadius, kRadius, 0}}});
  scene.run(1.0);
  ASSERT_FALSE(scene.system.isAwake(grain));
  scene.system.setBodyMotion(wall, {.pose = {.position = {-1.9 * kRadius, kRadius, 0}}});
  scene.run(0.1);
  EXPECT_TRUE(scene.system.isAwake(grain));
  EXPECT_GT(scene.system.grainMotions()[0].velocity.x(), 0.0);
}

/// Load at which a cube of eight balls, pushed at half its height, has slid by a tenth of a radius.
double loadThatMovesACube(bool sleeps) {
  Scene scene(sleeps);
  const GrainShapeId shape = scene.system.addGrainShape(cubeShape(kRadius));
  const GrainId cube = scene.system.addGrain(
      {.shape = shape, .material = scene.stone, .pose = {.position = {0, 2 * kRadius, 0}}});
  const double limit = kFriction * scene.system.massOf(cube) * kGravity;
  const MaterialId smooth = scene.system.addMaterial({.friction = 0.0});
  Covering face{.radii = std::vector<double>(4, kRadius)};  // a particle against each of the side's four
  for (const double y : {-kRadius, kRadius}) {
    for (const double z : {-kRadius, kRadius}) face.positions.push_back({0, y, z});
  }
  const BodyId pusher = scene.system.addBody({.motion = BodyMotion::Dynamic,
                                              .covering = face,
                                              .material = smooth,
                                              .mass = 0.01,
                                              .principalInertia = Vector3::Constant(1e-6),
                                              .pose = {.position = {-3 * kRadius, 2 * kRadius, 0}},
                                              .linearFactor = Vector3::UnitX(),
                                              .angularFactor = Vector3::Zero(),
                                              .maySleep = false});
  for (const double part : {0.2, 0.4, 0.6, 0.8}) {
    scene.system.setBodyLoad(pusher, {.force = {part * limit, 0, 0}});
    scene.run(0.25);
  }
  const double start = scene.system.grainMotions()[cube.index].pose.position.x();

  for (double load = 0.9 * limit; load < 1.1 * limit; load += 0.002 * limit) {
    scene.system.setBodyLoad(pusher, {.force = {load, 0, 0}});
    scene.run(0.25);
    if (scene.system.grainMotions()[cube.index].pose.position.x() - start > 0.1 * kRadius)
      return load / limit;
  }
  return 0.0;
}

TEST(Sleep, SleeperSlidesAtTheLimitOfFriction) {
  const double awake = loadThatMovesACube(false), asleep = loadThatMovesACube(true);
  EXPECT_NEAR(awake, 1.0, 0.02);  // just above the limit it takes its time
  // It carries its weight, the friction and the push, 1.6 m g in all, and holds wakeImbalance of it.
  EXPECT_NEAR(asleep, awake, 0.002 + SleepDef{}.wakeImbalance * 1.62 / kFriction);
}

TEST(Sleep, SameBitsForAnyNumberOfThreads) {
  std::vector<Vector3> places[2];
  for (const int threads : {1, 3}) {
    Scene scene(true, {0, -kGravity, 0}, threads);
    scene.addBed(5);
    EXPECT_GT(scene.run(1.0).frozenContacts, 20);
    scene.addBall(inAHollow(-2, -2));
    EXPECT_GT(scene.system.step(2e-3).frozenContacts, 0);
    scene.run(0.3);
    EXPECT_GT(scene.system.measure().awakeGrains, 1);
    for (const RigidMotion& m : scene.system.grainMotions()) places[threads > 1].push_back(m.pose.position);
  }
  ASSERT_EQ(places[0].size(), places[1].size());
  EXPECT_EQ(std::memcmp(places[0].data(), places[1].data(), places[0].size() * sizeof(Vector3)), 0);
}

TEST(Sleep, SleepingSceneTakesOneSubStep) {
  Scene scene(true);
  scene.addBed(4);
  scene.run(1.0);
  EXPECT_EQ(scene.run(kFrame).subSteps, 1);
}

TEST(Sleep, BodyFallsAsleepOnGrains) {
  Scene scene(true);
  scene.addBed(4);
  const BodyId plate = scene.system.addBody({.motion = BodyMotion::Dynamic,
                                             .exact = ExactBox{{3 * kRadius, kRadius, 3 * kRadius}},
                                             .material = scene.stone,
                                             .mass = 0.05,
                                             .principalInertia = Vector3::Constant(1e-5),
                                             .pose = {.position = {0, 4.5 * kRadius, 0}}});
  const StepReport report = scene.run(2.0);
  EXPECT_EQ(report.awakeBodies, 0);
  EXPECT_EQ(report.awakeGrains, 0);
  EXPECT_NEAR(scene.system.contactImpulse(plate).force.y(), 0.05 * kGravity * kFrame, 1e-12);
  scene.system.setBodyLoad(plate, {.force = {0, 1, 0}});
  EXPECT_TRUE(scene.system.isAwake(plate));
  scene.run(0.2);
  EXPECT_GT(scene.system.bodyMotion(plate).velocity.y(), 0.0);
}

TEST(Sleep, SettingsOutOfRangeAreRefused) {
  GranularSystem system;
  EXPECT_THROW(system.setSleep({.restTime = 0.0}), std::invalid_argument);
  EXPECT_THROW(system.setSleep({.restWay = -1.0}), std::invalid_argument);
  EXPECT_THROW(system.setSleep({.balance = 0.01, .wakeImbalance = 0.001}), std::invalid_argument);
}

}  // namespace
}  // namespace granular
