// SPDX-License-Identifier: MIT
// The table of all cases with known answers: case, quantity, expected, measured, error, tolerance.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/verification_figures.h"
#include "tests/verification/verification_case.h"

namespace granular_bench {
namespace {

using granular::verification::Check;
using granular::verification::ErrorKind;
using granular::verification::VerificationCase;

struct Options {
  std::string only, csv, plots;
  bool withLong = false, list = false;
};

/// Rows on the screen and, if wanted, in a CSV file; counts what passed.
class Table {
 public:
  explicit Table(const std::string& csv) {
    std::printf("%-52s %-52s %13s %13s %9s %9s\n", "case", "quantity", "expected", "measured", "error",
                "tolerance");
    if (csv.empty()) return;
    csv_.open(csv);
    if (!csv_) throw std::runtime_error(csv + ": cannot be written");
    csv_.precision(17);
    csv_ << "case,quantity,expected,measured,error,tolerance,kind,passes\n";
  }
  void row(const std::string& name, const Check& check) {
    const bool isRelative = check.kind == ErrorKind::Relative;
    std::printf("%-52s %-52s %13.6g %13.6g %8.1e%s %8.1e%s %s\n", name.c_str(), check.quantity.c_str(),
                check.expected, check.measured, check.error(), isRelative ? "r" : " ", check.tolerance,
                isRelative ? "r" : " ", check.passes() ? "" : "FAILED");
    (check.passes() ? passed_ : failed_)++;
    if (!csv_.is_open()) return;
    csv_ << '"' << name << "\",\"" << check.quantity << "\"," << check.expected << ',' << check.measured
         << ',' << check.error() << ',' << check.tolerance << ',' << (isRelative ? "relative" : "absolute")
         << ',' << check.passes() << '\n';
  }
  void broken(const std::string& name, const std::string& reason) {
    std::printf("%-52s %s FAILED\n", name.c_str(), reason.c_str());
    ++failed_;
  }
  int passed() const { return passed_; }
  int failed() const { return failed_; }

 private:
  std::ofstream csv_;
  int passed_ = 0, failed_ = 0;
};

bool isWanted(const VerificationCase& c, const Options& options) {
  if (!options.only.empty()) return c.name.find(options.only) != std::string::npos;
  return !c.isLong || options.withLong;
}

void runCase(const VerificationCase& c, Table& table) {
  try {
    for (const Check& check : c.run()) table.row(c.name, check);
  } catch (const std::exception& error) {
    table.broken(c.name, error.what());
  }
  std::fflush(stdout);
}

int verify(const Options& options) {
  if (options.list) {
    for (const VerificationCase& c : granular::verification::verificationCases())
      std::printf("%s\n", c.name.c_str());
    return 0;
  }
  Table table(options.csv);
  for (const VerificationCase& c : granular::verification::verificationCases()) {
    if (isWanted(c, options)) runCase(c, table);
  }
  if (!options.plots.empty()) writeVerificationFigures(options.plots);
  std::printf("errors and tolerances marked r are relative\n%d passed, %d failed\n", table.passed(),
              table.failed());
  return table.failed() > 0 || table.passed() == 0 ? 1 : 0;
}

}  // namespace

void addVerifyCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand(
      "verify", "Cases with known answers: expected, measured, error, tolerance. Status 1 if one fails");
  const auto options = std::make_shared<Options>();
  command->add_option("--only", options->only, "Only the cases whose name contains this text, long ones too");
  command->add_flag("--long", options->withLong, "Also the cases that take more than some seconds");
  command->add_flag("--list", options->list, "Print the names of the cases and run none");
  command->add_option("--csv", options->csv, "Write the table to this file too");
  command->add_option("--plots", options->plots, "Draw the figures into this folder");
  command->callback([options, &status] { status = verify(*options); });
}

}  // namespace granular_bench
