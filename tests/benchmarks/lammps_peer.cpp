// SPDX-License-Identifier: MIT
#include "tests/benchmarks/lammps_peer.h"

#include <malloc.h>

#include <chrono>
#include <cmath>
#include <stdexcept>

#include "tests/benchmarks/lattice_scene.h"
#include "tests/lammps_program.h"

namespace granular_bench {

LammpsPeer::LammpsPeer(std::filesystem::path program, std::filesystem::path folder, double timeStep)
    : program_(std::move(program)), folder_(std::move(folder)), timeStep_(timeStep) {
  granular::GranularSystem system;
  system.addGrain({.shape = system.addGrainShape(granular::sphereShape(kPackedRadius)),
                   .material = system.addMaterial({})});
  write(system, 0, false, granular::LammpsStyle::Granular);
  emptyBytes_ = granular_test::runLammps(program_, folder_).peakBytes;
}

LammpsPeer::~LammpsPeer() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

PackedScene LammpsPeer::build(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                              granular::ContactPrecision precision) const {
  return makePackedScene(grains, pair,
                         {.stepper = granular::Stepper::Verlet,
                          .fixedSubStep = timeStep_,
                          .precision = precision,
                          .turnSpheres = false},
                         1);
}

granular::StepReport LammpsPeer::advance(granular::GranularSystem& system, std::int64_t steps) const {
  const granular::StepReport report = system.step(static_cast<double>(steps) * timeStep_);
  if (report.subSteps != steps || report.rejectedTrials != 0) {
    throw std::runtime_error("made " + std::to_string(report.subSteps) + " sub-steps of " +
                             std::to_string(steps));
  }
  return report;
}

void LammpsPeer::write(const granular::GranularSystem& system, std::int64_t steps, bool dump,
                       granular::LammpsStyle style) const {
  std::filesystem::remove_all(folder_);
  granular::writeLammps(system, folder_,
                        {.timeStep = timeStep_,
                         .steps = steps,
                         .dumpEvery = dump ? std::max<std::int64_t>(1, steps) : 0,
                         .skin = skin_,
                         .style = style});
}

LammpsPeer::Apart LammpsPeer::apart(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                                    std::int64_t steps, granular::LammpsStyle style,
                                    granular::ContactPrecision precision) const {
  PackedScene scene = build(grains, pair, precision);
  write(scene.system, steps, true, style);
  granular_test::runLammps(program_, folder_);
  const granular_test::DumpedState state = granular_test::readDump(folder_).back();
  if (state.step != steps) throw std::runtime_error("LAMMPS's last state is not that after the last step");
  advance(scene.system, steps);
  std::vector<granular::ParticleView> particles;
  scene.system.readParticles(particles);
  Apart apart;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const double distance = (particles[i].position - state.atoms.at(i).position).norm();
    apart.worst = std::max(apart.worst, distance);
    apart.rootMeanSquare += distance * distance;
  }
  apart.rootMeanSquare = std::sqrt(apart.rootMeanSquare / static_cast<double>(particles.size()));
  return apart;
}

LammpsPeer::Cost LammpsPeer::theirs(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                                    std::int64_t steps, granular::LammpsStyle style) const {
  std::int64_t particles = 0;
  {
    const PackedScene scene = build(grains, pair);
    particles = scene.system.particleCount();
    write(scene.system, steps, false, style);
  }
  const granular_test::LammpsRun run = granular_test::runLammps(program_, folder_);
  return {run.loopSeconds, run.listBuilds,
          static_cast<double>(run.peakBytes - emptyBytes_) / static_cast<double>(particles)};
}

LammpsPeer::Cost LammpsPeer::ours(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                                  std::int64_t steps, granular::ContactPrecision precision) const {
  malloc_trim(0);  // what was freed before must not be counted as ours for nothing
  const std::int64_t before = residentBytes();
  PackedScene scene = build(grains, pair, precision);
  scene.system.measure();  // layout, first list and first forces, which LAMMPS's time leaves out too
  const auto start = std::chrono::steady_clock::now();
  const std::int64_t listBuilds = advance(scene.system, steps).listRebuilds;
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  return {seconds.count(), listBuilds,
          static_cast<double>(residentBytes() - before) / static_cast<double>(scene.system.particleCount())};
}

}  // namespace granular_bench
