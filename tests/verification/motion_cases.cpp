// SPDX-License-Identifier: MIT
// Section 5: rigid motion and conservation.
//
// Source of the torque-free top: Landau & Lifshitz, Mechanics, sec. 37. Its elliptic functions are computed
// here by the arithmetic-geometric mean (Abramowitz & Stegun, sec. 16.4 and 17.6).
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <set>
#include <sstream>

#include "granular/base/random.h"
#include "tests/verification/impact.h"
#include "tests/verification/stepper_settings.h"
#include "tests/verification/verification_case.h"

namespace granular::verification {
namespace {

constexpr char kSection[] = "rigid motion, conservation";

std::string text(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

// -------------------------------------------------------------------------------------------- torque-free
// top

struct Elliptic {
  double sn, cn, dn;
};

/// Jacobi's functions of u, modulus k in [0, 1).
Elliptic jacobi(double u, double k) {
  std::array<double, 20> a{}, c{};
  a[0] = 1.0;
  c[0] = k;
  double b = std::sqrt(1.0 - k * k);
  int n = 0;
  for (; n + 1 < 20 && std::abs(c[n]) > 1e-17; ++n) {
    a[n + 1] = 0.5 * (a[n] + b);
    c[n + 1] = 0.5 * (a[n] - b);
    b = std::sqrt(a[n] * b);
  }
  double phi = std::ldexp(a[n] * u, n);
  for (; n > 0; --n) phi = 0.5 * (phi + std::asin(c[n] / a[n] * std::sin(phi)));
  const double sn = std::sin(phi);
  return {sn, std::cos(phi), std::sqrt(1.0 - k * k * sn * sn)};
}

/// Quarter period K(k).
double quarterPeriod(double k) {
  double a = 1.0, b = std::sqrt(1.0 - k * k);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 0.5 * std::numbers::pi / a;
}

/// Angular velocity in the body frame of a top with moments I1 < I2 < I3 that starts at (w1 > 0, 0, w3 > 0).
class Top {
 public:
  Top(const Vector3& inertia, const Vector3& start) {
    const double energy = inertia.dot(start.cwiseAbs2());  // twice the kinetic energy
    const double momentum = inertia.cwiseProduct(start).squaredNorm();
    swapped_ = momentum < energy * inertia.y();  // then axes 1 and 3 change places in the formulas
    const double I1 = swapped_ ? inertia.z() : inertia.x(), I2 = inertia.y();
    const double I3 = swapped_ ? inertia.x() : inertia.z();
    const double p = energy * I3 - momentum, q = momentum - energy * I1;
    amplitude_ = {std::sqrt(p / (I1 * (I3 - I1))), std::sqrt(p / (I2 * (I3 - I2))),
                  std::sqrt(q / (I3 * (I3 - I1)))};
    rate_ = std::sqrt((I3 - I2) * q / (I1 * I2 * I3));
    modulus_ = std::sqrt((I2 - I1) * p / ((I3 - I2) * q));
  }
  Vector3 angularVelocity(double t) const {
    const Elliptic f = jacobi(rate_ * t, modulus_);
    const Vector3 w = amplitude_.cwiseProduct(Vector3(f.cn, f.sn, f.dn));
    return swapped_ ? Vector3(w.z(), w.y(), w.x()) : w;
  }
  double period() const { return 4.0 * quarterPeriod(modulus_) / rate_; }

 private:
  bool swapped_ = false;
  Vector3 amplitude_;
  double rate_ = 0.0, modulus_ = 0.0;
};

/// A body with the given principal moments, one particle, no gravity.
struct FreeBody {
  FreeBody(const Vector3& inertia, const Vector3& angularVelocity, const IntegratorDef& integrator = {})
      : system({.gravity = Vector3::Zero(), .integrator = integrator}) {
    const MaterialId material = system.addMaterial({});
    body = system.addBody({.motion = BodyMotion::Dynamic,
                           .covering = {.positions = {Vector3::Zero()}, .radii = {1.0}},
                           .material = material,
                           .mass = 1.0,
                           .principalInertia = inertia,
                           .angularVelocity = angularVelocity});
  }
  Vector3 bodyFrameAngularVelocity() const {
    const RigidMotion motion = system.bodyMotion(body);
    return motion.pose.orientation.conjugate() * motion.angularVelocity;
  }
  GranularSystem system;
  BodyId body;
};

std::vector<Check> torqueFreeTop(const Vector3& inertia, const Vector3& start) {
  const Top top(inertia, start);
  FreeBody free(inertia, start);
  const int stepsPerPeriod = 4000, periods = 3;
  const double dt = top.period() / stepsPerPeriod;
  double worst = 0.0, before = 0.0, lastFlip = 0.0;
  std::vector<double> flips;
  for (int i = 1; i <= periods * stepsPerPeriod; ++i) {
    free.system.step(dt);
    const Vector3 w = free.bodyFrameAngularVelocity();
    worst = std::max(worst, (w - top.angularVelocity(i * dt)).norm() / start.norm());
    if (before * w.y() < 0.0) flips.push_back((i - 1 + before / (before - w.y())) * dt);  // w2 crosses zero
    before = w.y();
  }
  std::vector<Check> checks{absolute("angular velocity, worst, of the first", 0.0, worst, 1e-6)};
  for (const double flip : flips) {
    checks.push_back(relative("time between sign flips, s", 0.5 * top.period(), flip - lastFlip, 1e-5));
    lastFlip = flip;
  }
  checks.push_back(truth("flips seen are all there are", true, flips.size() >= 2 * periods - 1));
  return checks;
}

std::vector<Check> topKeepsWhatItHas(const IntegratorDef& integrator) {
  const Vector3 inertia(1.0, 2.0, 3.0), start(0.9, 0.3, 0.6);
  FreeBody free(inertia, start, integrator);
  const StepReport first = free.system.measure();
  StepReport last;
  for (int i = 0; i < 100000; ++i) last = free.system.step(0.02);
  const double L = first.angularMomentum.norm();
  return {absolute("drift of L over 1e5 steps", 0.0,
                   (last.angularMomentum - first.angularMomentum).norm() / L, 1e-6),
          absolute("drift of the kinetic energy", 0.0,
                   std::abs(last.energy.kinetic / first.energy.kinetic - 1.0), 1e-6)};
}

// ------------------------------------------------------------------------------------------------ free
// flight

std::vector<Check> parabola(const IntegratorDef& integrator) {
  std::vector<Check> checks;
  const Vector3 gravity(0.3, -9.81, 1.0), x0(1.0, 2.0, -3.0), v0(4.0, 5.0, -6.0), spin(20.0, -10.0, 5.0);
  for (const double dt : {1.0 / 240, 1.0 / 60, 0.2, 2.0}) {
    GranularSystem system({.gravity = gravity, .integrator = integrator});
    const MaterialId material = system.addMaterial({});
    const GrainId grain = system.addGrain({.shape = system.addGrainShape(tetrahedronShape(0.01)),
                                           .material = material,
                                           .pose = {.position = x0},
                                           .velocity = v0,
                                           .angularVelocity = spin});
    const int steps = static_cast<int>(std::ceil(2.0 / dt - 1e-9));
    for (int i = 0; i < steps; ++i) system.step(dt);
    const double t = steps * dt;
    Vector3 expected = x0 + t * v0 + 0.5 * t * t * gravity;
    // Each of its steps falls with the velocity of its end.
    if (integrator.stepper == Stepper::SemiImplicitEuler) {
      expected += 0.5 * integrator.fixedSubStep * t * gravity;
    }
    const RigidMotion& motion = system.grainMotions()[grain.index];
    const double error = (motion.pose.position - expected).norm() / expected.norm();
    checks.push_back(absolute("distance from the parabola, steps of " + text(dt) + " s", 0.0, error, 1e-12));
    // A tetrahedron turns like a sphere, on and on about one axis.
    const Vector3 turn = t * spin;
    const Quaternion expectedTurn(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    checks.push_back(absolute("angle from the turn expected, steps of " + text(dt) + " s", 0.0,
                              motion.pose.orientation.angularDistance(expectedTurn), 1e-11));
  }
  return checks;
}

std::vector<Check> inertiaOfGrains() {
  const double r = 0.0037, density = 2345.0;
  const double m = 4.0 / 3.0 * std::numbers::pi * r * r * r * density;
  const GrainShapeDef pair{.name = "pair", .particles = {{{-r, 0.0, 0.0}, r}, {{r, 0.0, 0.0}, r}}};
  struct Known {
    const char* name;
    GrainShapeDef shape;
    double smallest, largest, count;
  };
  std::vector<Check> checks;
  for (const Known& known :
       {Known{"sphere", sphereShape(r), 0.4, 0.4, 1}, Known{"two", pair, 0.8, 2.8, 2},
        Known{"tetrahedron", tetrahedronShape(r), 5.6, 5.6, 4}, Known{"cube", cubeShape(r), 19.2, 19.2, 8}}) {
    const GrainShape shape = makeGrainShape(known.shape);
    const std::string name = std::string(" of the ") + known.name;
    checks.push_back(relative("mass, kg" + name, known.count * m, density * shape.volume, 1e-12));
    checks.push_back(relative("smallest moment, kg m^2" + name, known.smallest * m * r * r,
                              density * shape.unitInertia.minCoeff(), 1e-12));
    checks.push_back(relative("largest moment, kg m^2" + name, known.largest * m * r * r,
                              density * shape.unitInertia.maxCoeff(), 1e-12));
    // As a spinning grain shows it.
    GranularSystem system({.gravity = Vector3::Zero()});
    const MaterialId material = system.addMaterial({.density = density});
    const Vector3 spin(0.0, 0.0, 3.0);  // across the pair's axis
    system.addGrain(
        {.shape = system.addGrainShape(known.shape), .material = material, .angularVelocity = spin});
    checks.push_back(relative("angular momentum, kg m^2/s" + name, known.largest * m * r * r * 3.0,
                              system.measure().angularMomentum.z(), 1e-12));
  }
  return checks;
}

// ------------------------------------------------------------------------------------------------
// conservation

/// Grains and covered bodies flung at each other in empty space.
GranularSystem melee(const IntegratorDef& integrator, std::uint64_t seed, double gap) {
  GranularSystem system({.gravity = Vector3::Zero(), .integrator = integrator});
  const MaterialId material = system.addMaterial({.name = "stone", .restitution = 0.7, .friction = 0.4});
  const double r = 0.01, spacing = (4.0 + gap) * r;
  const GrainShapeId tetra = system.addGrainShape(tetrahedronShape(r));
  const GrainShape shape = makeGrainShape(cubeShape(r));
  Covering block;
  for (const ShapeParticle& p : shape.particles) {
    block.positions.push_back(p.position);
    block.radii.push_back(p.radius);
  }
  Random random(seed);
  int n = 0;
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        const Vector3 at = spacing * Vector3(x, y, z);
        const Vector3 jitter(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
        const Vector3 velocity = -10.0 * at + jitter;
        const Pose pose{.position = at, .orientation = random.rotation()};
        const Vector3 spin = 20.0 * jitter;
        if (n++ % 4 == 0) {
          system.addBody({.motion = BodyMotion::Dynamic,
                          .covering = block,
                          .material = material,
                          .mass = 0.1,
                          .principalInertia = {3e-5, 4e-5, 5e-5},
                          .pose = pose,
                          .velocity = velocity,
                          .angularVelocity = spin});
        } else {
          system.addGrain({.shape = tetra,
                           .material = material,
                           .pose = pose,
                           .velocity = velocity,
                           .angularVelocity = spin});
        }
      }
    }
  }
  return system;
}

std::vector<Check> linearMomentum(const IntegratorDef& integrator) {
  GranularSystem system = melee(integrator, 5, 0.5);
  double scale = 0.0;  // sum of m |v|
  for (const RigidMotion& motion : system.grainMotions())
    scale += system.massOf(system.grainAt(0)) * motion.velocity.norm();
  double worst = 0.0, total = 0.0;
  std::int64_t contacts = 0;
  const Vector3 first = system.measure().momentum;
  Vector3 before = first;
  for (int i = 0; i < 1000; ++i) {
    const StepReport report = system.step(1e-4);
    worst = std::max(worst, (report.momentum - before).norm() / scale);
    total = std::max(total, (report.momentum - first).norm() / scale);
    before = report.momentum;
    contacts += report.contacts;
  }
  return {absolute("largest change in a step, of sum m|v|", 0.0, worst, 1e-13),
          absolute("change over 1000 steps, of sum m|v|", 0.0, total, 1e-11),
          truth("they did collide", true, contacts > 1000)};
}

std::vector<Check> wrenchesBalance() {
  // Bodies that overlap a little, all dynamic: the system tells the wrench of each about its centre.
  GranularSystem system({.gravity = Vector3::Zero()});
  const MaterialId material = system.addMaterial({.name = "stone", .friction = 0.6});
  Random random(9);
  Covering ball;
  for (int i = 0; i < 40; ++i) {
    const Quaternion turn = random.rotation();
    ball.positions.push_back(0.02 * (turn * Vector3::UnitX()));
    ball.radii.push_back(0.004);
  }
  std::vector<BodyId> bodies;
  for (int i = 0; i < 12; ++i) {
    const Vector3 at(random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03), random.uniform(-0.03, 0.03));
    bodies.push_back(
        system.addBody({.motion = BodyMotion::Dynamic,
                        .covering = ball,
                        .material = material,
                        .mass = 0.1,
                        .principalInertia = {3e-5, 4e-5, 5e-5},
                        .pose = {.position = at, .orientation = random.rotation()},
                        .velocity = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)}}));
  }
  std::vector<ContactView> contacts;
  system.readContacts(contacts);
  std::vector<Check> checks{truth("there are contacts", true, contacts.size() > 20)};
  for (int i = 0; i < 5; ++i) {
    const Vector3 about(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    double forces = 0.0, moments = 0.0;
    for (const ContactView& c : contacts) {
      forces += 2.0 * c.force.norm();
      moments += 2.0 * (c.point - about).norm() * c.force.norm();
    }
    Wrench sum;
    for (const BodyId body : bodies) {
      const Wrench w = system.contactWrench(body);
      sum.force += w.force;
      sum.torque += w.torque + (system.bodyMotion(body).pose.position - about).cross(w.force);
    }
    checks.push_back(absolute("sum of forces, of sum |F|", 0.0, sum.force.norm() / forces, 1e-13));
    checks.push_back(
        absolute("sum of moments about a point, of sum |r||F|", 0.0, sum.torque.norm() / moments, 1e-13));
  }
  return checks;
}

std::vector<Check> angularMomentum() {
  std::vector<Check> checks;
  double before = 1.0;
  for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
    GranularSystem system = melee({.tolerance = tolerance, .contactTimeFraction = 0.3}, 5, 0.5);
    const Vector3 first = system.measure().angularMomentum;
    double scale = 0.0;
    for (const RigidMotion& m : system.grainMotions()) {
      scale += system.massOf(system.grainAt(0)) * m.pose.position.norm() * m.velocity.norm();
    }
    StepReport report;
    for (int i = 0; i < 10; ++i) report = system.step(0.005);
    const double change = (report.angularMomentum - first).norm() / scale;
    checks.push_back(
        absolute("change at tolerance " + text(tolerance) + ", below the one before", 0.0, change, before));
    before = change;
  }
  return checks;
}

// ---------------------------------------------------------------------------------------------------------
// order on an impact

/// Rms error of the restitution of a damped linear impact, whose e is known, at `steps` sub-steps a contact,
/// over impacts that begin at different moments of a sub-step.
double errorOfImpact(Stepper stepper, int steps) {
  constexpr double kAsked = 0.5, kTime = 1e-3, kSpeed = 1.0;
  constexpr int kPhases = 24;
  const double h = kTime / steps;
  double sum = 0.0;
  for (int phase = 0; phase < kPhases; ++phase) {
    ImpactDef def{
        .pair = {.restitution = kAsked, .normal = {.law = NormalLaw::LinearSpring, .contactTime = kTime}},
        .velocity = {0.0, -kSpeed, 0.0},
        .integrator = {.stepper = stepper, .fixedSubStep = h},
        .step = kTime};
    def.gap += kSpeed * h * phase / kPhases / def.ball.radius;
    const double error = simulateImpact(def).restitution - kAsked;
    sum += error * error;
  }
  return std::sqrt(sum / kPhases);
}

/// The damper jumps in at first touch, and that caps every stepper at the first order (VERIFICATION.md, sec.
/// 3): the error halves with the sub-step, for those of high order too.
std::vector<Check> orderOnAnImpact(Stepper stepper) {
  const double coarse = errorOfImpact(stepper, 50), fine = errorOfImpact(stepper, 400);
  return {absolute("error of e at 400 sub-steps a contact", 0.0, fine, 0.01),
          absolute("order", 1.0, std::log2(coarse / fine) / 3.0, 0.2)};
}

// ---------------------------------------------------------------------------------------------------------
// gas

// Settings that keep the energy of the gas; an impact there is about a twentieth of a radius deep and takes
// 1.6e-3 s. Explicit Runge-Kutta keeps a trend, here some 4e-12 of the energy a collision; it falls with the
// tolerance. Leapfrog is symplectic and keeps none at a fixed sub-step, of which a contact has 320: while
// spheres touch its energy swings with the square of that.
constexpr double kGasContactTime = 1.6e-3;
const IntegratorDef kGasByRkf45{.tolerance = 1e-12, .contactTimeFraction = 0.05};
const IntegratorDef kGasByLeapfrog{.stepper = Stepper::Leapfrog, .fixedSubStep = kGasContactTime / 320};

/// Mean of one tenth of the values, of ten.
double meanOfTenth(const std::vector<double>& values, std::size_t tenth) {
  const auto at = [&](std::size_t part) {
    return values.begin() + static_cast<std::ptrdiff_t>(values.size() * part / 10);
  };
  return std::accumulate(at(tenth), at(tenth + 1), 0.0) / static_cast<double>(at(tenth + 1) - at(tenth));
}

/// Elastic frictionless spheres in a box of exact planes: energy over many collisions.
std::vector<Check> elasticGas(const IntegratorDef& integrator, std::int64_t collisions) {
  const double r = 0.01, side = 0.1;
  GranularSystem system({.gravity = Vector3::Zero(), .integrator = integrator});
  const MaterialId material =
      system.addMaterial({.name = "gas", .youngsModulus = 1e7, .restitution = 1.0, .friction = 0.0});
  for (const Vector3& axis :
       {Vector3(Vector3::UnitX()), Vector3(Vector3::UnitY()), Vector3(Vector3::UnitZ())}) {
    for (const double sign : {-1.0, 1.0}) addPlane(system, material, -0.5 * sign * side * axis, sign * axis);
  }
  const GrainShapeId sphere = system.addGrainShape(sphereShape(r));
  Random random(31);
  for (int i = 0; i < 27; ++i) {
    const Vector3 at = 0.031 * Vector3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    system.addGrain({.shape = sphere,
                     .material = material,
                     .pose = {.position = at},
                     .velocity = random.rotation() * Vector3(random.uniform(0.5, 1.5), 0.0, 0.0)});
  }
  const double start = system.measure().energy.total();
  std::vector<ContactView> contacts;
  std::set<std::array<std::int32_t, 4>> touching, before;
  std::int64_t counted = 0;
  double worst = 0.0, drift = 0.0;
  std::vector<double> drifts;
  while (counted < collisions) {
    const StepReport report = system.step(0.25 * kGasContactTime);
    drift = report.energy.total() / start - 1.0;
    worst = std::max(worst, std::abs(drift));
    drifts.push_back(drift);
    system.readContacts(contacts);
    touching.clear();
    for (const ContactView& c : contacts) {
      touching.insert({static_cast<std::int32_t>(c.ownerKind[0]), c.ownerIndex[0],
                       static_cast<std::int32_t>(c.ownerKind[1]), c.ownerIndex[1]});
    }
    for (const auto& pair : touching) counted += before.count(pair) == 0;
    before.swap(touching);
  }
  return {absolute("energy drift, worst over " + std::to_string(counted) + " collisions", 0.0, worst, 1e-5),
          absolute("energy drift in the end", 0.0, drift, 1e-5),
          absolute("trend: mean of the last tenth against the first", 0.0,
                   meanOfTenth(drifts, 9) - meanOfTenth(drifts, 0), 2e-6)};
}

}  // namespace

void addMotionCases(CaseList& cases) {
  const auto add = [&](const std::string& name, auto&& run) {
    cases.push_back({"5." + name, kSection, run});
  };
  const Vector3 inertia(1.0, 2.0, 3.0);
  add("torque-free-top.about-3", [=] { return torqueFreeTop(inertia, {0.4, 0.0, 0.9}); });
  add("torque-free-top.about-1", [=] { return torqueFreeTop(inertia, {1.1, 0.0, 0.3}); });
  add("torque-free-top.tumbling", [=] { return torqueFreeTop(inertia, {1.0, 0.0, 0.578}); });
  add("torque-free-top.other-moments", [] { return torqueFreeTop({0.7, 1.1, 1.5}, {0.8, 0.0, 0.7}); });
  for (const StepperSettings& s : everyStepper(0.02)) {
    if (s.integrator.stepper == Stepper::BogackiShampine)
      continue;  // its third order keeps 2e-4 of the energy
    add("torque-free-top.drift." + s.name, [=] { return topKeepsWhatItHas(s.integrator); });
  }
  for (const StepperSettings& s : everyStepper(1.0 / 480)) {
    add("free-flight." + s.name, [=] { return parabola(s.integrator); });
  }
  add("inertia-of-grains", inertiaOfGrains);
  for (const StepperSettings& s : everyStepper(1e-5)) {
    add("linear-momentum." + s.name, [=] { return linearMomentum(s.integrator); });
  }
  add("wrenches-balance", wrenchesBalance);
  add("angular-momentum-falls-with-tolerance", angularMomentum);
  for (const StepperSettings& s : everyStepper(1e-5)) {
    add("order-on-an-impact." + s.name, [=] { return orderOnAnImpact(s.integrator.stepper); });
  }
  add("elastic-gas.rkf45.5000-collisions", [] { return elasticGas(kGasByRkf45, 5000); });
  add("elastic-gas.leapfrog.5000-collisions", [] { return elasticGas(kGasByLeapfrog, 5000); });
  add("elastic-gas.rkf45.100000-collisions", [] { return elasticGas(kGasByRkf45, 100000); });
  cases.back().isLong = true;
  add("elastic-gas.leapfrog.100000-collisions", [] { return elasticGas(kGasByLeapfrog, 100000); });
  cases.back().isLong = true;
}

}  // namespace granular::verification
