// SPDX-License-Identifier: MIT
// `granular_demo export SCENE --lammps DIR`: a scene as input for LAMMPS, with a README of what was left out.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace granular_demo {

struct ExportArguments {
  std::string scene;
  std::string scale = "default";
  std::filesystem::path lammps;
  std::optional<std::uint64_t> seed;
  double after = 0.0;              ///< s that are simulated here first
  std::optional<double> timeStep;  ///< s; none: a fiftieth of the shortest contact time
  int threads = 1;
};

/// Adds the subcommand; its arguments are left in `arguments`.
CLI::App* addExportCommand(CLI::App& app, ExportArguments& arguments);

/// Returns the exit status. Throws SceneError for a bad scene, std::runtime_error if a file cannot be
/// written.
int runExport(const ExportArguments& arguments);

}  // namespace granular_demo
