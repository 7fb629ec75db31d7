// SPDX-License-Identifier: MIT
// granular_bench scaling: time and memory a particle from a thousand to millions, and with several threads.
#include <malloc.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
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
  LatticeScene scene = makeLattice({.spheres = particles, .speed = options.speed, .threads = threads});
  const std::vector<double> times = timesOf(scene.system, particles, options.repeats);
  const granular::StepReport report = scene.system.measure();
  std::printf("%10lld %8d %12.1f (%.1f to %.1f) %14.2f %14.0f\n", static_cast<long long>(particles), threads,
              times[times.size() / 2], times.front(), times.back(),
              2.0 * static_cast<double>(report.contacts) / static_cast<double>(particles),
              static_cast<double>(residentBytes() - before) / static_cast<double>(particles));
  std::fflush(stdout);
}

void runScaling(const ScalingOptions& options) {
  std::printf("%10s %8s %29s %14s %14s\n", "particles", "threads", "ns a particle and step", "contacts each",
              "bytes each");
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
  command->callback([options, &status] {
    runScaling(*options);
    status = 0;
  });
}

}  // namespace granular_bench
