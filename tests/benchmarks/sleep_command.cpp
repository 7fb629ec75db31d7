// SPDX-License-Identifier: MIT
// What sleep saves, and that it changes nothing: a bed of spheres at rest, awake and asleep, and a ball that
// lands on it while it sleeps. Answers first: floor and walls bear its weight either way.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "granular/contact/elasticity.h"
#include "granular/granular.h"
#include "tests/benchmarks/commands.h"

namespace granular_bench {
namespace {

using granular::StepReport;
using granular::Vector3;

constexpr double kRadius = 0.01, kGravity = 9.81;       // m, m/s^2
constexpr double kSettlingFrame = 0.01;                 // s
constexpr double kLongestSettling = 4.0;                // s
constexpr double kAwakeTime = 0.02, kAsleepTime = 1.0;  // s simulated for the costs
constexpr double kFrame = 1.0 / 60.0, kBallTime = 0.5;  // s
constexpr double kBeforeLanding = 0.01;                 // s that the last part of a fall is run for
constexpr double kFewAwake = 0.005;                     // of all: the bed counts as asleep
constexpr double kForceBand = 0.005;                    // of the weight

/// n x n balls on the floor between walls, and more layers in the hollows of those below. Law 19.
struct Bed {
  Bed(int n, int layers, int threads)
      : system({.integrator = {.stepper = granular::Stepper::Leapfrog, .tolerance = 1e-3},
                .sleep = {.enabled = true},
                .threads = threads}) {
    stone = system.addMaterial({});
    system.setMaterialPair(stone, stone,
                           {.restitution = 0.1, .shear = {.law = granular::ShearLaw::StaticFriction}});
    ball = system.addGrainShape(granular::sphereShape(kRadius));
    held.push_back(system.addBody({.exact = granular::HalfSpace{}, .material = stone}));
    for (const Vector3& inward : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 0, 1), Vector3(0, 0, -1)}) {
      held.push_back(system.addBody(
          {.exact = granular::HalfSpace{},
           .material = stone,
           .pose = {-n * kRadius * inward, granular::Quaternion::FromTwoVectors(Vector3::UnitY(), inward)}}));
    }
    for (int layer = 0; layer < layers; ++layer) {
      height += layer == 0 ? kRadius - overlapUnder(layers, 0.0) : riseOf(layers - layer);
      const int across = n - layer % 2;
      for (int i = 0; i < across * across; ++i) {
        add({kRadius * (2 * (i % across) + 1 - across), height, kRadius * (2 * (i / across) + 1 - across)});
      }
    }
    height += kRadius;
  }

  /// How deep a contact of a ball is that bears these many weights of one, m. inverseRadius: of the other,
  /// 1/m.
  double overlapUnder(double weights, double inverseRadius) const {
    const granular::MaterialDef& made = system.material(stone);
    const double modulus = granular::effectiveModulus(made.youngsModulus, made.poissonRatio,
                                                      made.youngsModulus, made.poissonRatio);
    const granular::EffectiveContact pair{.radius = 1.0 / (1.0 / kRadius + inverseRadius),
                                          .modulus = modulus};
    const double mass = made.density * 4.0 / 3.0 * std::numbers::pi * kRadius * kRadius * kRadius;
    return std::pow(weights * mass * kGravity / pair.hertzStiffness(), 2.0 / 3.0);
  }
  /// From one layer to the next, which bears these many: each ball on four at 45 degrees, far from walls.
  double riseOf(double weights) const {
    const double apart = 2.0 * kRadius - overlapUnder(weights / (4.0 * std::sqrt(0.5)), 1.0 / kRadius);
    return std::sqrt(apart * apart - 2.0 * kRadius * kRadius);
  }
  void add(const Vector3& at) {
    const granular::GrainId id =
        system.addGrain({.shape = ball, .material = stone, .pose = {.position = at}});
    weight += system.massOf(id) * kGravity;
  }
  /// What floor and walls bear, over the weight.
  double borne() {
    double sum = 0.0;
    for (const granular::BodyId id : held) sum -= system.contactWrench(id).force.y();
    return sum / weight;
  }

  granular::GranularSystem system;
  granular::MaterialId stone;
  granular::GrainShapeId ball;
  std::vector<granular::BodyId> held;
  double weight = 0.0, height = 0.0;  // N, m
};

struct Cost {
  double seconds = 0.0;         // wall, per simulated second
  double evaluations = 0.0;     // per simulated second
  double grainEvaluations = 0;  // grains awake, summed over evaluations, per simulated second
  std::int64_t mostAwake = 0, subSteps = 0, woken = 0, fellAsleep = 0;
  double force = 0.0;  // on the floor at the end, over the weight
};

Cost run(Bed& bed, double time, double frame) {
  Cost cost;
  const auto start = std::chrono::steady_clock::now();
  const int frames = static_cast<int>(std::lround(time / frame));
  for (int i = 0; i < frames; ++i) {
    const StepReport report = bed.system.step(frame);
    cost.evaluations += static_cast<double>(report.evaluations) / time;
    cost.grainEvaluations += static_cast<double>(report.evaluations * report.awakeGrains) / time;
    cost.mostAwake = std::max(cost.mostAwake, report.awakeGrains);
    cost.subSteps += report.subSteps;
    cost.woken += report.woken;
    cost.fellAsleep += report.fellAsleep;
  }
  cost.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / time;
  cost.force = bed.borne();
  return cost;
}

void print(const char* what, const Cost& cost, const Cost& awake) {
  std::cout << std::left << std::setw(22) << what << std::right << std::setprecision(5) << std::setw(13)
            << cost.force << std::setw(12) << cost.mostAwake << std::setw(9) << cost.woken << std::setw(13)
            << cost.evaluations << std::setw(15) << cost.grainEvaluations << std::setw(11)
            << 100.0 * cost.grainEvaluations / awake.grainEvaluations << std::setw(11) << cost.seconds
            << std::setw(11) << 100.0 * cost.seconds / awake.seconds << std::endl;
}

void checkForce(const char* what, double force) {
  if (std::abs(force - 1.0) > kForceBand) {
    throw std::runtime_error(std::string("sleep: ") + what + ": floor and walls bear " +
                             std::to_string(force) + " of the weight");
  }
}

bool isAsleep(const StepReport& report, const Bed& bed) {
  return static_cast<double>(report.awakeGrains) <= kFewAwake * bed.system.grainCount();
}

void compare(int across, int layers, double drop, int threads) {
  Bed bed(across, layers, threads);
  std::cout << bed.system.grainCount() << " spheres in a bed of " << layers << " layers" << std::endl;
  double settled = 0.0;
  StepReport report = bed.system.measure();
  for (; settled < kLongestSettling && !isAsleep(report, bed); settled += kSettlingFrame) {
    report = bed.system.step(kSettlingFrame);
  }
  std::cout << "asleep after " << settled << " s but for " << report.awakeGrains << "\n\n"
            << "                        floor/weight  most awake    woken    eval/sim s   grain eval/s    % "
               "awake wall s/sim s  % awake\n";
  const granular::SleepDef sleep = bed.system.sleep();
  bed.system.setSleep({.enabled = false});
  const Cost awake = run(bed, kAwakeTime, kAwakeTime);
  print("awake", awake, awake);
  bed.system.setSleep(sleep);
  for (double t = 0.0; t < kLongestSettling && !isAsleep(report, bed); t += kSettlingFrame) {
    report = bed.system.step(kSettlingFrame);
  }
  bed.system.step(4.0 * sleep.restTime);
  const Cost asleep = run(bed, kAsleepTime, kFrame);
  print("asleep", asleep, awake);
  checkForce("awake", awake.force);
  checkForce("asleep", asleep.force);
  const auto before = static_cast<double>(bed.system.grainCount());
  bed.add({0.3 * kRadius, bed.height + (1.0 + drop) * kRadius, 0.2 * kRadius});
  const double fall = std::sqrt(2.0 * drop * kRadius / kGravity);
  if (fall > kBeforeLanding) bed.system.step(fall - kBeforeLanding);
  const Cost landing = run(bed, kBallTime, 1e-3);
  print("a ball lands on top", landing, awake);
  std::cout << "it falls " << drop << " radii and wakes at most " << landing.mostAwake - 1 << " at a time, "
            << 100.0 * static_cast<double>(landing.mostAwake - 1) / before << " %" << std::endl;
  checkForce("a ball landed", landing.force);
}

}  // namespace

void addSleepCommand(CLI::App& app, int& status) {
  auto across = std::make_shared<int>(65), layers = std::make_shared<int>(12);
  auto drop = std::make_shared<double>(1.0);
  auto threads = std::make_shared<int>(1);
  CLI::App* command = app.add_subcommand("sleep", "A bed awake and asleep, and a ball that lands on it");
  command->add_option("--across", *across, "balls along a wall")
      ->check(CLI::Range(2, 500))
      ->capture_default_str();
  command->add_option("--layers", *layers, "of balls")->check(CLI::Range(1, 200))->capture_default_str();
  command->add_option("--drop", *drop, "radii that the ball falls from above the topmost")
      ->check(CLI::Range(0.0, 1e4))
      ->capture_default_str();
  command->add_option("--threads", *threads)->check(CLI::PositiveNumber)->capture_default_str();
  command->callback([=, &status] {
    compare(*across, *layers, *drop, *threads);
    status = 0;
  });
}

}  // namespace granular_bench
