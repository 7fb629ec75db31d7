// SPDX-License-Identifier: MIT
// granular_bench scaling: time and memory a particle from a thousand to millions, and with several threads.
#include <malloc.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/lattice_scene.h"

namespace granular_bench {
namespace {

struct ScalingOptions {
  std::int64_t most = 4'000'000;
  std::int64_t threadParticles = 100'000;
  int threads = 2;
  int repeats = 5;
  double speed = 0.05;  // m/s
  granular::Stepper stepper = granular::Stepper::Verlet;
  granular::ShearLaw shear = granular::ShearLaw::RegularisedCoulomb;
};

constexpr double kStep = 4e-5;                      // s
constexpr std::int64_t kParticleSteps = 2'000'000;  // timed at a time, about

/// Nanoseconds a particle and step of each repeat, sorted.
std::vector<double> timesOf(granular::GranularSystem& system, std::int64_t particles, int repeats) {
  const std::int64_t steps = std::max<std::int64_t>(4, kParticleSteps / particles);
  const auto advance = [&] { return system.step(static_cast<double>(steps) * kStep); };
  advance();  // warm
  std::vector<double> times;
  for (int repeat = 0; repeat < repeats; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    advance();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    times.push_back(1e9 * taken.count() / (static_cast<double>(steps) * static_cast<double>(particles)));
  }
  std::sort(times.begin(), times.end());
  return times;
}

void line(const ScalingOptions& options, std::int64_t particles, int threads) {
  malloc_trim(0);
  const std::int64_t before = residentBytes();
  forgetPeak();
  const auto start = std::chrono::steady_clock::now();
  LatticeScene scene = makeLattice({.spheres = particles,
                                    .speed = options.speed,
                                    .integrator = {.stepper = options.stepper, .fixedSubStep = kStep},
                                    .shear = options.shear,
                                    .threads = threads});
  scene.system.measure();
  const std::chrono::duration<double> setUp = std::chrono::steady_clock::now() - start;
  const std::vector<double> times = timesOf(scene.system, particles, options.repeats);
  const granular::StepReport report = scene.system.measure();
  const auto each = [&](std::int64_t bytes) {
    return static_cast<double>(bytes - before) / static_cast<double>(particles);
  };
  std::printf("%10lld %8d %12.1f (%.1f to %.1f) %14.2f %11.0f %9.0f %9.2f\n",
              static_cast<long long>(particles), threads, times[times.size() / 2], times.front(),
              times.back(), 2.0 * static_cast<double>(report.contacts) / static_cast<double>(particles),
              each(residentBytes()), each(peakBytes()), setUp.count());
  std::fflush(stdout);
}

void runScaling(const ScalingOptions& options) {
  std::printf("%10s %8s %29s %14s %11s %9s %9s\n", "particles", "threads", "ns a particle and step",
              "contacts each", "bytes each", "at most", "set-up s");
  for (std::int64_t particles = 1'000; particles <= options.most;
       particles *= particles < 1'000'000 ? 10 : 4) {
    line(options, particles, 1);
  }
  for (int threads = 1; threads <= options.threads; threads *= 2)
    line(options, options.threadParticles, threads);
}

}  // namespace

void addScalingCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("scaling", "Time and memory a particle, by number and by threads");
  const auto options = std::make_shared<ScalingOptions>();
  command->add_option("--most", options->most, "largest number of particles")
      ->check(CLI::Range(1'000, 100'000'000))
      ->capture_default_str();
  command->add_option("--threads", options->threads, "most threads")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_option("--repeats", options->repeats, "times of which the median is printed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  const std::map<std::string, granular::Stepper> steppers = {{"verlet", granular::Stepper::Verlet},
                                                             {"leapfrog", granular::Stepper::Leapfrog},
                                                             {"rkf45", granular::Stepper::Rkf45}};
  command->add_option("--stepper", options->stepper, "how they step, 4e-5 s at a time")
      ->transform(CLI::CheckedTransformer(steppers));
  const std::map<std::string, granular::ShearLaw> laws = {{"18", granular::ShearLaw::RegularisedCoulomb},
                                                          {"19", granular::ShearLaw::StaticFriction}};
  command->add_option("--law", options->shear, "equation of the friction")
      ->transform(CLI::CheckedTransformer(laws));
  command->callback([options, &status] {
    runScaling(*options);
    status = 0;
  });
}

}  // namespace granular_bench
