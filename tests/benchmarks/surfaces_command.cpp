// SPDX-License-Identifier: MIT
// `granular_bench surfaces`: what grains meet, three ways: particles on the surface (the paper's way), the
// box by formula, and the signed distance of its mesh. Tetrahedra drain from a box with a hole in its floor
// and heap up on a plate below; floor, walls and plate are boxes of the one kind or the other.
#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "demos/csv_file.h"
#include "granular/geometry/cover.h"
#include "granular/geometry/mesh_primitives.h"
#include "granular/granular.h"
#include "granular/system/fill.h"
#include "tests/benchmarks/commands.h"

namespace granular_bench {
namespace {

using granular::Vector3;

constexpr double kRadius = 0.01;      // m, of grain particles and of coverings
constexpr double kInside = 0.4;       // m, width of the box
constexpr double kHole = 0.2;         // m, width of the hole
constexpr double kWall = 0.05;        // m, thickness of floor and walls
constexpr double kFloorHeight = 0.3;  // m, over the plate
constexpr double kPlate = 1.6;        // m, width of the plate
constexpr double kSettle = 0.4;       // s, before the hole is opened
constexpr double kDrain = 3.0;        // s, after it
constexpr double kTick = 0.01;        // s

enum class Kind { Particles, Box, Distance };
constexpr std::array<const char*, 3> kKindNames{"particles", "exact box", "mesh distance"};

struct Result {
  Kind kind = Kind::Particles;
  double surfaceParticles = 0.0, evaluations = 0.0, candidates = 0.0,
         contacts = 0.0;      // the last two at the end
  double microseconds = 0.0;  // an evaluation
  double drainRate = 0.0;     // kg/s between a quarter and three quarters drained
  double left = 0.0;          // grains that stay on the floor
  double angle = 0.0;         // of the heap, degrees
};

class Hopper {
 public:
  Hopper(Kind kind, int grains) : kind_(kind), system_({.integrator = {.tolerance = 1e-3}}) {
    stone_ =
        system_.addMaterial({.name = "stone", .youngsModulus = 3e6, .restitution = 0.5, .friction = 0.5});
    addBox({0, -kWall / 2, 0}, {kPlate, kWall, kPlate});
    const double side = (kInside - kHole) / 2, beside = (kInside + kHole) / 4, height = 0.4;
    for (const double sign : {-1.0, 1.0}) {  // of the floor, a frame round the hole; then walls
      addBox({sign * beside, kFloorHeight, 0}, {side, kWall, kInside});
      addBox({0, kFloorHeight, sign * beside}, {kHole, kWall, side});
      const double wall = (kInside + kWall) / 2, middle = kFloorHeight + height / 2 - kWall / 2;
      addBox({sign * wall, middle, 0}, {kWall, height, kInside + 2 * kWall});
      addBox({0, middle, sign * wall}, {kInside, height, kWall});
    }
    lid_ = addBox({0, kFloorHeight, 0}, {kHole, kWall, kHole});
    fill(grains);
  }

  Result run() {
    Result result{.kind = kind_, .surfaceParticles = surfaceParticles_};
    for (double t = 0.0; t < kSettle; t += kTick) step(result);
    system_.removeBody(lid_);
    const double count = system_.grainCount(), mass = system_.massOf(system_.grainAt(0));
    double quarter = 0.0, threeQuarters = 0.0;
    granular::StepReport last;
    for (double t = kTick; t < kDrain; t += kTick) {
      last = step(result);
      const double out = below();
      if (out <= 0.25 * count) quarter = t;
      if (out <= 0.75 * count) threeQuarters = t;
    }
    result.drainRate = 0.5 * count * mass / (threeQuarters - quarter);
    result.left = count - below();
    result.angle = heapAngle();
    result.candidates = static_cast<double>(last.candidates);
    result.contacts = static_cast<double>(last.contacts);
    result.microseconds = 1e6 * seconds_ / result.evaluations;
    return result;
  }

 private:
  granular::BodyId addBox(const Vector3& center, const Vector3& size) {
    granular::BodyDef def{.material = stone_, .pose = {.position = center}};
    const granular::TriangleMesh mesh = granular::makeBox(size);
    switch (kind_) {
      case Kind::Particles:
        def.covering = granular::coverMesh(mesh, {.particleRadius = kRadius});
        surfaceParticles_ += static_cast<double>(def.covering.positions.size());
        break;
      case Kind::Box:
        def.exact = granular::ExactBox{0.5 * size};
        break;
      case Kind::Distance:
        def.exact = granular::ExactMesh{std::make_shared<granular::MeshField>(
            mesh, granular::MeshFieldDef{.spacing = 0.5 * kRadius, .reach = 2.0 * kRadius})};
        break;
    }
    return system_.addBody(def);
  }

  void fill(int grains) {
    const granular::GrainShapeDef shape = granular::tetrahedronShape(kRadius);
    const granular::GrainShapeId id = system_.addGrainShape(shape);
    const double w = kInside / 2, floor = kFloorHeight + kWall / 2;
    const granular::FillRegion region = granular::boxRegion({{-w, floor, -w}, {w, floor + 0.6, w}});
    for (const granular::PlacedGrain& grain : granular::fillRegion(region, shape, {.count = grains})) {
      system_.addGrain({.shape = id, .material = stone_, .pose = grain.pose});
    }
  }

  granular::StepReport step(Result& result) {
    const auto start = std::chrono::steady_clock::now();
    const granular::StepReport report = system_.step(kTick);
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    result.evaluations += static_cast<double>(report.evaluations);
    return report;
  }

  double below() const {
    double count = 0.0;
    for (const granular::RigidMotion& m : system_.grainMotions()) {
      count += m.pose.position.y() < kFloorHeight - kWall / 2;
    }
    return count;
  }

  /// Of a cone the mean height is a quarter of its own, the mean distance from the axis half its foot's
  /// radius.
  double heapAngle() const {
    double count = 0.0, height = 0.0, distance = 0.0;
    for (const granular::RigidMotion& m : system_.grainMotions()) {
      const Vector3& p = m.pose.position;
      if (p.y() > kFloorHeight - kWall / 2 || p.y() < 0.0) continue;
      count += 1.0;
      height += p.y();
      distance += std::hypot(p.x(), p.z());
    }
    // Grains have a size: the lowest layer's middles are not at the ground.
    return std::atan(2.0 * (height / count - kRadius) / (distance / count)) * 180.0 / std::numbers::pi;
  }

  Kind kind_;
  granular::GranularSystem system_;
  granular::MaterialId stone_;
  granular::BodyId lid_;
  double surfaceParticles_ = 0.0, seconds_ = 0.0;
};

void printTable(const std::vector<Result>& results) {
  std::cout << std::left << std::setw(15) << "grains meet" << std::right << std::setw(11) << "particles"
            << std::setw(13) << "evaluations" << std::setw(12) << "candidates" << std::setw(10) << "contacts"
            << std::setw(8) << "us/ev" << std::setw(12) << "drain kg/s" << std::setw(6) << "left"
            << std::setw(9) << "heap deg" << '\n';
  for (const Result& r : results) {
    std::cout << std::left << std::setw(15) << kKindNames[static_cast<int>(r.kind)] << std::right
              << std::fixed << std::setprecision(0) << std::setw(11) << r.surfaceParticles << std::setw(13)
              << r.evaluations << std::setw(12) << r.candidates << std::setw(10) << r.contacts << std::setw(8)
              << r.microseconds << std::setprecision(2) << std::setw(12) << r.drainRate
              << std::setprecision(0) << std::setw(6) << r.left << std::setprecision(1) << std::setw(9)
              << r.angle << '\n';
  }
}

}  // namespace

void addSurfacesCommand(CLI::App& app, int& status) {
  struct Options {
    int grains = 300;
    std::string csv;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "surfaces", "Grains on covered boxes, on exact boxes and on the distance field of boxes, side by side");
  command->add_option("--grains", options->grains, "tetrahedra, at most about 700")
      ->check(CLI::Range(50, 700));
  command->add_option("--csv", options->csv, "the table as a file too");
  command->callback([options, &status] {
    std::vector<Result> results;
    for (const Kind kind : {Kind::Particles, Kind::Box, Kind::Distance}) {
      results.push_back(Hopper(kind, options->grains).run());
    }
    printTable(results);
    if (!options->csv.empty()) {
      granular_demo::CsvFile csv(options->csv,
                                 {"kind", "surface_particles", "evaluations", "candidates", "contacts",
                                  "us_per_evaluation", "drain_kg_s", "grains_left", "heap_degrees"});
      for (const Result& r : results) {
        csv.row({static_cast<double>(r.kind), r.surfaceParticles, r.evaluations, r.candidates, r.contacts,
                 r.microseconds, r.drainRate, r.left, r.angle});
      }
    }
    status = 0;
  });
}

}  // namespace granular_bench
