// SPDX-License-Identifier: MIT
#include "tests/benchmarks/verification_figures.h"

#include <array>
#include <fstream>
#include <stdexcept>

#include "demos/csv_file.h"
#include "demos/render/plot.h"
#include "tests/verification/chung_ooi_curves.h"
#include "tests/verification/covering_drop.h"

namespace granular_bench {
namespace {

namespace verification = granular::verification;
using granular_demo::Color;
using granular_demo::Line;
using granular_demo::Marker;

const std::array<Color, 2> kMaterialColors{{{0.00f, 0.45f, 0.70f}, {0.85f, 0.35f, 0.05f}}};
const Color kPublishedColor{0.05f, 0.05f, 0.05f};

granular_demo::Panel panelOf(const verification::CurveFigure& figure) {
  granular_demo::Panel panel{
      .title = figure.title, .x = {.label = figure.xLabel}, .y = {.label = figure.yLabel}};
  panel.y.low = figure.yLow;
  panel.y.high = figure.yHigh;
  std::size_t measured = 0, expected = 0;
  for (const verification::Curve& curve : figure.curves) {
    granular_demo::Series series{.name = curve.name, .x = curve.x, .y = curve.y};
    switch (curve.kind) {
      case verification::CurveKind::Measured:
        series.line = Line::none;
        series.marker = Marker::circle;
        series.color = kMaterialColors[measured++ % kMaterialColors.size()];
        break;
      case verification::CurveKind::Expected:
        series.width = 1.2;
        series.color = kMaterialColors[expected++ % kMaterialColors.size()];
        break;
      case verification::CurveKind::Published:
        series.line = Line::none;
        series.marker = Marker::cross;
        series.color = kPublishedColor;
        break;
    }
    panel.series.push_back(series);
  }
  return panel;
}

/// One line a point: the figure's name, the curve's name, x, y.
void writeCurves(const std::vector<verification::CurveFigure>& figures, const std::filesystem::path& path) {
  std::ofstream out(path);
  out.precision(17);
  out << "figure,curve,x,y\n";
  for (const verification::CurveFigure& figure : figures) {
    for (const verification::Curve& curve : figure.curves) {
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        out << '"' << figure.title << " (" << figure.yLabel << ")\",\"" << curve.name << "\"," << curve.x[i]
            << ',' << curve.y[i] << '\n';
      }
    }
  }
  if (!out.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

void writeChungOoi(const std::filesystem::path& folder) {
  const std::vector<verification::CurveFigure> curves = verification::chungOoiFigures();
  granular_demo::Figure figure{
      .title = "One impact, after Chung & Ooi 2011: points simulated, lines integrated apart", .columns = 2};
  for (const verification::CurveFigure& f : curves) figure.panels.push_back(panelOf(f));
  granular_demo::writeFigure(figure, folder / "chung_ooi.png");
  writeCurves(curves, folder / "chung_ooi.csv");
}

void writeCoverings(const std::filesystem::path& folder) {
  const auto all = verification::coveringSeries({0.04, 0.025, 0.016, 0.01, 0.006, 0.004, 0.0025});
  granular_demo::CsvFile csv(folder / "covering.csv", {"pose_faces_at_the_plane", "particles", "restitution",
                                                       "stiffness_ratio", "overlap_ratio"});
  const granular_demo::Axis particles{.label = "particles on the cube",
                                      .scale = granular_demo::Scale::logarithmic};
  granular_demo::Panel restitution{.title = "Restitution, asked 0.5", .x = particles, .y = {.label = "e"}};
  restitution.y.low = 0.4;
  restitution.y.high = 0.6;
  granular_demo::Panel stiffness{
      .title = "Stiffness at rest", .x = particles, .y = {.label = "force over that of the true cube"}};
  granular_demo::Panel overlap{
      .title = "Deepest overlap without loss", .x = particles, .y = {.label = "over that of the true cube"}};
  granular_demo::Panel sideways{
      .title = "Sideways, flat", .x = particles, .y = {.label = "over what was asked for"}};
  for (granular_demo::Panel* panel : {&stiffness, &overlap, &sideways}) {
    panel->y.low = 0.9;
    panel->y.high = 1.1;
  }
  for (const verification::CoveringSeries& s : all) {
    const auto add = [&](granular_demo::Panel& panel, const std::vector<double>& values) {
      panel.series.push_back({.name = panel.y.label == "e" ? nameOf(s.pose) : "",
                              .x = s.particles,
                              .y = values,
                              .marker = Marker::circle});
    };
    add(restitution, s.restitution);
    add(stiffness, s.stiffness);
    add(overlap, s.overlap);
    if (!s.friction.empty()) {
      sideways.series.push_back(
          {.name = "friction", .x = s.particles, .y = s.friction, .marker = Marker::circle});
      sideways.series.push_back(
          {.name = "shear stiffness", .x = s.particles, .y = s.shearStiffness, .marker = Marker::cross});
    }
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
      csv.row({1.0 + static_cast<double>(s.pose), s.particles[i], s.restitution[i], s.stiffness[i],
               s.overlap[i]});
    }
  }
  granular_demo::writeFigure(
      {.title = "A covered cube dropped flat, on its edge and on its corner, by how densely it is covered",
       .panels = {restitution, stiffness, overlap, sideways},
       .columns = 2},
      folder / "covering.png");
}

}  // namespace

void writeVerificationFigures(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  writeChungOoi(folder);
  writeCoverings(folder);
}

}  // namespace granular_bench
