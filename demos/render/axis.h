// SPDX-License-Identifier: MIT
// Numbers along an axis: its range, its place on paper and its ticks, linear or logarithmic.
#pragma once

#include <string>
#include <vector>

namespace granular_demo {

enum class Scale { linear, logarithmic };

struct Tick {
  double value = 0.0;
  std::string label;  ///< may hold ^{...} for a raised part; empty for a minor tick
};

/// What part of the numbers an axis shows.
struct AxisRange {
  Scale scale = Scale::linear;
  double low = 0.0, high = 1.0;  ///< low < high; both > 0 when logarithmic

  bool canShow(double value) const;     ///< finite, and > 0 on a logarithmic axis
  double fraction(double value) const;  ///< 0 at low, 1 at high
};

/// A range that shows all values, with a little room at both ends. Values that cannot be shown are skipped.
/// @throws std::invalid_argument, naming `field`, when none can
AxisRange rangeAround(Scale scale, const std::vector<double>& values, const std::string& field);

/// Ticks within a range, lowest first: steps of 1, 2 or 5 times a power of ten, or decades.
/// @param mostLabels  about how many labels have room, >= 2
std::vector<Tick> ticksOf(const AxisRange& range, int mostLabels);

}  // namespace granular_demo
