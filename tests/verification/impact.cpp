// SPDX-License-Identifier: MIT
#include "tests/verification/impact.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace granular::verification {
namespace {

/// Top of a parabola through the largest of equally spaced values and its neighbours.
double topOf(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto top = std::max_element(values.begin(), values.end());
  if (top == values.begin() || top + 1 == values.end()) return *top;
  const double left = *(top - 1), middle = *top, right = *(top + 1);
  const double bend = left - 2.0 * middle + right;
  return bend < 0.0 ? middle - (right - left) * (right - left) / (8.0 * bend) : middle;
}

/// The system, the ball and what it meets.
class Impact {
 public:
  explicit Impact(const ImpactDef& def)
      : def_(def), system_({.gravity = Vector3::Zero(), .integrator = def.integrator}) {
    ballMaterial_ = system_.addMaterial(materialOf(def.ball));
    const MaterialId otherMaterial = system_.addMaterial(materialOf(def.other));
    system_.setMaterialPair(ballMaterial_, otherMaterial, def.pair);
    ball_ = system_.addGrain({.shape = system_.addGrainShape(sphereShape(def.ball.radius)),
                              .material = ballMaterial_,
                              .pose = {.position = {0.0, def.ball.radius * (1.0 + def.gap), 0.0}},
                              .velocity = def.velocity,
                              .angularVelocity = def.spin});
    addPartner(otherMaterial);
  }

  ImpactResult run() {
    ImpactResult result;
    result.energyBefore = system_.measure().energy.total();
    const double meeting = def_.gap * def_.ball.radius / -def_.velocity.y();
    constexpr int kMostSteps = 2'000'000;
    for (int n = 0; n < kMostSteps && !hasParted(); ++n) {
      system_.step(def_.step);
      if (def_.keepHistory) sample(meeting, result);
    }
    if (!hasParted()) throw std::runtime_error("simulateImpact: the two never part");
    readResult(meeting, result);
    return result;
  }

 private:
  void addPartner(MaterialId material) {
    const Pose below{.position = {0.0, -def_.other.radius, 0.0}};
    switch (def_.partner) {
      case Partner::Plane:
        addPlane(system_, material);
        break;
      case Partner::Ball:
        otherBall_ = system_.addGrain({.shape = system_.addGrainShape(sphereShape(def_.other.radius)),
                                       .material = material,
                                       .pose = below,
                                       .angularVelocity = def_.otherSpin});
        break;
      case Partner::CoveredBody: {
        const double inertia = 0.4 * def_.bodyMass * def_.other.radius * def_.other.radius;
        body_ = system_.addBody({.motion = BodyMotion::Dynamic,
                                 .covering = {.positions = {Vector3::Zero()}, .radii = {def_.other.radius}},
                                 .material = material,
                                 .mass = def_.bodyMass,
                                 .principalInertia = Vector3::Constant(inertia),
                                 .pose = below,
                                 .angularVelocity = def_.otherSpin});
        break;
      }
    }
  }

  const RigidMotion& ballMotion() const { return system_.grainMotions()[ball_.index]; }
  RigidMotion otherMotion() const {
    if (def_.partner == Partner::Ball) return system_.grainMotions()[otherBall_.index];
    if (def_.partner == Partner::CoveredBody) return system_.bodyMotion(body_);
    return {};
  }

  /// Distance of the undeformed surfaces along the line of centres, m, and its rate, m/s.
  double distance() const {
    if (def_.partner == Partner::Plane) return ballMotion().pose.position.y() - def_.ball.radius;
    return (ballMotion().pose.position - otherMotion().pose.position).norm() - def_.ball.radius -
           def_.other.radius;
  }
  Vector3 normal() const {
    if (def_.partner == Partner::Plane) return Vector3::UnitY();
    return (ballMotion().pose.position - otherMotion().pose.position).normalized();
  }
  double partingSpeed() const { return (ballMotion().velocity - otherMotion().velocity).dot(normal()); }
  bool hasParted() const { return distance() > 0.0 && partingSpeed() > 0.0; }

  void sample(double meeting, ImpactResult& result) {
    if (distance() > 0.0) return;
    system_.readContacts(contacts_);
    ImpactSample s{.time = system_.time() - meeting, .overlap = -distance()};
    for (const ContactView& c : contacts_) {
      const bool ballFirst = c.ownerKind[0] == OwnerKind::Grain && c.ownerIndex[0] == ball_.index;
      s.force += ballFirst ? c.force : Vector3(-c.force);
    }
    result.history.push_back(s);
  }

  void readResult(double meeting, ImpactResult& result) {
    result.velocity = ballMotion().velocity;
    result.spin = ballMotion().angularVelocity;
    result.otherVelocity = otherMotion().velocity;
    result.otherSpin = otherMotion().angularVelocity;
    result.restitution = partingSpeed() / -def_.velocity.y();
    result.contactTime = system_.time() - distance() / partingSpeed() - meeting;
    result.energyAfter = system_.measure().energy.total();
  }

  ImpactDef def_;
  GranularSystem system_;
  MaterialId ballMaterial_;
  GrainId ball_, otherBall_;
  BodyId body_;
  std::vector<ContactView> contacts_;
};

}  // namespace

double massOf(const Ball& ball) {
  return 4.0 / 3.0 * std::numbers::pi * ball.density * ball.radius * ball.radius * ball.radius;
}

MaterialDef materialOf(const Ball& ball) {
  return {.name = "ball",
          .density = ball.density,
          .youngsModulus = ball.youngsModulus,
          .poissonRatio = ball.poissonRatio,
          .restitution = 1.0,
          .friction = ball.friction};
}

double ImpactResult::largestOverlap() const {
  std::vector<double> values;
  for (const ImpactSample& s : history) values.push_back(s.overlap);
  return topOf(values);
}

double ImpactResult::largestForce() const {
  std::vector<double> values;
  for (const ImpactSample& s : history) values.push_back(s.force.norm());
  return topOf(values);
}

ImpactResult simulateImpact(const ImpactDef& def) {
  return Impact(def).run();
}

double effectiveMass(const ImpactDef& def) {
  const double mass = massOf(def.ball);
  if (def.partner == Partner::Plane) return mass;
  const double other = def.partner == Partner::Ball ? massOf(def.other) : def.bodyMass;
  return mass * other / (mass + other);
}

double hertzStiffness(const ImpactDef& def) {
  const auto compliance = [](const Ball& b) {
    return (1.0 - b.poissonRatio * b.poissonRatio) / b.youngsModulus;
  };
  const double inverseRadius =
      1.0 / def.ball.radius + (def.partner == Partner::Plane ? 0.0 : 1.0 / def.other.radius);
  return 4.0 / 3.0 / (compliance(def.ball) + compliance(def.other)) / std::sqrt(inverseRadius);
}

double hertzDepth(const ImpactDef& def) {
  const double v = def.velocity.y();
  return std::pow(5.0 * effectiveMass(def) * v * v / (4.0 * hertzStiffness(def)), 0.4);
}

double hertzDuration(const ImpactDef& def) {
  // t_c = 2 delta_max / v times the integral of dx / sqrt(1 - x^(5/2)) over 0..1, which is B(2/5, 1/2) / 2.5.
  const double shape = std::exp(std::lgamma(0.4) + std::lgamma(0.5) - std::lgamma(0.9)) / 2.5;
  return 2.0 * hertzDepth(def) / std::abs(def.velocity.y()) * shape;
}

IntegratorDef convergedIntegrator(double depth) {
  return {.tolerance = 1e-9 * depth, .contactTimeFraction = 0.05, .smallestSubStep = 1e-16};
}

IntegratorDef convergedIntegrator(const ImpactDef& def) {
  return convergedIntegrator(hertzDepth(def) / def.ball.radius);
}

BodyId addPlane(GranularSystem& system, MaterialId material, const Vector3& point, const Vector3& up) {
  const Quaternion turn = Quaternion::FromTwoVectors(Vector3::UnitY(), up);
  return system.addBody(
      {.exact = HalfSpace{}, .material = material, .pose = {.position = point, .orientation = turn}});
}

}  // namespace granular::verification
