// SPDX-License-Identifier: MIT
// What a covering costs: cases from a camel to a million particles, each covered on one thread. A covering is
// checked (holes closed, particles on the offset surface) before its time is printed.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "granular/geometry/cover.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_file.h"
#include "granular/geometry/mesh_primitives.h"
#include "tests/benchmarks/commands.h"

namespace granular_bench {
namespace {

using granular::CoverDef;
using granular::Covering;
using granular::CoverReport;
using granular::TriangleMesh;

struct CoverCase {
  std::string name;
  std::function<TriangleMesh()> mesh;
  double particleRadius;  // m
};

struct CoverOptions {
  std::string only;
  bool isLong = false;
  int threads = 1;
};

TriangleMesh ownMesh(const char* name) {
  return granular::readMeshFile(std::filesystem::path(GRANULAR_MESH_DIR) / name);
}

std::vector<CoverCase> coverCases(bool isLong) {
  const auto ball = [] { return granular::makeIcosphere(1.0, 5); };
  std::vector<CoverCase> cases = {
      {"camel, from its file", [] { return ownMesh("camel.obj"); }, 0.0222},
      {"ring, from its file", [] { return ownMesh("ring.obj"); }, 0.115},
      {"hourglass, from its file", [] { return ownMesh("hourglass.obj"); }, 0.005},
      {"slab 3.2 x 0.1 x 2.4 m",
       [] {
         return granular::makeBox({3.2, 0.1, 2.4});
       },
       0.015},
      {"torus of 102,400 triangles", [] { return granular::makeTorus(1.0, 0.3, 320, 160); }, 0.03},
      {"torus of 102,400, finer", [] { return granular::makeTorus(1.0, 0.3, 320, 160); }, 0.01},
      {"ball, 1e3", ball, 0.052},
      {"ball, 1e4", ball, 0.018},
      {"ball, 1e5", ball, 0.00578},
  };
  if (isLong) cases.push_back({"ball, 1e6", ball, 0.00183});
  return cases;
}

/// Empty, or what is wrong with a covering.
std::string faultOf(const TriangleMesh& mesh, const CoverDef& def, const Covering& covering,
                    const CoverReport& report) {
  if (!report.holesClosed) return "a hole is larger than the bound";
  const granular::MeshDistance distance(mesh);
  std::int64_t off = 0;
  for (const granular::Vector3& p : covering.positions) {
    off += std::abs(distance.nearest(p).signedDistance + def.particleRadius) > 1e-6 * def.particleRadius;
  }
  return off <= report.thinParticles ? "" : std::to_string(off) + " particles are not on the offset surface";
}

/// Returns whether the covering was right.
bool runCase(const CoverCase& one, int threads) {
  const auto start = std::chrono::steady_clock::now();
  const std::clock_t cpuStart = std::clock();
  const TriangleMesh mesh = one.mesh();
  const CoverDef def{.particleRadius = one.particleRadius, .threads = threads};
  CoverReport report;
  const Covering covering = granular::coverMesh(mesh, def, &report);
  const double cpu = static_cast<double>(std::clock() - cpuStart) / CLOCKS_PER_SEC;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  const std::string fault = faultOf(mesh, def, covering, report);
  if (!fault.empty()) {
    std::printf("%-28s WRONG: %s\n%s\n", one.name.c_str(), fault.c_str(), report.text().c_str());
    return false;
  }
  const auto count = static_cast<double>(covering.positions.size());
  std::printf("%-28s %9zu %9.0f %6d %8.3f %8.3f %8.2f %7.2f %6.3f %s\n", one.name.c_str(),
              mesh.triangles.size(), count, report.iterations, wall.count(), cpu, 1e6 * cpu / count,
              report.largestHole / report.holeBound, report.envelopeMean / def.particleRadius,
              report.converged ? "" : "floaters not converged");
  std::fflush(stdout);
  return true;
}

int runCover(const CoverOptions& options) {
  std::printf("%-28s %9s %9s %6s %8s %8s %8s %7s %6s\n", "case", "triangles", "particles", "iter.", "wall s",
              "cpu s", "us each", "hole/b.", "env./r");
  bool allRight = true;
  for (const CoverCase& one : coverCases(options.isLong)) {
    if (one.name.find(options.only) != std::string::npos)
      allRight = runCase(one, options.threads) && allRight;
  }
  return allRight ? 0 : 1;
}

}  // namespace

void addCoverCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand("cover", "What a covering costs; status 1 if one is wrong");
  const auto options = std::make_shared<CoverOptions>();
  command->add_option("--only", options->only, "Cases whose name holds this text");
  command->add_flag("--long", options->isLong, "Up to a million particles");
  command->add_option("--threads", options->threads, "The result is the same for any number")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->callback([options, &status] { status = runCover(*options); });
}

}  // namespace granular_bench
