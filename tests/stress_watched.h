// SPDX-License-Identifier: MIT
// A system that is watched while it runs: what the scenes of the stress matrix are built of.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "granular/base/random.h"
#include "granular/granular.h"
#include "tests/stress_cases.h"

namespace granular::stress {

inline constexpr double kRadius = 0.01, kDensity = 2500.0, kGravity = 9.81;
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline const Vector3 kNone = Vector3::Zero();

inline double ballMass(double radius = kRadius, double density = kDensity) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * density;
}

/// A system that is watched while it runs.
struct Watched {
  explicit Watched(const SystemDef& def, const MaterialDef& material = {.density = kDensity})
      : system(def), stone(system.addMaterial(material)), ball(system.addGrainShape(sphereShape(kRadius))) {}

  GrainId addBall(const Vector3& at, const Vector3& velocity = kNone, double scale = 1.0) {
    return system.addGrain(
        {.shape = ball, .material = stone, .pose = {.position = at}, .velocity = velocity, .scale = scale});
  }
  BodyId addFloor(BodyMotion motion = BodyMotion::Static) {
    return system.addBody({.motion = motion, .exact = HalfSpace{}, .material = stone});
  }
  void addWalls(double half) {
    for (const Vector3& inward : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 0, 1), Vector3(0, 0, -1)}) {
      system.addBody({.exact = HalfSpace{},
                      .material = stone,
                      .pose = {-half * inward, Quaternion::FromTwoVectors(Vector3::UnitY(), inward)}});
    }
  }
  /// n x n x layers balls just apart, a little out of line so that friction has something to hold.
  void addBlock(int n, int layers, double spacing = 2.02 * kRadius) {
    Random random(5);
    for (int i = 0; i < n * n * layers; ++i) {
      const Vector3 site(i % n - 0.5 * (n - 1), i / (n * n) + 0.52, i / n % n - 0.5 * (n - 1));
      const Vector3 offset(random.uniform(-0.4, 0.4), 0.0, random.uniform(-0.4, 0.4));
      addBall(spacing * site + (spacing - 2.0 * kRadius) * offset);
    }
  }

  /// Before the first step, unless run() comes first.
  void begin() {
    const StepReport report = system.measure();
    startEnergy = energyOf(report);
    startMomentum = report.momentum;
    highestEnergy = startEnergy;
    begun = true;
  }
  static double energyOf(const StepReport& report) {
    return report.energy.total() - report.workByMovedBodies - report.workByLoads;
  }
  void step(double dt) {
    if (!begun) begin();
    const StepReport report = system.step(dt);
    outcome.largestOverlap = std::max(outcome.largestOverlap, report.largestOverlap);
    highestEnergy = std::max(highestEnergy, energyOf(report));
    outcome.flags = outcome.flags | report.flags;
    if (outcome.shortestSubStep == 0.0 || report.shortestSubStep < outcome.shortestSubStep) {
      outcome.shortestSubStep = report.shortestSubStep;
    }
    last = report;
  }
  void run(double time, double dt) {
    for (int i = 0; i < static_cast<int>(std::lround(time / dt)); ++i) step(dt);
  }
  Outcome end(double measured) {
    outcome.measured = measured;
    if (startEnergy > 0.0) outcome.energyRatio = highestEnergy / startEnergy;
    double sum = 0.0;
    for (std::int32_t g = 0; g < static_cast<std::int32_t>(system.grainMotions().size()); ++g) {
      const RigidMotion& m = system.grainMotions()[g];
      const GrainId id = system.grainAt(g);
      if (id.index < 0) continue;
      outcome.notFinite += !(m.pose.position.allFinite() && m.velocity.allFinite());
      sum += system.massOf(id) * m.velocity.norm();
    }
    for (const BodyId id : system.bodies()) {
      if (system.bodyMotionType(id) != BodyMotion::Dynamic) continue;
      const RigidMotion m = system.bodyMotion(id);
      outcome.notFinite += !(m.pose.position.allFinite() && m.velocity.allFinite());
      sum += system.bodyDef(id).mass * m.velocity.norm();
    }
    const bool isClosed = system.gravity().isZero() && system.bodyCount() == 0;
    if (isClosed && sum > 0.0) outcome.momentumDrift = (last.momentum - startMomentum).norm() / sum;
    return outcome;
  }

  GranularSystem system;
  MaterialId stone;
  GrainShapeId ball;
  Outcome outcome;
  StepReport last;
  double startEnergy = 0.0, highestEnergy = -kInfinity;
  Vector3 startMomentum = kNone;
  bool begun = false;
};

}  // namespace granular::stress
