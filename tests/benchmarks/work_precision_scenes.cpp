// SPDX-License-Identifier: MIT
#include "tests/benchmarks/work_precision_scenes.h"

#include <cmath>

#include "granular/base/random.h"

namespace granular_bench {
namespace {

using namespace granular;

constexpr double kRadius = 2.5e-3;  // of particles, m
constexpr double kHorizon = 4e-3;   // s; some eight contact times
constexpr double kShear = 25.0;     // 1/s, of the flow
constexpr double kFall = 0.5;       // m/s, towards the floor, so that it is dense
const Vector3 kAside(0.0, -1e3, 0.0);

/// Where walls and floor are bodies, by their order.
enum Wall { kFloor, kLeft, kRight, kBack, kFront, kWalls };

void addWall(GranularSystem& system, MaterialId material, const Vector3& point, const Vector3& inward) {
  system.addBody(
      {.exact = HalfSpace{},
       .material = material,
       .pose = {.position = point, .orientation = Quaternion::FromTwoVectors(Vector3::UnitY(), inward)}});
}

/// Grains of a shape on a lattice in a box of exact planes, jittered, falling on each other at random.
GranularSystem boxOf(const GrainShapeDef& shape, double spacing, int perSide,
                     const IntegratorDef& integrator) {
  GranularSystem system({.integrator = integrator});
  const MaterialId stone = system.addMaterial({.name = "stone",
                                               .density = 2500.0,
                                               .youngsModulus = 1e7,
                                               .poissonRatio = 0.3,
                                               .restitution = 0.5,
                                               .friction = 0.5});
  const double half = 0.5 * spacing * perSide;
  addWall(system, stone, Vector3::Zero(), Vector3::UnitY());
  addWall(system, stone, {-half, 0.0, 0.0}, Vector3::UnitX());
  addWall(system, stone, {half, 0.0, 0.0}, -Vector3::UnitX());
  addWall(system, stone, {0.0, 0.0, -half}, Vector3::UnitZ());
  addWall(system, stone, {0.0, 0.0, half}, -Vector3::UnitZ());
  const GrainShapeId grain = system.addGrainShape(shape);
  Random random(7);
  const auto any = [&](double size) {
    return Vector3(random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size));
  };
  for (int i = 0; i < perSide * perSide * perSide; ++i) {
    const Vector3 site(i % perSide, i / (perSide * perSide), i / perSide % perSide);
    const Vector3 at = spacing * (site + Vector3::Constant(0.5)) - Vector3(half, 0.0, half);
    const Vector3 jitter = any(0.02 * kRadius), velocity = any(0.3);
    system.addGrain({.shape = grain,
                     .material = stone,
                     .pose = {.position = at + jitter, .orientation = random.rotation()},
                     .velocity = velocity});
  }
  return system;
}

void run(GranularSystem& system, double seconds) {
  const int steps = static_cast<int>(std::ceil(seconds / 1e-3));
  for (int i = 0; i < steps; ++i) system.step(seconds / steps);
}

/// A heap whose right wall goes away and which shears off over the floor: fast, dense, every grain colliding.
void breakDam(GranularSystem& system) {
  run(system, 0.1);
  const std::int32_t wall = kRight;
  system.setBodyMotion({wall, 0}, {.pose = {.position = kAside + Vector3(1e3, 0.0, 0.0)}});
  run(system, 0.05);
  const auto grains = system.grainMotions();
  for (std::int32_t g = 0; g < system.grainCount(); ++g) {
    RigidMotion motion = grains[g];
    motion.velocity += Vector3(kShear * motion.pose.position.y(), -kFall, 0.0);
    system.setGrainMotion({g, 0}, motion);
  }
  run(system, 0.003);
}

void addBall(GranularSystem& system, double height) {
  const MaterialId steel = system.addMaterial({.name = "steel", .density = 7800.0, .youngsModulus = 1e8});
  const double r = 4.0 * kRadius, mass = 7800.0 * 4.19 * r * r * r;
  Covering covering;
  const int count = 120;
  for (int i = 0; i < count; ++i) {  // a spiral over the sphere
    const double y = 1.0 - (2.0 * i + 1.0) / count, ring = std::sqrt(1.0 - y * y), turn = 2.399963 * i;
    covering.positions.push_back((r - kRadius) * Vector3(ring * std::cos(turn), y, ring * std::sin(turn)));
    covering.radii.push_back(kRadius);
  }
  system.addBody({.motion = BodyMotion::Dynamic,
                  .covering = covering,
                  .material = steel,
                  .mass = mass,
                  .principalInertia = Vector3::Constant(0.4 * mass * r * r),
                  .pose = {.position = {0.0, height, 0.0}},
                  .velocity = {0.3, -1.0, 0.1}});
}

/// Covered blocks, one tumbling onto the other, on an exact floor.
GranularSystem blocks(const IntegratorDef& integrator) {
  GranularSystem system({.integrator = integrator});
  const MaterialId stone = system.addMaterial({.name = "stone", .restitution = 0.5, .friction = 0.5});
  addWall(system, stone, Vector3::Zero(), Vector3::UnitY());
  Covering covering;
  for (int i = -2; i <= 2; ++i) {
    for (int j = -2; j <= 2; ++j) {
      for (int k = -2; k <= 2; ++k) {
        if (std::max({std::abs(i), std::abs(j), std::abs(k)}) < 2) continue;
        covering.positions.push_back(2.0 * kRadius * Vector3(i, j, k));
        covering.radii.push_back(kRadius);
      }
    }
  }
  const double side = 10.0 * kRadius, mass = 2500.0 * side * side * side;
  for (int i = 0; i < 4; ++i) {
    const Quaternion turn(Eigen::AngleAxisd(0.15 * i, Vector3(0.3, 1.0, 0.2).normalized()));
    system.addBody(
        {.motion = BodyMotion::Dynamic,
         .covering = covering,
         .material = stone,
         .mass = mass,
         .principalInertia = Vector3::Constant(mass * side * side / 6.0),
         .pose = {.position = {0.2 * side * i, side * (0.55 + 1.12 * i), 0.0}, .orientation = turn},
         .velocity = {0.0, -0.3 * i, 0.0}});
  }
  return system;
}

}  // namespace

std::vector<PrecisionScene> precisionScenes(int spheresPerSide) {
  const auto spheres = [=](const IntegratorDef& integrator) {
    return boxOf(sphereShape(kRadius), 2.1 * kRadius, spheresPerSide, integrator);
  };
  const int tetraPerSide = std::max(2, static_cast<int>(std::lround(spheresPerSide / std::cbrt(4.0))));
  const auto tetra = [=](const IntegratorDef& integrator) {
    return boxOf(tetrahedronShape(kRadius), 4.6 * kRadius, tetraPerSide, integrator);
  };
  const auto withBall = [=](const IntegratorDef& integrator) {
    GranularSystem system = spheres(integrator);
    addBall(system, 1.0);
    return system;
  };
  const auto dropBall = [](GranularSystem& system) {
    run(system, 0.1);
    double top = 0.0;
    for (const RigidMotion& m : system.grainMotions()) top = std::max(top, m.pose.position.y());
    system.setBodyMotion(
        {kWalls, 0}, {.pose = {.position = {0.0, top + 5.02 * kRadius, 0.0}}, .velocity = {0.3, -1.0, 0.1}});
    run(system, 0.01);
  };
  const auto rest = [](double seconds) { return [=](GranularSystem& system) { run(system, seconds); }; };
  return {{"spheres-flowing", "spheres behind a dam that has broken", kHorizon, kRadius, spheres, breakDam},
          {"spheres-resting", "spheres at rest in a box", kHorizon, kRadius, spheres, rest(0.4)},
          {"tetra", "tetrahedra behind a dam that has broken", kHorizon, kRadius, tetra, breakDam},
          {"ball", "a covered ball hits spheres at rest", kHorizon, kRadius, withBall, dropBall},
          {"blocks", "covered blocks fall on each other", kHorizon, kRadius, blocks, rest(0.03)}};
}

SceneState readState(const GranularSystem& system) {
  SceneState state;
  const auto grains = system.grainMotions();
  state.grains.assign(grains.begin(), grains.end());
  for (std::int32_t b = 0; b < system.bodyCount(); ++b) state.bodies.push_back(system.bodyMotion({b, 0}));
  return state;
}

void writeState(const SceneState& state, GranularSystem& system) {
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(state.grains.size()); ++g) {
    system.setGrainMotion({g, 0}, state.grains[g]);
  }
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(state.bodies.size()); ++b) {
    system.setBodyMotion({b, 0}, state.bodies[b]);
  }
}

}  // namespace granular_bench
