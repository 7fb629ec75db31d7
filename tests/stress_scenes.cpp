// SPDX-License-Identifier: MIT
#include "tests/stress_scenes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "tests/stress_watched.h"

namespace granular::stress {

double advisedModulus(double speed) {
  Watched scene({}, {.density = kDensity, .youngsModulus = 1e7});
  for (const double x : {0.0, 1.0}) scene.addBall({x, 0, 0});  // two that may meet
  const std::string before = "youngsModulus of ", after = " Pa in place of ";
  for (const std::string& line : scene.system.advice(speed)) {
    const std::size_t end = line.find(after);
    if (line.find(before) == std::string::npos || end == std::string::npos) continue;
    return std::stod(line.substr(line.rfind(' ', end - 1) + 1));
  }
  return 0.0;
}

Outcome rebound(double youngsModulus, double speed) {
  constexpr double frame = 1e-4;
  Watched scene({.gravity = kNone},
                {.density = kDensity, .youngsModulus = youngsModulus, .restitution = 0.5});
  scene.system.setMaterialPair(scene.stone, scene.stone, {.restitutionSpeed = speed});
  scene.addFloor();
  const GrainId ball = scene.addBall({0, kRadius + 0.37 * speed * frame, 0}, {0, -speed, 0});
  for (int i = 0; i < 100000 && scene.system.grainMotions()[ball.index].velocity.y() <= 0.0; ++i) {
    scene.step(frame);
  }
  while (scene.last.contacts > 0) scene.step(frame);
  return scene.end(scene.system.grainMotions()[ball.index].velocity.y() / speed);
}

Outcome riseAfterDrop(Stepper stepper, double tolerance) {
  Watched scene({.integrator = {.stepper = stepper, .tolerance = tolerance}});
  scene.addFloor();
  const double start = 3.0 * kRadius;
  const GrainId ball = scene.addBall({0, start, 0});
  double highest = 0.0;
  for (int i = 0; i < 300; ++i) {
    scene.step(1.0 / 240.0);
    highest = std::max(highest, scene.system.grainMotions()[ball.index].pose.position.y());
  }
  return scene.end((highest - start) / kRadius);
}

Outcome millionSteps(Stepper stepper) {
  const double step = 2e-5;
  Watched scene({.integrator = {.stepper = stepper, .fixedSubStep = step}});
  scene.system.setMaterialPair(scene.stone, scene.stone, {.shear = {.law = ShearLaw::StaticFriction}});
  scene.addFloor();
  const GrainId ball = scene.addBall({0, kRadius, 0});
  scene.run(1.0, 0.1);
  const Vector3 before = scene.system.grainMotions()[ball.index].pose.position;
  scene.run(1e6 * step, 0.5);
  return scene.end((scene.system.grainMotions()[ball.index].pose.position - before).norm() / kRadius);
}

Outcome bounceAtFrames(double frame) {
  Watched scene({});
  scene.addFloor();
  const GrainId ball = scene.addBall({0, 10.0 * kRadius, 0});
  scene.run(0.2, frame);
  return scene.end(scene.system.grainMotions()[ball.index].pose.position.y() / kRadius);
}

// ---- masses and sizes

Outcome heavyBody() {
  const double mass = 1e6 * ballMass(), r = 10.0 * kRadius;
  Watched scene({.gravity = kNone});
  const GrainId grain = scene.addBall(kNone);
  scene.system.addBody({.motion = BodyMotion::Dynamic,
                        .covering = {.positions = {kNone}, .radii = {r}},
                        .material = scene.stone,
                        .mass = mass,
                        .principalInertia = Vector3::Constant(0.4 * mass * r * r),
                        .pose = {.position = {-(r + kRadius) * 1.001, 0, 0}},
                        .velocity = {1, 0, 0}});
  scene.run(0.02, 1e-3);
  Outcome outcome = scene.end(scene.system.grainMotions()[grain.index].velocity.x() / 1.5);
  outcome.momentumDrift = (scene.last.momentum - scene.startMomentum).norm() / mass;
  return outcome;
}

Outcome unequal(double radiusRatio, double densityRatio, double youngsModulus) {
  Watched scene({.integrator = {.tolerance = 1e-3}}, {.density = kDensity, .youngsModulus = youngsModulus});
  const MaterialId heavy =
      scene.system.addMaterial({.density = kDensity * densityRatio, .youngsModulus = youngsModulus});
  scene.addFloor();
  const double half = std::max(3.0, 1.1 * radiusRatio) * kRadius;
  scene.addWalls(half);
  const int n = static_cast<int>(2.0 * half / (2.02 * kRadius));
  scene.addBlock(n, 2);
  const double r = radiusRatio * kRadius;
  const GrainId big = scene.system.addGrain({.shape = scene.ball,
                                             .material = heavy,
                                             .pose = {.position = {0, 4.1 * kRadius + r, 0}},
                                             .scale = radiusRatio});
  scene.run(0.5, 0.01);
  Outcome outcome = scene.end(scene.last.energy.kinetic / (scene.system.massOf(big) * kGravity * r));
  for (const RigidMotion& m : scene.system.grainMotions()) outcome.escaped += m.pose.position.y() < 0.0;
  return outcome;
}

// ---- bad starts

Outcome letGo(double overlap) {
  Watched scene({.gravity = kNone});
  scene.addBall({0, 0, 0});
  scene.addBall({2.0 * kRadius * (1.0 - overlap), 0, 0});
  scene.run(0.1, 1e-3);
  return scene.end(scene.last.energy.kinetic / scene.startEnergy);
}

Outcome cloud(Stepper stepper) {
  Watched scene({.gravity = kNone, .integrator = {.stepper = stepper}});
  Random random(11);
  for (int i = 0; i < 64; ++i) {
    const Vector3 at = 3.0 * kRadius * Vector3(i % 4 - 1.5, i / 4 % 4 - 1.5, i / 16 - 1.5);
    const Vector3 jitter(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    scene.addBall(at, -20.0 * at + jitter);
  }
  scene.run(0.1, 0.01);
  const Outcome outcome = scene.end(0.0);
  Outcome result = outcome;
  result.measured = outcome.momentumDrift;
  return result;
}

// ---- speed

Outcome shots(double youngsModulus) {
  Watched scene({.gravity = kNone}, {.density = kDensity, .youngsModulus = youngsModulus});
  Covering covering;
  constexpr int kHalf = 30;
  for (int i = -kHalf; i <= kHalf; ++i) {
    for (int j = -kHalf; j <= kHalf; ++j) covering.positions.push_back(2.0 * kRadius * Vector3(i, 0, j));
  }
  covering.radii.assign(covering.positions.size(), kRadius);
  scene.system.addBody({.covering = covering, .material = scene.stone});
  for (int i = 0; i < 49; ++i) {  // at every place of a mesh of the lattice, far from one another
    const Vector3 place(i % 7 - 3, 0.0, i / 7 - 3);
    scene.addBall(kRadius * (16.0 * place + place / 3.0) + Vector3(0, 3 * kRadius, 0), {0, -100, 0});
  }
  scene.run(2e-3, 1e-4);
  Outcome outcome = scene.end(0.0);
  for (const RigidMotion& m : scene.system.grainMotions()) outcome.measured += m.pose.position.y() < 0.0;
  return outcome;
}

Outcome movingWall(double speed, double youngsModulus) {
  Watched scene({.gravity = kNone},
                {.density = kDensity, .youngsModulus = youngsModulus, .restitution = 0.5});
  scene.system.setMaterialPair(scene.stone, scene.stone,
                               {.restitutionSpeed = speed, .normal = {.law = NormalLaw::HertzTsuji}});
  const BodyId wall = scene.system.addBody({.motion = BodyMotion::Kinematic,
                                            .exact = ExactBox{Vector3(kRadius, 1, 1)},
                                            .material = scene.stone,
                                            .velocity = {speed, 0, 0}});
  const GrainId ball = scene.addBall({2.5 * kRadius, 0, 0});
  for (int i = 0; i < 200; ++i) scene.step(0.02 * kRadius / speed);
  const double past = scene.system.grainMotions()[ball.index].pose.position.x() -
                      scene.system.bodyMotion(wall).pose.position.x();
  Outcome outcome = scene.end(scene.system.grainMotions()[ball.index].velocity.x() / (1.5 * speed));
  outcome.escaped = past < 0.0;
  return outcome;
}

namespace {

Outcome restingBed(const ShearLawDef& shear, Stepper stepper, double youngsModulus, double time) {
  Watched scene({.integrator = {.stepper = stepper, .tolerance = 1e-3}},
                {.density = kDensity, .youngsModulus = youngsModulus});
  scene.system.setMaterialPair(scene.stone, scene.stone, {.shear = shear});
  scene.addFloor();
  scene.addWalls(3.3 * kRadius);
  scene.addBlock(3, 6, 2.15 * kRadius);
  scene.run(0.5 * time, 0.01);
  const double before = scene.last.energy.total() + scene.last.dissipated;
  scene.run(0.5 * time, 0.01);
  const double made = scene.last.energy.total() + scene.last.dissipated - before;
  return scene.end(std::max(made, scene.last.energy.kinetic) / (54.0 * ballMass() * kGravity * kRadius));
}

}  // namespace

Outcome bedAtRest(ShearLaw law, Stepper stepper, double youngsModulus) {
  return restingBed({.law = law}, stepper, youngsModulus, 1.5);
}

Outcome bedOfHugeViscosity(Stepper stepper) {
  constexpr double kModulus = 1e7;
  Watched usual({}, {.density = kDensity, .youngsModulus = kModulus});
  const double creep = usual.system.creepSpeed(usual.stone, usual.stone, ballMass(), kRadius);
  return restingBed({.viscosity = 100.0 * ballMass() * kGravity / creep}, stepper, kModulus, 0.6);
}

Outcome crystal(Stepper stepper) {
  constexpr int kAcross = 5, kLayers = 8;
  Watched scene({.integrator = {.stepper = stepper, .tolerance = 1e-3}});
  scene.system.setMaterialPair(scene.stone, scene.stone, {.shear = {.law = ShearLaw::StaticFriction}});
  scene.addFloor();
  scene.addWalls(kAcross * kRadius);
  Random random(1);
  for (int layer = 0; layer < kLayers; ++layer) {
    const int n = kAcross - layer % 2;
    for (int i = 0; i < n * n; ++i) {
      const Vector3 offset(random.uniform(-0.025, 0.025), 0.0, random.uniform(-0.025, 0.025));
      const Vector3 site(2 * (i % n) + 1 - n, 1.0 + layer * std::sqrt(2.0), 2 * (i / n) + 1 - n);
      scene.addBall(kRadius * (site + offset));
    }
  }
  scene.run(0.2, 0.02);
  const double before = scene.last.energy.total() + scene.last.dissipated;
  scene.run(0.4, 0.02);
  const double made = scene.last.energy.total() + scene.last.dissipated - before;
  return scene.end(made / (scene.system.grainCount() * ballMass() * kGravity * kRadius));
}

Outcome tooLongSteps() {
  Watched scene({.integrator = {.stepper = Stepper::Verlet, .fixedSubStep = 1e-3}},
                {.density = kDensity, .youngsModulus = 1e9});
  scene.addFloor();
  scene.addWalls(3.3 * kRadius);
  scene.addBlock(3, 6, 1.99 * kRadius);
  scene.run(0.05, 0.01);
  return scene.end(has(scene.outcome.flags, StepFlag::FixedSubStepTooLong) ? 1.0 : 0.0);
}

}  // namespace granular::stress
