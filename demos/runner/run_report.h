// SPDX-License-Identifier: MIT
// report.json: what was run, on what, what came of it. demos/scenes/README.md explains the keys.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "demos/runner/run_scene.h"
#include "demos/scene/json_object.h"

namespace granular_demo {

/// @param commandLine  as the program was called
Json makeReport(const FinishedRun& run, const RunOptions& options,
                const std::vector<std::string>& commandLine);

/// Throws std::runtime_error if the file cannot be written.
void writeReport(const Json& report, const std::filesystem::path& file);

}  // namespace granular_demo
