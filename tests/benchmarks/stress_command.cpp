// SPDX-License-Identifier: MIT
// The stress matrix: what a system does at its limits, a row a scene (tests/stress_cases.h).
#include <CLI/CLI.hpp>
#include <chrono>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "demos/runner/csv_file.h"
#include "tests/benchmarks/commands.h"
#include "tests/stress_cases.h"

namespace granular_bench {
namespace {

namespace stress = granular::stress;

struct Options {
  std::string only, csv;
  bool list = false;
};

void printHead() {
  std::cout << std::left << std::setw(44) << "scene" << std::right << std::setw(12) << "measured"
            << std::setw(11) << "lowest" << std::setw(11) << "highest" << std::setw(10) << "overlap"
            << std::setw(11) << "energy" << std::setw(11) << "momentum" << std::setw(11) << "shortest"
            << std::setw(5) << "NaN" << std::setw(8) << "escaped" << std::setw(9) << "wall s"
            << "  verdict\n";
}

/// Runs one scene and prints its row. Whether it is as expected.
bool runCase(const stress::Case& scene, std::optional<granular_demo::CsvFile>& csv) {
  const auto start = std::chrono::steady_clock::now();
  const stress::Outcome o = scene.run();
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const std::vector<std::string> complaints = stress::complaints(scene, o);
  std::cout << std::left << std::setw(44) << scene.name << std::right << std::setprecision(5) << std::setw(12)
            << o.measured << std::setw(11) << scene.lowest << std::setw(11) << scene.highest
            << std::setprecision(3) << std::setw(10) << o.largestOverlap << std::setw(11) << o.energyRatio
            << std::setw(11) << o.momentumDrift << std::setw(11) << o.shortestSubStep << std::setw(5)
            << o.notFinite << std::setw(8) << o.escaped << std::setw(9) << seconds << "  "
            << (complaints.empty() ? "as expected" : "FAILED") << std::endl;
  if (!complaints.empty()) {
    std::cout << "    " << scene.setUp << "; expected: " << scene.expectation << '\n';
    for (const std::string& complaint : complaints) std::cout << "    " << complaint << '\n';
  }
  if (csv) {
    csv->row({o.measured, scene.lowest, scene.highest, o.largestOverlap, o.energyRatio, o.momentumDrift,
              o.shortestSubStep, static_cast<double>(o.notFinite), static_cast<double>(o.escaped), seconds,
              complaints.empty() ? 1.0 : 0.0});
  }
  return complaints.empty();
}

int runAll(const Options& options) {
  std::optional<granular_demo::CsvFile> csv;
  if (!options.csv.empty()) {
    csv.emplace(options.csv, std::vector<std::string>{"measured", "lowest", "highest", "overlap",
                                                      "energy_ratio", "momentum_drift", "shortest_sub_step_s",
                                                      "not_finite", "escaped", "wall_s", "as_expected"});
  }
  if (!options.list) printHead();
  int rows = 0, failed = 0;
  for (const stress::Case& scene : stress::allCases()) {
    if (scene.name.find(options.only) == std::string::npos) continue;
    if (options.list) {
      std::cout << scene.name << ": " << scene.setUp << "; " << scene.expectation << '\n';
      continue;
    }
    ++rows;
    failed += !runCase(scene, csv);
  }
  if (!options.list) std::cout << rows << " scenes, " << failed << " failed\n";
  return failed > 0 ? 1 : 0;
}

}  // namespace

void addStressCommand(CLI::App& app, int& status) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("stress", "Scenes at the limits; status 1 if one is not as expected");
  command->add_option("--only", options->only, "scenes whose name contains this");
  command->add_option("--csv", options->csv, "file to write the rows to, in the order of --list");
  command->add_flag("--list", options->list, "names, set-ups and expectations, without running");
  command->callback([=, &status] { status = runAll(*options); });
}

}  // namespace granular_bench
