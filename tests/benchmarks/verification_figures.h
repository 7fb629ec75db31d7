// SPDX-License-Identifier: MIT
// Figures of `granular_bench verify --plots`: the curves of Chung & Ooi 2011, and covered bodies by how
// densely they are covered.
#pragma once

#include <filesystem>

namespace granular_bench {

/// Writes chung_ooi.png, covering.png and their CSV files into the folder, which is made.
void writeVerificationFigures(const std::filesystem::path& folder);

}  // namespace granular_bench
