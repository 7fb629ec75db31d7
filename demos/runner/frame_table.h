// SPDX-License-Identifier: MIT
// frames.csv: one row a frame, the state at its end and what it cost. demos/scenes/README.md lists the
// columns.
#pragma once

#include "demos/runner/csv_file.h"
#include "demos/runner/place_checks.h"
#include "demos/runner/run_totals.h"

namespace granular_demo {

class FrameTable {
 public:
  explicit FrameTable(const std::filesystem::path& file);

  /// @param state  as it stands at the end of the frame
  /// @param work   summed over the frame's ticks
  void add(int frame, const granular::StepReport& state, const RunTotals& work, const PlaceCounts& places,
           double stepSeconds, double pictureSeconds);

  static std::vector<std::string> columns();

 private:
  CsvFile csv_;
};

}  // namespace granular_demo
