// SPDX-License-Identifier: MIT
// Figure 3 of the paper: restitution against impact speed for the four normal laws (Bell 2005, eqs. 6-12), kr
// = 1e6, kd in {0, 50, 100, 250, 500} with the constants as they stand in the law. The paper does not give
// m_eff; 1 kg puts the linear panel at 0.45 to 1. Points: impacts of two grains simulated by GranularSystem;
// thin lines: the equation of one impact integrated on its own.
//
// The force is clamped at no attraction, as dry grains are simulated. Eqs. 6-7 as they are written let the
// damper pull; with alpha = 0, beta = 3/2 the two would then never part (near xi = 0 the damper is stronger
// than the spring).
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "demos/runner/csv_file.h"
#include "demos/render/plot.h"
#include "tests/benchmarks/commands.h"
#include "tests/verification/impact.h"
#include "tests/verification/reference_impact.h"

namespace granular_bench {
namespace {

using granular::NormalLaw;
namespace verification = granular::verification;

struct PanelLaw {
  NormalLaw law;
  double alpha, beta;
  const char* title;
};
constexpr std::array<PanelLaw, 4> kPanels{
    {{NormalLaw::LinearSpring, 0.0, 1.0, "\u03b1 = 0, \u03b2 = 1: damped linear spring"},
     {NormalLaw::HertzConstantDamping, 0.0, 1.5, "\u03b1 = 0, \u03b2 = 3/2: Hertz, constant damping"},
     {NormalLaw::HertzTsuji, 0.25, 1.5, "\u03b1 = 1/4, \u03b2 = 3/2: Hertz, Tsuji damping"},
     {NormalLaw::HertzViscoelastic, 0.5, 1.5, "\u03b1 = 1/2, \u03b2 = 3/2: Hertz, viscoelastic"}}};
constexpr double kStiffness = 1e6;                                          // kr, N/m^beta
constexpr std::array<double, 5> kDampings{0.0, 50.0, 100.0, 250.0, 500.0};  // kd, N s/m^(1 + alpha)
constexpr double kSlowest = 0.01, kFastest = 100.0;                         // m/s
constexpr int kPoints = 13, kLinePoints = 61;

double speedAt(int i, int count) {
  return kSlowest * std::pow(kFastest / kSlowest, i / (count - 1.0));
}

/// About as long as the contact lasts, s; m_eff = 1 kg.
double contactTime(const PanelLaw& law, double speed) {
  if (law.beta == 1.0) return std::numbers::pi / std::sqrt(kStiffness);
  return 3.218065 * std::pow(kStiffness, -0.4) * std::pow(speed, -0.2);
}

double simulated(const PanelLaw& law, double damping, double speed) {
  // Two equal grains of 2 kg, large enough for the deepest overlap.
  const double radius = 1.0, density = 2.0 / (4.0 / 3.0 * std::numbers::pi);
  const verification::Ball ball{.radius = radius, .density = density};
  const verification::ImpactDef def{
      .ball = ball,
      .partner = verification::Partner::Ball,
      .other = ball,
      .pair = {.normal = {.law = law.law, .stiffness = kStiffness, .damping = damping}},
      .velocity = {0.0, -speed, 0.0},
      .gap = 1e-3,
      .integrator = {.tolerance = 1e-8, .contactTimeFraction = 0.02},
      .step = contactTime(law, speed)};
  return verification::simulateImpact(def).restitution;
}

double integrated(const PanelLaw& law, double damping, double speed) {
  return verification::referenceImpact(verification::powerLaw(law.alpha, law.beta, kStiffness, damping), 1.0,
                                       speed, contactTime(law, speed))
      .restitution;
}

std::string dampingName(double damping) {
  return "k_{d} = " + std::to_string(static_cast<int>(damping));
}

granular_demo::Panel drawPanel(const PanelLaw& law, granular_demo::CsvFile& csv) {
  using granular_demo::Color;
  static const std::array<Color, 5> colors{{{0.10f, 0.10f, 0.10f},
                                            {0.00f, 0.45f, 0.70f},
                                            {0.00f, 0.62f, 0.45f},
                                            {0.90f, 0.60f, 0.00f},
                                            {0.80f, 0.20f, 0.20f}}};
  granular_demo::Panel panel{.title = law.title,
                             .x = {.label = "impact speed, m/s", .scale = granular_demo::Scale::logarithmic},
                             .y = {.label = "restitution e_{n}", .low = 0.0, .high = 1.05}};
  for (std::size_t k = 0; k < kDampings.size(); ++k) {
    granular_demo::Series line{.line = granular_demo::Line::solid, .color = colors[k], .width = 1.0};
    granular_demo::Series points{.name = law.beta == 1.0 ? dampingName(kDampings[k]) : "",
                                 .line = granular_demo::Line::none,
                                 .marker = granular_demo::Marker::circle,
                                 .color = colors[k]};
    for (int i = 0; i < kLinePoints; ++i) {
      line.x.push_back(speedAt(i, kLinePoints));
      line.y.push_back(integrated(law, kDampings[k], line.x.back()));
    }
    for (int i = 0; i < kPoints; ++i) {
      const double v = speedAt(i, kPoints), e = simulated(law, kDampings[k], v);
      points.x.push_back(v);
      points.y.push_back(e);
      csv.row({law.alpha, law.beta, kStiffness, kDampings[k], v, e, integrated(law, kDampings[k], v)});
    }
    panel.series.push_back(line);
    panel.series.push_back(points);
  }
  return panel;
}

void drawFigure(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  granular_demo::CsvFile csv(folder / "restitution.csv", {"alpha", "beta", "kr", "kd", "impact_speed_m_s",
                                                          "restitution_simulated", "restitution_integrated"});
  granular_demo::Figure figure{
      .title = "Restitution against impact speed, k_{r} = 10^{6}: points simulated, lines integrated apart",
      .columns = 2};
  for (const PanelLaw& law : kPanels) figure.panels.push_back(drawPanel(law, csv));
  granular_demo::writeFigure(figure, folder / "restitution.png");
  std::cout << "wrote " << (folder / "restitution.png").string() << " and .csv\n";
}

}  // namespace

void addRestitutionCommand(CLI::App& app, int& status) {
  CLI::App* command =
      app.add_subcommand("restitution", "Figure 3 of the paper: restitution against impact speed");
  const auto folder = std::make_shared<std::string>(".");
  command->add_option("--out", *folder, "Folder for restitution.png and restitution.csv")
      ->capture_default_str();
  command->callback([folder, &status] {
    drawFigure(*folder);
    status = 0;
  });
}

}  // namespace granular_bench
