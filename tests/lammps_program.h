// SPDX-License-Identifier: MIT
// Running LAMMPS as a program on input that we wrote, and reading what it leaves.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "granular/base/pose.h"

namespace granular_test {

struct LammpsRun {
  double loopSeconds = 0.0;     ///< wall time of the steps, as its log has it; without set-up
  std::int64_t listBuilds = 0;  ///< of its neighbour lists, in these steps
  std::int64_t peakBytes = 0;   ///< largest resident memory of the process
};

/// Runs `program` on in.granular in `folder`, on one core. Throws std::runtime_error with LAMMPS's own
/// complaint if it does not come to its end.
LammpsRun runLammps(const std::filesystem::path& program, const std::filesystem::path& folder);

/// One line of particles.dump.
struct DumpedAtom {
  granular::Vector3 position, velocity, angularVelocity, force;  ///< m, m/s, rad/s, N
};
struct DumpedState {
  std::int64_t step = 0;
  std::vector<DumpedAtom> atoms;  ///< by id
};
/// Every state in particles.dump of `folder`. Throws std::runtime_error if there is none.
std::vector<DumpedState> readDump(const std::filesystem::path& folder);

}  // namespace granular_test
