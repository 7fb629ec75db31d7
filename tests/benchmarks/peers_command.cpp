// SPDX-License-Identifier: MIT
// granular_bench peers: ours against LAMMPS, from the same state under the same law at the same step, one
// evaluation a step, one core. First the answers: how far apart the particles are after 1, 10 and 100 steps;
// where the laws are the same, only rounding may differ, or nothing is timed. Then times in turn, and memory.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/lammps_peer.h"

namespace granular_bench {
namespace {

using granular::ContactPrecision;
using granular::LammpsStyle;
using granular::MaterialPairDef;
using granular::NormalLaw;
using granular::ShearLaw;

struct PeersOptions {
  std::filesystem::path lammps = GRANULAR_LAMMPS;
  std::int64_t particles = 50'000;
  std::int64_t steps = 200;
  double timeStep = 4e-5;  // s: 18.5 % of the Rayleigh time
  int repeats = 5;
  int threads = 1;  // for packing
  std::string only;
};

// After ten steps without friction, in radii: rounding. Spheres are moved by the same formulas in both codes.
constexpr double kSameSpheres = 1e-9;
// Clumps turn by an iteration there, some (w dt)^3/12 off a step: 7e-6 in ten steps at 500 rad/s; here
// exactly.
constexpr double kSameClumps = 1e-5;
// Over all timed steps under laws that differ as notes say, root mean square, in radii: the same motion
// still.
constexpr double kSameMotion = 0.1;

MaterialPairDef pairOf(NormalLaw normal, ShearLaw shear) {
  return {.normal = {.law = normal}, .shear = {.law = shear}};
}

/// Without friction: in both codes the same law, whatever the size.
MaterialPairDef frictionless() {
  MaterialPairDef pair = pairOf(NormalLaw::HertzTsuji, ShearLaw::RegularisedCoulomb);
  pair.friction = 0.0;
  return pair;
}

/// Law 18 as LAMMPS can have it exactly, but for the arm of the tangential velocity: both dampers constant.
/// The numbers are about those that restitution 0.5 and the default viscosity give at 1 m/s.
MaterialPairDef constantDampers() {
  MaterialPairDef pair = pairOf(NormalLaw::HertzConstantDamping, ShearLaw::RegularisedCoulomb);
  pair.normal.damping = 0.1;    // N s/m
  pair.shear.viscosity = 0.15;  // N s/m
  return pair;
}

struct Spread {
  double low = 0.0, median = 0.0, high = 0.0;
};
Spread spreadOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return {values.front(), values[values.size() / 2], values.back()};
}

void printLine(const std::string& what, const Spread& s, const char* unit) {
  std::printf("    %-46s %9.3f %s (%.3f to %.3f)\n", what.c_str(), s.median, unit, s.low, s.high);
  std::fflush(stdout);
}

/// How far both codes are apart after 1, 10, 100 steps; after ten in radii.
double compare(const LammpsPeer& peer, const PackedGrains& grains, const char* what,
               const MaterialPairDef& pair, ContactPrecision precision = ContactPrecision::Double) {
  double afterTen = 0.0;
  std::printf("    %-46s", what);
  for (const std::int64_t steps : {1, 10, 100}) {
    const LammpsPeer::Apart apart = peer.apart(grains, pair, steps, LammpsStyle::Granular, precision);
    std::printf(" %9.2g", apart.worst / kPackedRadius);
    if (steps == 10) afterTen = apart.worst / kPackedRadius;
  }
  std::printf("\n");
  std::fflush(stdout);
  return afterTen;
}

void checkAnswers(const LammpsPeer& peer, const PackedGrains& grains) {
  const bool spheres = grains.shape.particles.size() == 1;
  const double same = spheres ? kSameSpheres : kSameClumps;
  std::printf("  apart after 1, 10, 100 steps, farthest particle, in radii:\n");
  const double apart = compare(peer, grains, "no friction", frictionless());
  compare(peer, grains, "no friction, ours in mixed precision", frictionless(), ContactPrecision::Mixed);
  compare(peer, grains, "law 18, constant dampers: the arm", constantDampers());
  compare(peer, grains, "law 18, viscosity matched at one overlap",
          pairOf(NormalLaw::HertzTsuji, ShearLaw::RegularisedCoulomb));
  compare(peer, grains, "law 19", pairOf(NormalLaw::HertzTsuji, ShearLaw::StaticFriction));
  if (!(apart <= same)) {
    throw std::runtime_error("the codes do not agree without friction: nothing is timed");
  }
}

/// LAMMPS's fastest skin for this scene.
double bestSkin(LammpsPeer& peer, const PackedGrains& grains, std::int64_t steps) {
  double best = 0.0, shortest = 0.0;
  for (const double skin : {0.1, 0.2, 0.3, 0.5}) {
    peer.setSkin(skin * kPackedRadius);
    const double seconds = peer.theirs(grains, pairOf(NormalLaw::HertzTsuji, ShearLaw::RegularisedCoulomb),
                                       steps, LammpsStyle::Granular)
                               .seconds;
    if (best == 0.0 || seconds < shortest) {
      best = skin;
      shortest = seconds;
    }
  }
  peer.setSkin(best * kPackedRadius);
  return best;
}

struct Timed {
  const char* name;
  MaterialPairDef pair;
  LammpsStyle style;
};

void timeLaw(const LammpsPeer& peer, const PackedGrains& grains, const Timed& timed,
             const PeersOptions& options) {
  const LammpsPeer::Apart apart =
      peer.apart(grains, timed.pair, options.steps, timed.style, ContactPrecision::Double);
  std::printf("  %s: %.2g radii apart after %lld steps (root mean square)\n", timed.name,
              apart.rootMeanSquare / kPackedRadius, static_cast<long long>(options.steps));
  if (!(apart.rootMeanSquare <= kSameMotion * kPackedRadius)) {
    throw std::runtime_error("the codes do not move alike: this law is not timed");
  }
  const double work = 1e-6 * static_cast<double>(options.steps) *
                      static_cast<double>(grains.motions.size() * grains.shape.particles.size());
  std::vector<double> ours, theirs, mixed, ratio, mixedRatio;
  LammpsPeer::Cost here, there;
  for (int repeat = 0; repeat < options.repeats; ++repeat) {
    there = peer.theirs(grains, timed.pair, options.steps, timed.style);
    const double single = peer.ours(grains, timed.pair, options.steps, ContactPrecision::Mixed).seconds;
    here = peer.ours(grains, timed.pair, options.steps, ContactPrecision::Double);
    ours.push_back(work / here.seconds);
    mixed.push_back(work / single);
    theirs.push_back(work / there.seconds);
    ratio.push_back(there.seconds / here.seconds);
    mixedRatio.push_back(there.seconds / single);
  }
  printLine("LAMMPS", spreadOf(theirs), "million particle steps a second");
  printLine("ours", spreadOf(ours), "million particle steps a second");
  printLine("ours, laws in single precision", spreadOf(mixed), "million particle steps a second");
  printLine("ours over LAMMPS", spreadOf(ratio), "times");
  printLine("ours, laws in single precision, over LAMMPS", spreadOf(mixedRatio), "times");
  std::printf("    %-46s %9lld there, %lld here\n", "lists made anew",
              static_cast<long long>(there.listBuilds), static_cast<long long>(here.listBuilds));
  std::printf("    %-46s %9.0f there, %.0f here: %.2f times\n", "bytes a particle", there.bytesPerParticle,
              here.bytesPerParticle, there.bytesPerParticle / here.bytesPerParticle);
}

void compareScene(LammpsPeer& peer, const PackedGrains& grains, const std::string& name,
                  const PeersOptions& options) {
  std::printf("%s: %zu grains, %zu particles, dt %.3g s\n", name.c_str(), grains.motions.size(),
              grains.motions.size() * grains.shape.particles.size(), options.timeStep);
  checkAnswers(peer, grains);
  std::printf("  LAMMPS's fastest skin: %.1f radii\n", bestSkin(peer, grains, options.steps));
  const Timed laws[] = {
      {"law 18, pair_style granular", pairOf(NormalLaw::HertzTsuji, ShearLaw::RegularisedCoulomb),
       LammpsStyle::Granular},
      {"law 19, pair_style granular", pairOf(NormalLaw::HertzTsuji, ShearLaw::StaticFriction),
       LammpsStyle::Granular},
      {"law 19, pair_style gran/hertz/history",
       pairOf(NormalLaw::HertzViscoelastic, ShearLaw::StaticFriction), LammpsStyle::HertzHistory}};
  for (const Timed& law : laws) timeLaw(peer, grains, law, options);
}

void runPeers(const PeersOptions& options) {
  if (options.lammps.empty()) {
    throw std::runtime_error(
        "LAMMPS was not found when this was built (Debian package lammps); --lammps FILE");
  }
  LammpsPeer peer(options.lammps, std::filesystem::temp_directory_path() / "granular_bench_peers",
                  options.timeStep);
  for (const bool tetrahedra : {false, true}) {
    const std::string shape = tetrahedra ? "tetra" : "spheres";
    if (!shape.starts_with(options.only.substr(0, options.only.find(',')))) continue;
    PackedGrains grains = packGrains(tetrahedra, options.particles, options.threads);
    for (const bool flowing : {false, true}) {
      const std::string name = shape + (flowing ? ", flowing" : ", at rest");
      if (flowing) grains = letFlow(grains, options.threads);
      if (name.starts_with(options.only)) compareScene(peer, grains, name, options);
    }
  }
}

}  // namespace

void addPeersCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("peers", "Against LAMMPS: same state, law and step; times in turn");
  const auto options = std::make_shared<PeersOptions>();
  command->add_option("--lammps", options->lammps, "LAMMPS's program");
  command->add_option("--particles", options->particles, "round particles in a scene")
      ->check(CLI::Range(500, 10'000'000))
      ->capture_default_str();
  command->add_option("--steps", options->steps, "steps that are timed at a time")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--repeats", options->repeats, "times, in turn, of which the median is printed")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command->add_option("--packing-threads", options->threads, "threads that pack; one core is timed")
      ->check(CLI::Range(1, 1024));
  command->add_option("--only", options->only, "scenes that begin so: \"spheres\", \"tetra, flowing\"");
  command->callback([options, &status] {
    runPeers(*options);
    status = 0;
  });
}

}  // namespace granular_bench
