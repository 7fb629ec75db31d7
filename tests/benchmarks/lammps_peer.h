// SPDX-License-Identifier: MIT
// A packed scene run by us and by LAMMPS from the same state: where the particles go, how long it takes, how
// much memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "granular/io/lammps_writer.h"
#include "tests/benchmarks/packed_scene.h"

namespace granular_bench {

/// Both codes' side of a comparison. Plain velocity Verlet, one evaluation a step.
class LammpsPeer {
 public:
  /// program: LAMMPS; folder: for its files, made anew and removed in the end. timeStep: s.
  LammpsPeer(std::filesystem::path program, std::filesystem::path folder, double timeStep);
  ~LammpsPeer();
  LammpsPeer(const LammpsPeer&) = delete;
  LammpsPeer& operator=(const LammpsPeer&) = delete;

  /// LAMMPS's skin, m, in all runs that follow.
  void setSkin(double skin) { skin_ = skin; }

  struct Apart {
    double worst = 0.0, rootMeanSquare = 0.0;  ///< distance of a particle here from itself there, m
  };
  /// After `steps` steps. Throws std::runtime_error if either code did not make them. precision: of ours.
  Apart apart(const PackedGrains& grains, const granular::MaterialPairDef& pair, std::int64_t steps,
              granular::LammpsStyle style, granular::ContactPrecision precision) const;

  struct Cost {
    double seconds = 0.0;           ///< wall time of the steps, without set-up
    std::int64_t listBuilds = 0;    ///< in these steps
    double bytesPerParticle = 0.0;  ///< resident memory over that of a program with nothing to do
  };
  Cost theirs(const PackedGrains& grains, const granular::MaterialPairDef& pair, std::int64_t steps,
              granular::LammpsStyle style) const;
  Cost ours(const PackedGrains& grains, const granular::MaterialPairDef& pair, std::int64_t steps,
            granular::ContactPrecision precision) const;

 private:
  PackedScene build(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                    granular::ContactPrecision precision = granular::ContactPrecision::Double) const;
  granular::StepReport advance(granular::GranularSystem& system, std::int64_t steps) const;
  void write(const granular::GranularSystem& system, std::int64_t steps, bool dump,
             granular::LammpsStyle style) const;

  std::filesystem::path program_, folder_;
  double timeStep_, skin_ = 0.0;
  std::int64_t emptyBytes_ = 0;
};

}  // namespace granular_bench
