// SPDX-License-Identifier: MIT
// Sleep is neutral: heaps of tetrahedra that settled with sleep on and off have the same shape, press the
// floor alike and slide at the same tilt, under law 19.
//
// When one heap slides is chaos: with one grain let fall 1e-12 radii aside, and no sleep at all, one in four
// slides four degrees sooner. So tilts are compared on average, and that is the measure of their scatter.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>

#include "granular/base/random.h"
#include "granular/granular.h"

namespace granular {
namespace {

constexpr double kRadius = 0.01, kGravity = 9.81, kFrame = 1.0 / 60.0;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kTiltStep = 0.5;  // degrees
constexpr double kAside = 1e-12;   // radii
constexpr std::uint64_t kHeaps = 12;

/// 64 tetrahedra let fall onto a floor of particles.
struct Heap {
  Heap(bool sleeps, std::uint64_t seed, double aside = 0.0)
      : system(
            {.integrator = {.stepper = Stepper::Leapfrog, .tolerance = 1e-3}, .sleep = {.enabled = sleeps}}) {
    const MaterialId stone = system.addMaterial({});
    system.setMaterialPair(stone, stone, {.shear = {.law = ShearLaw::StaticFriction}});
    Covering covering;
    for (int i = 0; i < 45 * 45; ++i)
      covering.positions.push_back(kRadius * Vector3(i % 45 - 22, -0.5, i / 45 - 22));
    covering.radii.assign(covering.positions.size(), 0.5 * kRadius);
    floor = system.addBody({.covering = covering, .material = stone});
    const GrainShapeId shape = system.addGrainShape(tetrahedronShape(0.5 * kRadius));
    Random random(seed);
    for (int i = 0; i < 64; ++i) {
      const Vector3 site(i % 4 - 1.5, 0.0, i / 4 % 4 - 1.5);
      const Vector3 at = kRadius * (2.3 * site + Vector3(i == 0 ? aside : 0.0, 1.2 + 2.2 * (i / 16), 0));
      weight += kGravity * system.massOf(system.addGrain(
                               {.shape = shape, .material = stone, .pose = {at, random.rotation()}}));
    }
  }

  std::int64_t run(double seconds) {
    StepReport report;
    for (int i = 0; i < static_cast<int>(std::lround(seconds / kFrame)); ++i) report = system.step(kFrame);
    return report.awakeGrains;
  }
  Vector3 middle() const {
    Vector3 sum = Vector3::Zero();
    for (const RigidMotion& m : system.grainMotions()) sum += m.pose.position;
    return sum / static_cast<double>(system.grainMotions().size());
  }
  /// Of the cone with the same mean height and mean distance from its axis, degrees.
  double angle() const {
    double distance = 0.0;
    for (const RigidMotion& m : system.grainMotions()) {
      const Vector3 away = m.pose.position - middle();
      distance += std::hypot(away.x(), away.z()) / static_cast<double>(system.grainMotions().size());
    }
    return std::atan(2.0 * middle().y() / distance) / kDegree;
  }
  double forceOnFloor() { return -system.contactWrench(floor).force.y() / weight; }
  /// Tilt at which it has slid by a third of a radius, degrees.
  double tiltItSlidesAt() {
    const Vector3 start = middle();
    for (double tilt = kTiltStep; tilt < 45.0; tilt += kTiltStep) {
      system.setGravity(kGravity * Vector3(std::sin(tilt * kDegree), -std::cos(tilt * kDegree), 0));
      run(0.15);
      if ((middle() - start).norm() > 0.3 * kRadius) return tilt;
    }
    return 45.0;
  }

  GranularSystem system;
  BodyId floor;
  double weight = 0.0;  // N
};

/// Differences of two sets of heaps, each from the same seeds: their mean, and its standard error.
struct Mean {
  void add(double difference) {
    sum += difference;
    sumOfSquares += difference * difference;
    ++count;
  }
  double mean() const { return sum / count; }
  double error() const { return std::sqrt((sumOfSquares - count * mean() * mean()) / (count - 1.0) / count); }
  double sum = 0.0, sumOfSquares = 0.0;
  int count = 0;
};

TEST(SleepNeutrality, HeapsHaveTheSameAngleFloorForceAndThreshold) {
  Mean bySleep, byChance;
  for (std::uint64_t seed = 1; seed <= kHeaps; ++seed) {
    Heap awake(false, seed), asleep(true, seed), aside(false, seed, kAside);
    awake.run(3.0);
    aside.run(3.0);
    EXPECT_LT(asleep.run(3.0), 4);
    EXPECT_NEAR(asleep.angle(), awake.angle(), 0.3);
    EXPECT_NEAR(asleep.forceOnFloor(), awake.forceOnFloor(), 0.005);
    const double tilt = awake.tiltItSlidesAt();
    bySleep.add(asleep.tiltItSlidesAt() - tilt);
    byChance.add(aside.tiltItSlidesAt() - tilt);
  }
  // A sleeper on a slope of tan 0.5 holds wakeImbalance of all forces on it, 1.6 weights; that is its share
  // of the pull along the slope.
  const double held = SleepDef{}.wakeImbalance * 1.6 / (1.0 + 0.5 * 0.5) / kDegree;
  EXPECT_LE(std::abs(bySleep.mean()), held + 2.0 * byChance.error())
      << "sleep " << bySleep.mean() << " +- " << bySleep.error() << ", chance " << byChance.mean() << " +- "
      << byChance.error() << " degrees";
}

}  // namespace
}  // namespace granular
