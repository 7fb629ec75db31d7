// SPDX-License-Identifier: MIT
// granular_bench kernel: what one evaluation of all forces costs, stage by stage, on packed scenes, with laws
// in double and in single precision. Before a time is printed, contacts and overlaps are compared with those
// of a plain search written anew, and forces in single precision with those in double.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "granular/contact/pair_law.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/packed_scene.h"

namespace granular_bench {
namespace {

using granular::Stage;
using granular::Vector3;

constexpr int kStages = static_cast<int>(Stage::Measure);  // those before it are part of every sub-step
constexpr double kFrame = 5e-4;                            // s
constexpr double kAgreement = 1e-9;                        // of the largest overlap
constexpr double kMixedAgreement = 1e-4;                   // of the root mean square force

struct KernelOptions {
  std::int64_t particles = 50'000;
  int threads = 1;
  std::int64_t evaluations = 300;
  int repeats = 5;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Pairs of particles that overlap, by the voxels of a plain map: (first, second) -> overlap, m.
std::map<std::pair<std::int64_t, std::int64_t>, double> overlapsBySearch(
    const std::vector<granular::ParticleView>& particles) {
  double edge = 0.0;
  for (const granular::ParticleView& p : particles) edge = std::max(edge, 2.0 * p.radius);
  using Cell = std::array<int, 3>;
  const auto cellOf = [&](const Vector3& x) {
    return Cell{static_cast<int>(std::floor(x.x() / edge)), static_cast<int>(std::floor(x.y() / edge)),
                static_cast<int>(std::floor(x.z() / edge))};
  };
  std::map<Cell, std::vector<std::int64_t>> cells;
  std::map<std::pair<std::int64_t, std::int64_t>, double> overlaps;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(particles.size()); ++i) {
    const granular::ParticleView& a = particles[i];
    const Cell own = cellOf(a.position);
    for (int n = 0; n < 27; ++n) {
      const auto found = cells.find({own[0] + n % 3 - 1, own[1] + n / 3 % 3 - 1, own[2] + n / 9 - 1});
      if (found == cells.end()) continue;
      for (const std::int64_t j : found->second) {
        const granular::ParticleView& b = particles[j];
        const double overlap = a.radius + b.radius - (a.position - b.position).norm();
        if (overlap > 0.0 && a.ownerIndex != b.ownerIndex) overlaps[{j, i}] = overlap;
      }
    }
    cells[own].push_back(i);
  }
  return overlaps;
}

/// Throws std::runtime_error if the system's contacts between grains are not those of the plain search, or
/// some overlap differs by more than kAgreement of the largest.
void checkContacts(granular::GranularSystem& system) {
  std::vector<granular::ParticleView> particles;
  system.readParticles(particles);
  std::vector<std::int64_t> firstOfGrain;
  for (std::int64_t i = 0; i < static_cast<std::int64_t>(particles.size()); ++i) {
    const auto grain = static_cast<std::size_t>(particles[i].ownerIndex);
    if (grain == firstOfGrain.size()) firstOfGrain.push_back(i);
  }
  auto expected = overlapsBySearch(particles);
  double largest = 0.0;
  for (const auto& [pair, overlap] : expected) largest = std::max(largest, overlap);
  std::vector<granular::ContactView> contacts;
  system.readContacts(contacts);
  for (const granular::ContactView& contact : contacts) {
    if (contact.ownerKind[1] != granular::OwnerKind::Grain) continue;
    std::array<std::int64_t, 2> particle{};
    for (int side = 0; side < 2; ++side) {
      particle[side] = firstOfGrain[contact.ownerIndex[side]] + contact.particle[side];
    }
    const auto found = expected.find(std::minmax(particle[0], particle[1]));
    if (found == expected.end() || std::abs(found->second - contact.overlap) > kAgreement * largest) {
      throw std::runtime_error("the pipeline's contacts are not those of a plain search");
    }
    expected.erase(found);
  }
  if (!expected.empty()) throw std::runtime_error("the pipeline misses contacts that a plain search finds");
}

/// Prints how far forces in single precision are from those in double at the same state. Throws
/// std::runtime_error if that is farther than kMixedAgreement.
void checkMixed(granular::GranularSystem& system) {
  granular::IntegratorDef integrator = system.integrator();
  std::vector<granular::ContactView> exact, mixed;
  system.readContacts(exact);
  integrator.precision = granular::ContactPrecision::Mixed;
  system.setIntegrator(integrator);
  system.readContacts(mixed);
  double sum = 0.0, difference = 0.0, largest = 0.0;
  if (mixed.size() != exact.size()) throw std::runtime_error("other contacts in single precision");
  for (std::size_t n = 0; n < exact.size(); ++n) {
    const double apart = (mixed[n].force - exact[n].force).squaredNorm();
    sum += exact[n].force.squaredNorm();
    difference += apart;
    largest = std::max(largest, apart);
  }
  const double unit = std::sqrt(sum / static_cast<double>(exact.size()));
  largest = std::sqrt(largest) / unit;
  std::printf(
      "  laws in single precision: forces off by %.2g (root mean square), %.2g at most, of their own root "
      "mean square\n",
      std::sqrt(difference / sum), largest);
  if (!(largest < kMixedAgreement)) throw std::runtime_error("forces in single precision are not the same");
}

void timeScene(const PackedSceneDef& def, const KernelOptions& options, granular::GranularSystem& system) {
  const double particles = static_cast<double>(system.particleCount());
  std::array<std::vector<double>, kStages> nanoseconds;  // a particle and evaluation, by repeat
  std::vector<double> total, processor;
  std::int64_t allEvaluations = 0, rebuilds = 0;
  granular::StepReport report;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    std::int64_t evaluations = 0;
    std::array<double, kStages> seconds{};
    const std::clock_t start = std::clock();
    while (evaluations < options.evaluations) {
      report = system.step(kFrame);
      evaluations += report.evaluations;
      rebuilds += report.listRebuilds;
      for (int s = 0; s < kStages; ++s) seconds[s] += report.stageSeconds[s];
    }
    const double each = 1e9 / (particles * static_cast<double>(evaluations));
    total.push_back(0.0);
    for (int s = 0; s < kStages; ++s) {
      nanoseconds[s].push_back(seconds[s] * each);
      total.back() += seconds[s] * each;
    }
    processor.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * each);
    allEvaluations += evaluations;
  }
  const double contacts = static_cast<double>(report.contacts);
  const bool isMixed = system.integrator().precision == granular::ContactPrecision::Mixed;
  std::printf("%s, %s, %d thread%s: %.0f particles, %.2f contacts each, %.0f evaluations a candidate list\n",
              def.name().c_str(), isMixed ? "mixed" : "double", def.threads, def.threads == 1 ? "" : "s",
              particles, 2.0 * contacts / particles,
              static_cast<double>(allEvaluations) / static_cast<double>(std::max<std::int64_t>(1, rebuilds)));
  const auto line = [&](const char* what, const std::vector<double>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    std::printf("  %-24s %7.2f ns a particle (%.2f to %.2f), %6.2f ns a contact\n", what, median(values),
                *low, *high, median(values) * particles / contacts);
  };
  for (int s = 0; s < kStages; ++s) line(granular::stageName(static_cast<Stage>(s)), nanoseconds[s]);
  line("all", total);
  line("all, processor time", processor);
  std::printf("  %.2f million particle evaluations a second\n", 1e3 / median(total));
}

void timeScene(const PackedSceneDef& def, const KernelOptions& options) {
  PackedScene scene = makePackedScene(def);
  checkContacts(scene.system);
  timeScene(def, options, scene.system);
  checkMixed(scene.system);
  timeScene(def, options, scene.system);
}

}  // namespace

void addKernelCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("kernel", "What an evaluation costs, stage by stage");
  const auto options = std::make_shared<KernelOptions>();
  command->add_option("--particles", options->particles, "round particles in a scene")
      ->check(CLI::Range(1'000, 10'000'000));
  command->add_option("--threads", options->threads, "threads")->check(CLI::Range(1, 1024));
  command->add_option("--evaluations", options->evaluations, "evaluations that are timed at a time");
  command->add_option("--repeats", options->repeats, "times of which the median is printed")
      ->check(CLI::Range(1, 1000));
  command->callback([options, &status] {
    for (const bool tetrahedra : {false, true}) {
      for (const bool flowing : {false, true}) {
        for (const bool memory : {false, true}) {
          timeScene({.tetrahedra = tetrahedra,
                     .flowing = flowing,
                     .memory = memory,
                     .particles = options->particles,
                     .threads = options->threads},
                    *options);
        }
      }
    }
    status = 0;
  });
}

}  // namespace granular_bench
