// SPDX-License-Identifier: MIT
#include "tests/stress_scenes.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <string>

#include "granular/base/random.h"
#include "granular/granular.h"

namespace granular::stress {
namespace {

constexpr double kRadius = 0.01, kDensity = 2500.0, kGravity = 9.81;
constexpr int kSwingSteps = 2000;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const Vector3 kNone = Vector3::Zero();

double ballMass(double radius = kRadius, double density = kDensity) {
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

}  // namespace

// ---- stiffness and steps

Outcome swing(Stepper stepper, double frequencyTimesStep) {
  const double k = 1e4, m = ballMass(), frequency = std::sqrt(k / m), step = frequencyTimesStep / frequency;
  // Pressed so hard that it never lets go.
  const double press = 300.0 * kGravity, rest = m * press / k, first = 1e-3 * rest;
  Watched scene({.gravity = {0, -press, 0}, .integrator = {.stepper = stepper, .fixedSubStep = step}},
                {.density = kDensity, .restitution = 1.0, .friction = 0.0});
  scene.system.setMaterialPair(scene.stone, scene.stone,
                               {.normal = {.law = NormalLaw::LinearSpring, .stiffness = k, .damping = 0.0}});
  scene.addFloor();
  const GrainId ball = scene.addBall({0, kRadius - rest + first, 0});
  double largest = 0.0;
  for (int i = 0; i < kSwingSteps; ++i) {
    scene.step(step);
    const double away = scene.system.grainMotions()[ball.index].pose.position.y() - (kRadius - rest);
    largest = std::max(largest, std::abs(away));
    if (largest > 100.0 * first) break;
  }
  return scene.end(largest / first);
}

Outcome row(Stepper stepper, double boundsPerStep) {
  constexpr int kBalls = 20;
  constexpr double kOverlap = 1e-3 * kRadius, kSpeed = 1e-6, kStiffness = 1e4;
  const double step =
      boundsPerStep * 2.0 / std::sqrt(2.0 * 2.0 * kStiffness / ballMass());  // two contacts a ball
  Watched scene({.gravity = kNone, .integrator = {.stepper = stepper, .fixedSubStep = step}},
                {.density = kDensity, .restitution = 1.0, .friction = 0.0});
  scene.system.setMaterialPair(
      scene.stone, scene.stone,
      {.normal = {.law = NormalLaw::LinearSpring, .stiffness = kStiffness, .damping = 0.0}});
  const double spacing = 2.0 * kRadius - kOverlap, half = 0.5 * kBalls * spacing;
  for (const double side : {-1.0, 1.0}) {
    scene.system.addBody({.exact = HalfSpace{},
                          .material = scene.stone,
                          .pose = {side * (half - 0.5 * kOverlap) * Vector3::UnitX(),
                                   Quaternion::FromTwoVectors(Vector3::UnitY(), Vector3(-side, 0, 0))}});
  }
  for (int i = 0; i < kBalls; ++i) {  // each against its neighbours: nearly the fastest mode
    const double speed = i % 2 == 0 ? kSpeed : -kSpeed;
    scene.addBall({(i + 0.5) * spacing - half, 0, 0}, {speed, 0, 0});
  }
  double largest = 0.0;
  for (int i = 0; i < 300 && largest < 1e3 * kSpeed; ++i) {
    scene.step(step);
    for (const RigidMotion& motion : scene.system.grainMotions())
      largest = std::max(largest, motion.velocity.norm());
  }
  return scene.end(largest / kSpeed);
}

namespace {

/// A ball that slides on a plane, under law 18 on a linear spring without damping.
struct Slide {
  static constexpr double kStiffness = 1e4, kPress = 300.0 * kGravity, kSpeed = 1e-4;
  static double contactTime() { return std::numbers::pi * std::sqrt(ballMass() / kStiffness); }
  static double arm() { return kRadius - ballMass() * kPress / kStiffness; }

  /// rate: kt (1/m + arm^2/I), 1/s
  Slide(const IntegratorDef& integrator, double rate)
      : scene({.gravity = {0, -kPress, 0}, .integrator = integrator},
              {.density = kDensity, .restitution = 1.0, .friction = 1e6}) {
    const double inertia = 0.4 * ballMass() * kRadius * kRadius;
    const double viscosity = rate / (1.0 / ballMass() + arm() * arm() / inertia);
    scene.system.setMaterialPair(
        scene.stone, scene.stone,
        {.normal = {.law = NormalLaw::LinearSpring, .stiffness = kStiffness, .damping = 0.0},
         .shear = {.viscosity = viscosity}});
    scene.addFloor();
    ball = scene.addBall({0, arm(), 0}, {kSpeed, 0, 0});
  }
  double slip() const {
    const RigidMotion& motion = scene.system.grainMotions()[ball.index];
    return std::abs(motion.velocity.x() + arm() * motion.angularVelocity.z());
  }

  Watched scene;
  GrainId ball;
};

}  // namespace

Outcome slide(Stepper stepper, double rateTimesStep) {
  const double step = 0.02 * Slide::contactTime();
  Slide slide({.stepper = stepper, .fixedSubStep = step}, rateTimesStep / step);
  double largest = 0.0;
  for (int i = 0; i < 300 && largest < 1e3 * Slide::kSpeed; ++i) {
    slide.scene.step(step);
    largest = std::max(largest, slide.slip());
  }
  return slide.scene.end(largest / Slide::kSpeed);
}

Outcome slideOfItself(Stepper stepper) {
  const double rate = 1000.0 / Slide::contactTime();
  Slide slide({.stepper = stepper, .tolerance = 1.0}, rate);
  double longest = 0.0;
  for (int i = 0; i < 3; ++i) {
    slide.scene.step(0.1 * Slide::contactTime());
    longest = std::max(longest, slide.scene.last.longestSubStep);
  }
  return slide.scene.end(longest * rate);
}

namespace {

/// Growth of y' = z y by one step: Fehlberg 1969, the answer of fifth order.
std::complex<double> stabilityOfRkf45(std::complex<double> z) {
  std::complex<double> sum = 0.0;
  for (const double c : {1.0 / 2080, 1.0 / 120, 1.0 / 24, 1.0 / 6, 1.0 / 2, 1.0, 1.0}) sum = sum * z + c;
  return sum;
}

}  // namespace

Outcome growthByRkf45(double frequencyTimesStep) {
  Outcome outcome = swing(Stepper::Rkf45, frequencyTimesStep);
  outcome.measured /= std::pow(std::abs(stabilityOfRkf45({0.0, frequencyTimesStep})), kSwingSteps);
  return outcome;
}

double largestRateByRkf45() {
  double low = 2.0, high = 5.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (std::abs(stabilityOfRkf45(-middle)) <= 1.0 ? low : high) = middle;
  }
  return low;
}

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
