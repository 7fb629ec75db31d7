// SPDX-License-Identifier: MIT
// Figures of lines and points for benchmarks and reports, to a PNG file (drawn by cairo).
// Every text may hold ^{...} and _{...} for raised and lowered parts.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "demos/render/axis.h"
#include "demos/render/color.h"

namespace granular_demo {

enum class Line { none, solid, dashed, dotted };
enum class Marker { none, circle, square, triangle, diamond, cross };

/// Points in the order in which the line joins them. A point that is not finite, or not > 0 on a logarithmic
/// axis, is left out and breaks the line.
struct Series {
  std::string name = {};               ///< in the legend; empty: not there
  std::vector<double> x = {}, y = {};  ///< same length
  Line line = Line::solid;
  Marker marker = Marker::none;
  std::optional<Color> color = {};  ///< sRGB; none: the next of eight that colour-blind readers tell apart
  double width = 1.8;               ///< of the line, points
};

struct Axis {
  std::string label = {};
  Scale scale = Scale::linear;
  std::optional<double> low = {}, high = {};  ///< none: around the data
};

struct Panel {
  std::string title = {};
  Axis x = {}, y = {};
  std::vector<Series> series = {};
};

struct Figure {
  std::string title = {};
  std::vector<Panel> panels = {};  ///< row by row
  int columns = 1;                 ///< panels side by side
  double panelWidth = 460.0;       ///< points
  double panelHeight = 340.0;      ///< points
  double pixelsPerPoint = 2.0;     ///< sharpness, (0, 10]
};

/// @throws std::invalid_argument for a figure that cannot be drawn, std::runtime_error when the file cannot
/// be written
void writeFigure(const Figure& figure, const std::filesystem::path& path);

}  // namespace granular_demo
