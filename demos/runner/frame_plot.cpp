// SPDX-License-Identifier: MIT
#include "demos/runner/frame_plot.h"

#include "demos/render/plot.h"

namespace granular_demo {
namespace {

class Panels {
 public:
  explicit Panels(const FrameTable& table) : table_(table), time_(table.column("time")) {}

  Panel panel(const std::string& title, const std::string& label,
              const std::vector<std::pair<std::string, std::string>>& columns) const {
    Panel panel;
    panel.title = title;
    panel.x.label = "time, s";
    panel.y.label = label;
    for (const auto& [column, name] : columns)
      panel.series.push_back({.name = name, .x = time_, .y = table_.column(column)});
    return panel;
  }

 private:
  const FrameTable& table_;
  std::vector<double> time_;
};

}  // namespace

void plotFrames(const FrameTable& table, const std::string& title,
                const std::vector<std::string>& meterColumns, const std::filesystem::path& file) {
  const Panels panels(table);
  Figure figure;
  figure.title = title;
  figure.columns = 3;
  figure.panelWidth = 380.0;
  figure.panelHeight = 260.0;
  figure.pixelsPerPoint = 1.5;
  figure.panels = {
      panels.panel(
          "Energy", "J",
          {{"kineticEnergy", "kinetic"}, {"elasticEnergy", "elastic"}, {"dissipated", "dissipated"}}),
      panels.panel("Balance error", "J", {{"balanceError", ""}}),
      panels.panel("Contacts", "", {{"contacts", ""}}),
      panels.panel("Overlap", "smaller radii", {{"meanOverlap", "mean"}, {"largestOverlap", "largest"}}),
      panels.panel("Work of a frame", "", {{"evaluations", "evaluations"}, {"subSteps", "sub-steps"}}),
  };
  std::vector<std::pair<std::string, std::string>> stages;
  for (int i = 0; i < granular::kStageCount; ++i) {
    const std::string name = granular::stageName(static_cast<granular::Stage>(i));
    stages.emplace_back(name + "Seconds", name);
  }
  figure.panels.push_back(panels.panel("Wall time of a frame", "s", stages));
  for (const std::string& column : meterColumns)
    figure.panels.push_back(panels.panel(column, "", {{column, ""}}));
  writeFigure(figure, file);
}

}  // namespace granular_demo
