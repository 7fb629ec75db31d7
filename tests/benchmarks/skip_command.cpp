// SPDX-License-Identifier: MIT
// granular_bench skip: what a scene pays for what it does not use. The same grains with something idle beside
// them and without it: the work counted must be the same, and the time, by pairs of runs in turn.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "granular/base/random.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/lattice_scene.h"

namespace granular_bench {
namespace {

using granular::GranularSystem;
using granular::Vector3;

constexpr double kStep = 4e-5;  // s
constexpr double kFar = 50.0;   // m, from the grains
constexpr double kAllowed = 1.02;

struct SkipOptions {
  std::int64_t spheres = 5'000;
  std::int64_t steps = 50;
  std::int64_t ground = 1'000'000;
  int pairs = 15;
};

using Change = std::function<void(LatticeScene&)>;
struct Idle {
  std::string what;
  Change add;
};

/// A flat sheet of `count` particles, as coverings have them.
granular::Covering sheet(std::int64_t count, double radius) {
  granular::Covering covering;
  const auto side = static_cast<std::int64_t>(std::max(1.0, std::sqrt(static_cast<double>(count))));
  for (std::int64_t i = 0; i < count; ++i) {
    covering.positions.push_back(radius *
                                 Vector3(static_cast<double>(i % side), 0.0, static_cast<double>(i / side)));
    covering.radii.push_back(radius);
  }
  return covering;
}

void addSheet(LatticeScene& scene, std::int64_t particles, const Vector3& place) {
  scene.system.addBody(
      {.covering = sheet(particles, 2.5e-3), .material = scene.material, .pose = {.position = place}});
}

std::vector<Idle> idleThings(const SkipOptions& options) {
  return {
      {std::to_string(options.ground) + " particles of static ground far away",
       [&](LatticeScene& scene) {
         addSheet(scene, options.ground, {kFar, -kFar, 0.0});
       }},
      {"1000 covered static bodies far away",
       [](LatticeScene& scene) {
         for (int b = 0; b < 1000; ++b) addSheet(scene, 20, {kFar + b, -kFar, 0.0});
       }},
      {"1000 exact static balls far away",
       [](LatticeScene& scene) {
         for (int b = 0; b < 1000; ++b) {
           scene.system.addBody({.exact = granular::ExactSphere{.radius = 0.1},
                                 .material = scene.material,
                                 .pose = {.position = {kFar + b, -kFar, 0.0}}});
         }
       }},
      {"a material that nothing is made of",
       [](LatticeScene& scene) { scene.system.addMaterial({.name = "none"}); }},
      {"a law with memory for a material that nothing is made of",
       [](LatticeScene& scene) {
         const granular::MaterialId none = scene.system.addMaterial({.name = "none"});
         scene.system.setMaterialPair(none, none, {.shear = {.law = granular::ShearLaw::StaticFriction}});
       }},
  };
}

struct Run {
  double seconds = 0.0;
  granular::StepReport report;
};
Run run(LatticeScene& scene, std::int64_t steps) {
  const auto start = std::chrono::steady_clock::now();
  Run result;
  result.report = scene.system.step(static_cast<double>(steps) * kStep);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

/// Places in a sorted sample between which its median lies with 95 % certainty, by the normal approximation
/// of the binomial distribution.
std::pair<std::size_t, std::size_t> medianInterval(std::size_t count) {
  const double half = 0.5 * static_cast<double>(count), spread = 0.98 * std::sqrt(static_cast<double>(count));
  const auto low = static_cast<std::size_t>(std::max(0.0, std::floor(half - spread)));
  return {low, count - 1 - low};
}

/// Whether the line holds.
bool compare(const Idle& idle, const SkipOptions& options) {
  const LatticeDef def{.spheres = options.spheres, .speed = 0.05};
  LatticeScene plain = makeLattice(def), laden = makeLattice(def);
  idle.add(laden);
  run(plain, 10), run(laden, 10);
  std::vector<double> ratios;
  bool sameWork = true;
  Run with, without;
  for (int pair = 0; pair < options.pairs; ++pair) {
    without = run(plain, options.steps);
    with = run(laden, options.steps);
    ratios.push_back(with.seconds / without.seconds);
    sameWork &= with.report.candidates == without.report.candidates &&
                with.report.contacts == without.report.contacts &&
                with.report.evaluations == without.report.evaluations &&
                with.report.listRebuilds == without.report.listRebuilds;
  }
  std::sort(ratios.begin(), ratios.end());
  const auto [low, high] = medianInterval(ratios.size());
  const double median = ratios[ratios.size() / 2];
  const bool holds = sameWork && (median <= kAllowed || ratios[low] <= kAllowed);
  std::printf("%-58s %s %9lld %9lld %6lld %8.3f (%.3f to %.3f) %s\n", idle.what.c_str(),
              sameWork ? "same work " : "OTHER WORK", static_cast<long long>(with.report.candidates),
              static_cast<long long>(with.report.contacts), static_cast<long long>(with.report.listRebuilds),
              median, ratios[low], ratios[high], holds ? "" : "<-- pays");
  std::fflush(stdout);
  return holds;
}

}  // namespace

void addSkipCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("skip", "What scenes pay for what they have and do not use");
  const auto options = std::make_shared<SkipOptions>();
  command->add_option("--spheres", options->spheres, "grains")
      ->check(CLI::Range(100, 10'000'000))
      ->capture_default_str();
  command->add_option("--steps", options->steps, "timed at a time")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  command->add_option("--ground", options->ground, "particles of idle ground")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  command->add_option("--pairs", options->pairs, "of runs, with and without")
      ->check(CLI::Range(15, 10'000))
      ->capture_default_str();
  command->callback([options, &status] {
    std::printf("%-58s %-10s %9s %9s %6s %8s\n", "beside the grains, idle", "", "offered", "contacts",
                "lists", "time, with over without (95 %)");
    bool all = true;
    for (const Idle& idle : idleThings(*options)) all &= compare(idle, *options);
    status = all ? 0 : 1;
  });
}

}  // namespace granular_bench
