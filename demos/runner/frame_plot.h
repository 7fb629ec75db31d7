// SPDX-License-Identifier: MIT
// frames.png: the numbers of frames.csv against time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "demos/runner/frame_table.h"

namespace granular_demo {

/// Energies, overlaps, contacts, work of the integrator, wall time by stage, and the first column of each
/// meter. Throws std::runtime_error if the file cannot be written.
void plotFrames(const FrameTable& table, const std::string& title,
                const std::vector<std::string>& meterColumns, const std::filesystem::path& file);

}  // namespace granular_demo
