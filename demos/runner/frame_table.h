// SPDX-License-Identifier: MIT
// frames.csv: one row a frame, and the same numbers for plots.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "demos/runner/csv_file.h"
#include "demos/runner/energy_balance.h"
#include "demos/runner/place_checks.h"
#include "demos/runner/run_totals.h"

namespace granular_demo {

/// What a frame did, beside the state at its end.
struct FrameRecord {
  int frame = 0;
  granular::StepReport state;  ///< at the end
  RunTotals work;              ///< of its ticks
  PlaceCounts places;
  double stepSeconds = 0.0, pictureSeconds = 0.0;  ///< wall time
  std::vector<double> meters;                      ///< in the order of the names given to the table
};

class FrameTable {
 public:
  /// Throws std::runtime_error if the file cannot be written.
  FrameTable(const std::filesystem::path& file, const std::vector<std::string>& meterColumns);
  void add(const FrameRecord& record, const BuiltScene& scene, const EnergyBalance& balance);

  static std::vector<std::string> columns(const std::vector<std::string>& meterColumns);
  /// All numbers of a column so far.
  std::vector<double> column(const std::string& name) const;

 private:
  std::vector<std::string> names_;
  CsvFile csv_;
  std::vector<std::vector<double>> rows_;
};

}  // namespace granular_demo
