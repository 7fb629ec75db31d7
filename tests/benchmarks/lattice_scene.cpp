// SPDX-License-Identifier: MIT
#include "tests/benchmarks/lattice_scene.h"

#include <unistd.h>

#include <cmath>
#include <fstream>
#include <string>

#include "granular/base/random.h"

namespace granular_bench {
namespace {

using granular::Vector3;

constexpr double kRadius = 2.5e-3;    // m
constexpr double kSpread = 0.05;      // of the radius
constexpr double kSpacing = 1.98;     // radii
constexpr double kShake = 0.01;       // radii
constexpr std::int64_t kLayers = 20;  // at most: the same pressure at any size

}  // namespace

LatticeScene makeLattice(const LatticeDef& def) {
  LatticeScene scene{granular::GranularSystem({.integrator = def.integrator, .threads = def.threads}), {}};
  granular::GranularSystem& system = scene.system;
  scene.material = system.addMaterial({.name = "grain", .youngsModulus = 1e7, .friction = 0.5});
  system.setMaterialPair(scene.material, scene.material, {.shear = {.law = def.shear}});
  const granular::GrainShapeId shape = system.addGrainShape(granular::sphereShape(kRadius));
  const auto side =
      static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(def.spheres) / kLayers)));
  const std::int64_t layers = (def.spheres + side * side - 1) / (side * side);
  const auto wall = [&](const Vector3& point, const Vector3& inward) {
    system.addBody({.exact = granular::HalfSpace{},
                    .material = scene.material,
                    .pose = {point, granular::Quaternion::FromTwoVectors(Vector3::UnitY(), inward)}});
  };
  // Just where the outermost spheres end, so that pressed ones do not fly apart.
  const double width = kRadius * kSpacing * static_cast<double>(side);
  const double height = kRadius * kSpacing * static_cast<double>(layers);
  const Vector3 low = -0.5 * kSpacing * kRadius * Vector3(1.0, 0.0, 1.0);
  const Vector3 high = low + Vector3(width, height, width);
  for (int axis = 0; axis < 3; ++axis) {
    wall(low, Vector3::Unit(axis));
    wall(high, -Vector3::Unit(axis));
  }
  granular::Random random(3);
  for (std::int64_t i = 0; i < def.spheres; ++i) {
    const auto at = [&](std::int64_t n) {
      return kRadius * (kSpacing * static_cast<double>(n) + kShake * random.uniform(-1.0, 1.0));
    };
    const Vector3 place(at(i % side), 0.5 * kSpacing * kRadius + at(i / (side * side)), at(i / side % side));
    const Vector3 velocity = def.speed * (random.rotation() * Vector3::UnitX());
    system.addGrain({.shape = shape,
                     .material = scene.material,
                     .pose = {.position = place},
                     .velocity = velocity,
                     .scale = random.uniform(1.0 - kSpread, 1.0 + kSpread)});
  }
  return scene;
}

std::int64_t residentBytes() {
  std::int64_t size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

std::int64_t peakBytes() {
  std::ifstream status("/proc/self/status");
  std::string field;
  std::int64_t kilobytes = 0;
  while (status >> field && field != "VmHWM:") continue;
  status >> kilobytes;
  return 1024 * kilobytes;
}

void forgetPeak() {
  std::ofstream("/proc/self/clear_refs") << 5;
}

}  // namespace granular_bench
