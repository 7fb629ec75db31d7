// SPDX-License-Identifier: MIT
// Section 4: friction, rolling and stacks, under gravity. Inclines are level planes under tilted gravity.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include "granular/base/random.h"
#include "tests/verification/impact.h"
#include "tests/verification/stepper_settings.h"
#include "tests/verification/verification_case.h"

namespace granular::verification {
namespace {

constexpr char kSection[] = "friction, rolling, stacks";
constexpr double kGravity = 9.81;  // m/s^2

std::string text(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

std::string nameOf(ShearLaw law) {
  switch (law) {
    case ShearLaw::RegularisedCoulomb:
      return "law18";
    case ShearLaw::StaticFriction:
      return "law19";
    case ShearLaw::Coulomb:
      return "law17";
    case ShearLaw::Viscous:
      return "law16";
  }
  return "";
}

Vector3 tiltedGravity(double angle) {
  return kGravity * Vector3(std::sin(angle), -std::cos(angle), 0.0);
}

/// How a pair of these cases behaves: calms down fast, so that a state of rest is reached.
MaterialPairDef calmPair(ShearLaw law, double friction) {
  return {.restitution = 0.2,
          .restitutionSpeed = 0.02,
          .friction = friction,
          .shear = {.law = law,
                    .dampingRatio = law == ShearLaw::StaticFriction || law == ShearLaw::Coulomb ? 0.3 : 0.0}};
}

// ------------------------------------------------------------------------------------------------- inclines

enum class Rider { Block, Clump };

/// A flat thing on a plane: a covered block of nine particles, or a grain of four.
class Incline {
 public:
  Incline(Rider rider, const MaterialPairDef& pair, double radius, const IntegratorDef& integrator = {})
      : rider_(rider), radius_(radius), system_({.gravity = tiltedGravity(0.0), .integrator = integrator}) {
    const MaterialId stone = system_.addMaterial({.name = "stone", .density = 2500.0, .youngsModulus = 2e7});
    const MaterialId floor = system_.addMaterial({.name = "floor", .youngsModulus = 2e7});
    system_.setMaterialPair(stone, floor, pair);
    floorBody_ = addPlane(system_, floor);
    rider == Rider::Block ? addBlock(stone) : addClump(stone);
  }

  /// Gravity is turned to `angle` within `duration`, slowly enough to leave no swing.
  void tilt(double angle, double duration) {
    constexpr int kSteps = 100;
    for (int i = 1; i <= kSteps; ++i) {
      system_.setGravity(tiltedGravity(angle * i / kSteps));
      system_.step(duration / kSteps);
    }
  }
  void run(double duration, int steps = 50) {
    for (int i = 0; i < steps; ++i) system_.step(duration / steps);
  }
  RigidMotion motion() const {
    return rider_ == Rider::Block ? system_.bodyMotion(block_) : system_.grainMotions()[grain_.index];
  }
  double mass() const { return rider_ == Rider::Block ? blockMass() : system_.massOf(grain_); }
  GranularSystem& system() { return system_; }

 private:
  double blockMass() const { return 2500.0 * 216.0 * std::pow(radius_, 3); }

  void addBlock(MaterialId material) {
    Covering covering;
    for (int i = -1; i <= 1; ++i) {
      for (int k = -1; k <= 1; ++k) {
        covering.positions.push_back({4.0 * radius_ * i, -0.5 * radius_, 4.0 * radius_ * k});
        covering.radii.push_back(radius_);
      }
    }
    const double m = blockMass(), side = 10.0 * radius_, height = 2.0 * radius_;
    const double flat = m / 12.0 * (side * side + height * height);
    block_ = system_.addBody({.motion = BodyMotion::Dynamic,
                              .covering = covering,
                              .material = material,
                              .mass = m,
                              .principalInertia = {flat, m / 6.0 * side * side, flat},
                              .pose = {.position = {0.0, 1.5 * radius_, 0.0}}});
  }
  void addClump(MaterialId material) {
    GrainShapeDef shape{.name = "raft"};
    for (const double x : {-2.0, 2.0}) {
      for (const double z : {-2.0, 2.0})
        shape.particles.push_back({{x * radius_, 0.0, z * radius_}, radius_});
    }
    grain_ = system_.addGrain({.shape = system_.addGrainShape(shape),
                               .material = material,
                               .pose = {.position = {0.0, radius_, 0.0}}});
  }

  Rider rider_;
  double radius_;
  GranularSystem system_;
  BodyId floorBody_, block_;
  GrainId grain_;
};

/// At rest below the angle of friction, a = g (sin - mu cos) above.
std::vector<Check> inclineThreshold(Rider rider, ShearLaw law, double mu,
                                    const IntegratorDef& integrator = {}) {
  std::vector<Check> checks;
  const double radius = 0.01;
  for (const double part : {0.5, 0.95, 0.99}) {
    Incline incline(rider, calmPair(law, mu), radius, integrator);
    incline.run(0.2);
    incline.tilt(std::atan(part * mu), 0.3);
    incline.run(0.3);
    const Vector3 before = incline.motion().pose.position;
    incline.run(1.0);
    const double creep = (incline.motion().pose.position - before).norm() / radius;
    checks.push_back(absolute("creep at " + text(part) + " of the limit, R/s", 0.0, creep, 1e-6));
  }
  for (const double part : {1.01, 1.5}) {
    Incline incline(rider, calmPair(law, mu), radius, integrator);
    incline.run(0.2);
    const double angle = std::atan(part * mu);
    incline.tilt(angle, 0.3);
    incline.run(0.1);
    const double before = incline.motion().velocity.x();
    incline.run(0.3);
    const double acceleration = (incline.motion().velocity.x() - before) / 0.3;
    checks.push_back(relative("acceleration at " + text(part) + " of the limit, m/s^2",
                              kGravity * (std::sin(angle) - mu * std::cos(angle)), acceleration, 1e-3));
  }
  return checks;
}

/// Law 18 holds nothing at rest: m g sin / (sum of kt over the contacts), as long as none of them slides:
/// uphill ones carry less, here 0.85 of the mean at most.
std::vector<Check> creepOfLaw18(double viscosity) {
  std::vector<Check> checks;
  for (const double part : {0.3, 0.6}) {
    const double mu = 0.5, angle = std::atan(part * mu);
    MaterialPairDef pair = calmPair(ShearLaw::RegularisedCoulomb, mu);
    pair.shear.viscosity = viscosity;
    Incline incline(Rider::Clump, pair, 0.01, {.tolerance = 1e-7});
    incline.run(0.5);
    incline.tilt(angle, 0.3);
    incline.run(1.0);
    const double before = incline.motion().pose.position.x();
    incline.run(1.0);
    checks.push_back(relative("creep at " + text(part) + " of the limit, m/s",
                              incline.mass() * kGravity * std::sin(angle) / (4.0 * viscosity),
                              incline.motion().pose.position.x() - before, 1e-4));
  }
  return checks;
}

// -------------------------------------------------------------------------------------------- rolling
// spheres

/// One sphere, resting at its static overlap on the plane.
class Roller {
 public:
  Roller(ShearLaw law, double mu, double radius, double speed, double angle)
      : system_({.gravity = tiltedGravity(angle), .integrator = {.tolerance = 1e-6}}) {
    const MaterialDef def{.name = "ball", .density = 2500.0, .youngsModulus = 1e9};
    const MaterialId ball = system_.addMaterial(def), floor = system_.addMaterial(def);
    MaterialPairDef pair = calmPair(law, mu);
    pair.restitution = 0.5;
    system_.setMaterialPair(ball, floor, pair);
    addPlane(system_, floor);
    const double mass = massOf({.radius = radius, .density = 2500.0});
    const double kr = 4.0 / 3.0 * 1e9 / (2.0 * (1.0 - 0.09)) * std::sqrt(radius);
    const double overlap = std::pow(mass * kGravity * std::cos(angle) / kr, 2.0 / 3.0);
    grain_ = system_.addGrain({.shape = system_.addGrainShape(sphereShape(radius)),
                               .material = ball,
                               .pose = {.position = {0.0, radius - overlap, 0.0}},
                               .velocity = {speed, 0.0, 0.0}});
  }
  const RigidMotion& run(double duration) {
    system_.step(duration);
    return system_.grainMotions()[grain_.index];
  }

 private:
  GranularSystem system_;
  GrainId grain_;
};

std::vector<Check> rollingDown(ShearLaw law) {
  std::vector<Check> checks;
  const double mu = 0.2, radius = 0.01;
  for (const double part : {0.5, 0.95, 1.2}) {
    const double angle = std::atan(part * 3.5 * mu);
    Roller roller(law, mu, radius, 0.0, angle);
    const RigidMotion before = roller.run(0.05), after = roller.run(0.1);
    const double acceleration = (after.velocity.x() - before.velocity.x()) / 0.1;
    const double spinning = -(after.angularVelocity.z() - before.angularVelocity.z()) / 0.1 * radius;
    const bool rolls = part < 1.0;
    const double expected =
        rolls ? 5.0 / 7.0 * kGravity * std::sin(angle) : kGravity * (std::sin(angle) - mu * std::cos(angle));
    const std::string at = " at " + text(part) + " of 3.5 mu";
    checks.push_back(relative("acceleration, m/s^2" + at, expected, acceleration, 1e-3));
    checks.push_back(relative("R times that of spin, m/s^2" + at,
                              rolls ? expected : 2.5 * mu * kGravity * std::cos(angle), spinning, 1e-3));
  }
  return checks;
}

std::vector<Check> slippingSphere(ShearLaw law) {
  std::vector<Check> checks;
  for (const double mu : {0.1, 0.4}) {
    const double radius = 0.02, u0 = 0.6, rollsAt = 2.0 * u0 / (7.0 * mu * kGravity);
    Roller roller(law, mu, radius, u0, 0.0);
    const std::string with = ", mu = " + text(mu);
    const RigidMotion half = roller.run(0.5 * rollsAt);
    checks.push_back(relative("speed at half the time, m/s" + with, u0 - 0.5 * mu * kGravity * rollsAt,
                              half.velocity.x(), 1e-3));
    const RigidMotion late = roller.run(0.45 * rollsAt);
    checks.push_back(relative("speed at 0.95 of the time, m/s" + with, u0 - 0.95 * mu * kGravity * rollsAt,
                              late.velocity.x(), 1e-3));
    const RigidMotion end = roller.run(1.0 * rollsAt);
    checks.push_back(relative("speed in the end, m/s" + with, 5.0 / 7.0 * u0, end.velocity.x(), 1e-3));
    checks.push_back(relative("R times the spin in the end, m/s" + with, 5.0 / 7.0 * u0,
                              -end.angularVelocity.z() * radius, 1e-3));
  }
  return checks;
}

// -----------------------------------------------------------------------------------------------------
// stacks

std::vector<Check> stackedSpheres(int count, double radius, double modulus) {
  GranularSystem system({.gravity = tiltedGravity(0.0), .integrator = {.tolerance = 1e-7}});
  const Ball ball{.radius = radius, .youngsModulus = modulus, .density = 2500.0};
  const MaterialId material = system.addMaterial(materialOf(ball));
  system.setMaterialPair(material, material, {.restitution = 0.05, .restitutionSpeed = 0.001});
  addPlane(system, material);
  const GrainShapeId shape = system.addGrainShape(sphereShape(radius));
  for (int i = 0; i < count; ++i) {
    system.addGrain(
        {.shape = shape, .material = material, .pose = {.position = {0.0, (2 * i + 1) * radius, 0.0}}});
  }
  for (int i = 0; i < 180; ++i) system.step(1.0 / 60.0);
  const double weight = massOf(ball) * kGravity;
  const ImpactDef onFloor{.ball = ball, .partner = Partner::Plane, .other = ball};
  const ImpactDef onBall{.ball = ball, .partner = Partner::Ball, .other = ball};
  std::vector<Check> checks;
  const auto motions = system.grainMotions();
  for (int i = 0; i < count; ++i) {
    const double below = i == 0 ? -radius : motions[i - 1].pose.position.y();
    const double overlap = 2.0 * radius - (motions[i].pose.position.y() - below);
    const int carried = count - i;
    const double kr = hertzStiffness(i == 0 ? onFloor : onBall);
    checks.push_back(relative("overlap carrying " + std::to_string(carried) + ", m",
                              std::pow(carried * weight / kr, 2.0 / 3.0), overlap, 1e-4));
  }
  return checks;
}

/// Whether a sphere on two touching ones still lies there after gravity has been turned on slowly, law 19.
bool threeSpheresStand(double muBetween, double muFloor, double radius) {
  GranularSystem system({.gravity = Vector3::Zero()});
  const MaterialDef def{.name = "ball", .density = 2500.0, .youngsModulus = 1e8};
  const MaterialId ball = system.addMaterial(def), floor = system.addMaterial(def);
  system.setMaterialPair(ball, ball, calmPair(ShearLaw::StaticFriction, muBetween));
  system.setMaterialPair(ball, floor, calmPair(ShearLaw::StaticFriction, muFloor));
  addPlane(system, floor);
  const GrainShapeId shape = system.addGrainShape(sphereShape(radius));
  for (const double x : {-radius, radius}) {
    system.addGrain({.shape = shape, .material = ball, .pose = {.position = {x, radius, 0.0}}});
  }
  const double top = radius * (1.0 + std::sqrt(3.0));
  const GrainId upper =
      system.addGrain({.shape = shape, .material = ball, .pose = {.position = {0.0, top, 0.0}}});
  constexpr int kSteps = 300;
  for (int i = 1; i <= kSteps; ++i) {
    system.setGravity({0.0, -kGravity * i / kSteps, 0.0});
    system.step(1e-3);
  }
  system.step(1.0);
  return system.grainMotions()[upper.index].pose.position.y() > top - 0.1 * radius;
}

std::vector<Check> threeSpheres(double radius) {
  const double between = std::tan(std::numbers::pi / 12.0), floor = between / 3.0;  // .26795 and .08932
  std::vector<Check> checks;
  for (const double part : {0.99, 1.01}) {
    checks.push_back(truth("stands at " + text(part) + " of mu between spheres", part > 1.0,
                           threeSpheresStand(part * between, 0.5, radius)));
    checks.push_back(truth("stands at " + text(part) + " of mu on the floor", part > 1.0,
                           threeSpheresStand(0.6, part * floor, radius)));
  }
  return checks;
}

// ------------------------------------------------------------------------------------------------- load
// cycles

/// A body that cannot turn, on one particle, pushed sideways round a square of loads: where it lies after
/// each turn.
class LoadCycle {
 public:
  explicit LoadCycle(double part) : system_({.gravity = tiltedGravity(0.0)}) {
    const MaterialDef def{.name = "stone", .youngsModulus = 1e7};
    const MaterialId stone = system_.addMaterial(def), floor = system_.addMaterial(def);
    MaterialPairDef pair = calmPair(ShearLaw::StaticFriction, kFriction);
    pair.shear.dampingRatio = 0.8;
    pair.bodyNormal = {.law = NormalLaw::HertzViscoelastic};
    system_.setMaterialPair(stone, floor, pair);
    addPlane(system_, floor);
    body_ = system_.addBody({.motion = BodyMotion::Dynamic,
                             .covering = {.positions = {Vector3::Zero()}, .radii = {kRadius}},
                             .material = stone,
                             .mass = kMass,
                             .principalInertia = Vector3::Constant(0.4 * kMass * kRadius * kRadius),
                             .pose = {.position = {0.0, kRadius, 0.0}},
                             .angularFactor = Vector3::Zero()});
    load_ = part * kFriction * kMass * kGravity;
    system_.step(1.0);
  }
  void turn() {
    for (const auto& [x, z] : std::array<std::array<double, 2>, 4>{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}}) {
      push(x, z, kPhase);
    }
  }
  /// Without a load again, at rest.
  void relax() { push(0.0, 0.0, 1.0); }
  /// How far the load along x takes it.
  double excursion() {
    const double before = position().x();
    push(1.0, 0.0, 1.0);
    const double way = position().x() - before;
    relax();
    return way;
  }
  double load() const { return load_; }
  Vector3 position() const { return system_.bodyMotion(body_).pose.position; }
  Vector3 force() { return system_.contactWrench(body_).force; }

  static constexpr double kRadius = 0.01, kMass = 0.02, kFriction = 0.5;

 private:
  static constexpr double kPhase = 0.01;  // s; a few times constants of the loaded spring

  void push(double x, double z, double duration) {
    system_.setBodyLoad(body_, {.force = {load_ * x, 0.0, load_ * z}});
    system_.step(duration);
  }

  GranularSystem system_;
  BodyId body_;
  double load_ = 0.0;
};

std::vector<Check> closedCycle(int turns) {
  LoadCycle cycle(0.5);
  cycle.relax();
  const Vector3 start = cycle.position(), force = cycle.force();
  cycle.turn();
  cycle.relax();
  const double once = (cycle.position() - start).norm() / LoadCycle::kRadius;
  for (int i = 1; i < turns; ++i) cycle.turn();
  cycle.relax();
  const double drift = (cycle.position() - start).norm() / LoadCycle::kRadius;
  // Mindlin's ratio times the slope of Hertz's force at the overlap that carries the weight (nu = 0.3, E =
  // 1e7 Pa).
  const double kr = 4.0 / 3.0 * 1e7 / (2.0 * (1.0 - 0.09)) * std::sqrt(LoadCycle::kRadius);
  const double overlap = std::pow(LoadCycle::kMass * kGravity / kr, 2.0 / 3.0);
  const double kt = (1.0 - 0.3) / (1.0 - 0.15) * 1.5 * kr * std::sqrt(overlap);
  const double forceChange = (cycle.force() - force).norm() / (LoadCycle::kMass * kGravity);
  return {relative("displacement under the load, m", cycle.load() / kt, cycle.excursion(), 1e-4),
          absolute("displacement after one turn, R", 0.0, once, 1e-6),
          absolute("drift after " + std::to_string(turns) + " turns, R", 0.0, drift, 1e-6),
          absolute("change of the contact force, weights", 0.0, forceChange, 1e-6)};
}

/// D turns with the contact: the plane turns about its normal, and gravity's slope with it.
std::vector<Check> turningContact(const IntegratorDef& integrator) {
  const double radius = 0.01, mu = 0.5, angle = std::atan(0.8 * mu), rate = 0.5;
  GranularSystem system({.gravity = tiltedGravity(0.0), .integrator = integrator});
  const MaterialDef def{.name = "stone", .youngsModulus = 1e7};
  const MaterialId stone = system.addMaterial(def), floor = system.addMaterial(def);
  system.setMaterialPair(stone, floor, calmPair(ShearLaw::StaticFriction, mu));
  const BodyId plane =
      system.addBody({.motion = BodyMotion::Kinematic, .exact = HalfSpace{}, .material = floor});
  GrainShapeDef raft{.name = "raft"};
  for (const double x : {-2.0, 2.0}) {
    for (const double z : {-2.0, 2.0}) raft.particles.push_back({{x * radius, 0.0, z * radius}, radius});
  }
  const GrainId grain = system.addGrain(
      {.shape = system.addGrainShape(raft), .material = stone, .pose = {.position = {0.0, radius, 0.0}}});
  const double dt = 1e-3;
  double turned = 0.0;
  const auto step = [&](double slope, double spin) {
    const Quaternion turn(Eigen::AngleAxisd(turned + 0.5 * spin * dt, Vector3::UnitY()));
    system.setGravity(turn * tiltedGravity(slope));
    system.setBodyMotion(plane,
                         {.pose = {.orientation = Quaternion(Eigen::AngleAxisd(turned, Vector3::UnitY()))},
                          .angularVelocity = {0.0, spin, 0.0}});
    system.step(dt);
    turned += spin * dt;
  };
  for (int i = 0; i < 300; ++i) step(angle * std::min(1.0, i / 200.0), rate * std::min(1.0, i / 100.0));
  const auto place = [&] {  // in the frame of the plane
    return Vector3(Quaternion(Eigen::AngleAxisd(-turned, Vector3::UnitY())) *
                   system.grainMotions()[grain.index].pose.position);
  };
  for (int i = 0; i < 300; ++i) step(angle, rate);
  const Vector3 before = place();
  const double goal = turned + 2.0 * std::numbers::pi;
  while (turned < goal) step(angle, rate);
  return {absolute("displacement in the turning frame after a turn, R", 0.0,
                   (place() - before).norm() / radius, 1e-5)};
}

// ------------------------------------------------------------------------------------------------------
// energy

/// Random oblique impacts of two spinning balls: energy never rises, whatever the laws.
std::vector<Check> neverAddsEnergy(ShearLaw shear) {
  std::vector<Check> checks;
  Random random(23);
  const std::pair<const char*, NormalLaw> normals[] = {{"viscoelastic", NormalLaw::HertzViscoelastic},
                                                       {"Tsuji", NormalLaw::HertzTsuji},
                                                       {"constant damping", NormalLaw::HertzConstantDamping},
                                                       {"linear", NormalLaw::LinearSpring}};
  for (const auto& [name, normal] : normals) {
    for (const double e : {0.6, 1.0}) {
      double gain = 0.0;
      for (int i = 0; i < 12; ++i) {
        const auto vector = [&](double size) {
          return Vector3(random.uniform(-size, size), random.uniform(-size, size),
                         random.uniform(-size, size));
        };
        const double v = random.uniform(0.05, 0.5);
        ImpactDef def{.ball = {.radius = 0.01},
                      .partner = Partner::Ball,
                      .other = {.radius = 0.02},
                      .pair = {.restitution = e,
                               .friction = random.uniform(0.1, 1.0),
                               .normal = {.law = normal},
                               .shear = {.law = shear}},
                      .velocity = {0.02 * random.uniform(), -v, 0.02 * random.uniform()},
                      .spin = vector(3.0 * v / 0.01),
                      .otherSpin = vector(3.0 * v / 0.02),
                      .gap = 1e-3,
                      .integrator = {.tolerance = 1e-8, .contactTimeFraction = 0.02}};
        def.step = hertzDuration(def);
        const ImpactResult result = simulateImpact(def);
        gain = std::max(gain, result.energyAfter / result.energyBefore - 1.0);
      }
      checks.push_back(absolute(std::string(name) + ", e = " + text(e) + ", largest gain", 0.0, gain, 1e-6));
    }
  }
  return checks;
}

/// Sheared while shallow, pressed deeper, sheared back, drawn off: a spring that stiffens with overlap must
/// not hand back more than it took (Elata & Berryman 1996).
std::vector<Check> pressedDeeper() {
  GranularSystem system(
      {.gravity = Vector3::Zero(), .integrator = {.tolerance = 1e-8, .contactTimeFraction = 0.05}});
  const MaterialId stone = system.addMaterial({.name = "stone", .youngsModulus = 1e6});
  const MaterialPairDef pair{.restitution = 1.0,
                             .friction = 5.0,
                             .bodyNormal = {.law = NormalLaw::HertzViscoelastic},
                             .shear = {.law = ShearLaw::StaticFriction}};
  system.setMaterialPair(stone, stone, pair);
  const double radius = 0.01;
  const Covering one{.positions = {Vector3::Zero()}, .radii = {radius}};
  const BodyId mover = system.addBody({.motion = BodyMotion::Kinematic,
                                       .covering = one,
                                       .material = stone,
                                       .pose = {.position = {0.0, 2.0 * radius, 0.0}}});
  system.addBody({.motion = BodyMotion::Dynamic,
                  .covering = one,
                  .material = stone,
                  .mass = 1.0,
                  .principalInertia = Vector3::Constant(1.0),
                  .linearFactor = Vector3::Zero(),
                  .angularFactor = Vector3::Zero()});
  StepReport report;
  double mostStored = 0.0;
  const auto move = [&](const Vector3& way) {
    constexpr int kSteps = 20;
    const double speed = 0.01, duration = way.norm() / speed;
    RigidMotion motion = system.bodyMotion(mover);
    motion.velocity = way / duration;
    system.setBodyMotion(mover, motion);
    for (int i = 0; i < kSteps; ++i) {
      report = system.step(duration / kSteps);
      mostStored = std::max(mostStored, report.energy.elastic);
    }
  };
  const double depth = 0.01 * radius, shear = 0.01 * radius;
  move({0.0, -depth, 0.0});
  move({shear, 0.0, 0.0});
  move({0.0, -3.0 * depth, 0.0});
  move({-shear, 0.0, 0.0});
  move({0.0, 5.0 * depth, 0.0});
  const double gain = std::max(0.0, -report.workByMovedBodies) / mostStored;
  return {absolute("energy gained in the cycle, of the most stored", 0.0, gain, 1e-6),
          absolute("stored in the end, of the most stored", 0.0, report.energy.elastic / mostStored, 1e-12)};
}

}  // namespace

void addFrictionCases(CaseList& cases) {
  const auto add = [&](const std::string& name, auto&& run) {
    cases.push_back({"4." + name, kSection, run});
  };
  for (const ShearLaw law : {ShearLaw::Coulomb, ShearLaw::StaticFriction}) {
    for (const double mu : {0.3, 0.7}) {
      const std::string tail = nameOf(law) + ".mu-" + text(mu);
      add("incline.block." + tail, [=] { return inclineThreshold(Rider::Block, law, mu); });
      add("incline.clump." + tail, [=] { return inclineThreshold(Rider::Clump, law, mu); });
    }
  }
  for (const double viscosity : {20.0, 300.0}) {
    add("incline.creep-of-law18.kt-" + text(viscosity), [=] { return creepOfLaw18(viscosity); });
  }
  for (const ShearLaw law : {ShearLaw::Coulomb, ShearLaw::RegularisedCoulomb, ShearLaw::StaticFriction}) {
    add("rolling-sphere." + nameOf(law), [=] { return rollingDown(law); });
    add("slipping-sphere." + nameOf(law), [=] { return slippingSphere(law); });
  }
  add("stacked-spheres.5", [] { return stackedSpheres(5, 0.01, 1e7); });
  add("stacked-spheres.9-small", [] { return stackedSpheres(9, 0.001, 5e7); });
  add("three-spheres.1cm", [] { return threeSpheres(0.01); });
  add("three-spheres.2mm", [] { return threeSpheres(0.002); });
  add("closed-load-cycle.10000-turns", [] { return closedCycle(10000); });
  for (const StepperSettings& s : everyStepper(5e-5, 1e-7)) {
    add("friction-turns-with-the-contact." + s.name, [=] { return turningContact(s.integrator); });
  }
  for (const StepperSettings& s : everyStepper(5e-5)) {
    if (s.integrator.stepper == Stepper::Rkf45) continue;  // above
    for (const ShearLaw law : {ShearLaw::Coulomb, ShearLaw::StaticFriction}) {
      add("incline.clump." + nameOf(law) + ".mu-0.5." + s.name,
          [=] { return inclineThreshold(Rider::Clump, law, 0.5, s.integrator); });
    }
    add("incline.block.law19.mu-0.5." + s.name,
        [=] { return inclineThreshold(Rider::Block, ShearLaw::StaticFriction, 0.5, s.integrator); });
  }
  for (const ShearLaw law :
       {ShearLaw::Viscous, ShearLaw::Coulomb, ShearLaw::RegularisedCoulomb, ShearLaw::StaticFriction}) {
    add("never-adds-energy." + nameOf(law), [=] { return neverAddsEnergy(law); });
  }
  add("spring-makes-no-energy-when-pressed-deeper", pressedDeeper);
}

}  // namespace granular::verification
