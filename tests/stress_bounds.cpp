// SPDX-License-Identifier: MIT
// The scenes about the longest steps that closed forms allow.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "tests/stress_scenes.h"
#include "tests/stress_watched.h"

namespace granular::stress {
namespace {

constexpr int kSwingSteps = 2000;

}  // namespace

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

Outcome lattice(Stepper stepper, double frequencyTimesStep) {
  // All balls turn at w. At a contact of two both surfaces move by arm w, against one another: the spring is
  // stretched by 2 arm w and each feels 2 kt arm^2 w; four of six contacts are beside the axis: 8 kt arm^2/I.
  // Walls of twice the spring stand for balls that turn as well. Shaking, each against its neighbours, is
  // slower: 4 (k + 2 kt)/m. Gershgorin's circles of the block [kt arm^2 .../I] give no more.
  constexpr int kAcross = 4;
  constexpr double kOverlap = 1e-3 * kRadius, kSpin = 1e-4, kStiffness = 1e4, kShear = 0.8 * kStiffness;
  constexpr double kArm = kRadius - 0.5 * kOverlap;
  const double inertia = 0.4 * ballMass() * kRadius * kRadius;
  const double step = frequencyTimesStep / std::sqrt(8.0 * kShear * kArm * kArm / inertia);
  Watched scene({.gravity = kNone, .integrator = {.stepper = stepper, .fixedSubStep = step}},
                {.density = kDensity, .restitution = 1.0, .friction = 1e6});
  const MaterialId wall = scene.system.addMaterial({.density = kDensity, .friction = 1e6});
  for (const auto& [other, shear] : {std::pair(scene.stone, kShear), std::pair(wall, 2.0 * kShear)}) {
    scene.system.setMaterialPair(
        scene.stone, other,
        {.normal = {.law = NormalLaw::LinearSpring, .stiffness = kStiffness, .damping = 0.0},
         .shear = {.law = ShearLaw::StaticFriction, .stiffness = shear, .dampingRatio = 0.0}});
  }
  const double spacing = 2.0 * kRadius - kOverlap, half = 0.5 * kAcross * spacing;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3 outward = side * Vector3::Unit(axis);
      scene.system.addBody({.exact = HalfSpace{},
                            .material = wall,
                            .pose = {(half - 0.5 * kOverlap) * outward,
                                     Quaternion::FromTwoVectors(Vector3::UnitY(), -outward)}});
    }
  }
  for (int i = 0; i < kAcross * kAcross * kAcross; ++i) {
    const Vector3 site(i % kAcross + 0.5, i / kAcross % kAcross + 0.5, i / (kAcross * kAcross) + 0.5);
    scene.system.addGrain({.shape = scene.ball,
                           .material = scene.stone,
                           .pose = {.position = spacing * site - Vector3::Constant(half)},
                           .angularVelocity = {0, 0, kSpin}});
  }
  double largest = 0.0;
  for (int i = 0; i < 3000 && largest < 1e3 * kSpin; ++i) {
    scene.step(step);
    for (const RigidMotion& motion : scene.system.grainMotions())
      largest = std::max(largest, motion.angularVelocity.norm());
  }
  return scene.end(largest / kSpin);
}

double largestFrequencyByLeapfrog() {
  // Numbers: displacement D, velocity v and the rate r that D was left with, a prediction, at h = 1.
  //   p = v - w^2 D,   D' = D + 0.4 r + 0.6 p,   v' = v - w^2 (D + D')/2,   r' = p     (kick_drift.h)
  const auto growth = [](double w) {
    const Eigen::RowVector3d D(1, 0, 0), v(0, 1, 0), r(0, 0, 1);
    const Eigen::RowVector3d p = v - w * w * D, next = D + 0.4 * r + 0.6 * p;
    Matrix3 step;
    step << next, v - 0.5 * w * w * (D + next), p;
    return step.eigenvalues().cwiseAbs().maxCoeff();
  };
  double low = 0.1, high = 1.0;
  for (int i = 0; i < 50; ++i) (growth(0.5 * (low + high)) > 1.0 ? high : low) = 0.5 * (low + high);
  return low;
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

}  // namespace granular::stress
