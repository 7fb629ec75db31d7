// SPDX-License-Identifier: MIT
// granular_bench: what the module computes, against what is known. One subcommand a file.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "tests/benchmarks/commands.h"

int main(int argc, char** argv) {
  CLI::App app{"Tables and figures of accuracy and speed of the granular module"};
  app.require_subcommand(1);
  int status = 0;
  granular_bench::addKernelCommand(app, status);
  granular_bench::addPeersCommand(app, status);
  granular_bench::addCoverCommand(app, status);
  granular_bench::addPaperTableCommand(app, status);
  granular_bench::addPlainWorldCommand(app, status);
  granular_bench::addRestitutionCommand(app, status);
  granular_bench::addScalingCommand(app, status);
  granular_bench::addSearchCommand(app, status);
  granular_bench::addSkipCommand(app, status);
  granular_bench::addStackingCommand(app, status);
  granular_bench::addSleepCommand(app, status);
  granular_bench::addStressCommand(app, status);
  granular_bench::addSurfacesCommand(app, status);
  granular_bench::addVerifyCommand(app, status);
  granular_bench::addWorkPrecisionCommand(app, status);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error);
  } catch (const std::exception& error) {
    std::cerr << "granular_bench: " << error.what() << '\n';
    return 2;
  }
  return status;
}
