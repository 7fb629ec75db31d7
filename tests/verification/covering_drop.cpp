// SPDX-License-Identifier: MIT
#include "tests/verification/covering_drop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "granular/geometry/cover.h"
#include "granular/geometry/mesh_primitives.h"
#include "tests/verification/impact.h"

namespace granular::verification {
namespace {

const MaterialDef kStone{.name = "stone", .youngsModulus = 1e7, .poissonRatio = 0.3};

/// kStiffness, no friction.
MaterialPairDef givenPair(double restitution) {
  return {.restitution = restitution,
          .friction = 0.0,
          .bodyNormal = {.law = NormalLaw::ElasticFoundation, .stiffness = kStiffness}};
}

/// Height of the cube's centre when its lowest point touches the plane, m.
double touchingHeight(CubePose pose) {
  const double parts = pose == CubePose::Flat ? 1.0 : pose == CubePose::Edge ? 2.0 : 3.0;
  return 0.5 * kCubeSide * std::sqrt(parts);
}

class CubeOnPlane {
 public:
  CubeOnPlane(const Covering& covering, const MaterialPairDef& pair, const RigidMotion& motion,
              const Vector3& gravity, const IntegratorDef& integrator)
      : system_({.gravity = gravity, .integrator = integrator}) {
    const MaterialId cube = system_.addMaterial(kStone), floor = system_.addMaterial(kStone);
    system_.setMaterialPair(cube, floor, pair);
    addPlane(system_, floor);
    body_ = system_.addBody({.motion = BodyMotion::Dynamic,
                             .covering = covering,
                             .material = cube,
                             .mass = kCubeMass,
                             .principalInertia = Vector3::Constant(kCubeMass * kCubeSide * kCubeSide / 6.0),
                             .pose = motion.pose,
                             .velocity = motion.velocity});
  }
  GranularSystem& system() { return system_; }
  RigidMotion motion() const { return system_.bodyMotion(body_); }
  Wrench contact() { return system_.contactWrench(body_); }
  void setMotion(const RigidMotion& motion) { system_.setBodyMotion(body_, motion); }
  void setLoad(const Vector3& force) { system_.setBodyLoad(body_, {.force = force}); }

 private:
  GranularSystem system_;
  BodyId body_;
};

/// For the particle that comes next, at `center`, its cell of the face across an axis; sign: which of the
/// two.
void addCell(Covering& covering, const Vector3& center, double cell, int axis, double sign) {
  const double half = 0.5 * cell;
  const Vector3 middle = center + sign * half * Vector3::Unit(axis);
  const Vector3 u = half * Vector3::Unit((axis + 1) % 3), v = sign * half * Vector3::Unit((axis + 2) % 3);
  const auto particle = static_cast<std::int32_t>(covering.positions.size());
  covering.pieces.push_back({particle, {middle - u - v, middle + u - v, middle + u + v}});
  covering.pieces.push_back({particle, {middle - u - v, middle + u + v, middle - u + v}});
}

Pose placed(CubePose pose, double depth) {
  return {.position = {0.0, touchingHeight(pose) - depth, 0.0}, .orientation = orientationOf(pose)};
}

}  // namespace

const char* nameOf(CubePose pose) {
  return pose == CubePose::Flat ? "flat" : pose == CubePose::Edge ? "edge" : "corner";
}

Quaternion orientationOf(CubePose pose) {
  const double z = pose == CubePose::Corner ? -1.0 : 0.0, x = pose == CubePose::Flat ? 0.0 : -1.0;
  return Quaternion::FromTwoVectors(Vector3(x, -1.0, z).normalized(), -Vector3::UnitY());
}

Covering cubeCovering(int n) {
  Covering covering;
  const double cell = kCubeSide / n;
  const auto place = [&](int i) { return (i + 0.5) * cell - 0.5 * kCubeSide; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      for (int k = 0; k < n; ++k) {
        const std::array<int, 3> index{i, j, k};
        if (std::ranges::all_of(index, [n](int at) { return at > 0 && at < n - 1; })) continue;
        const Vector3 center(place(i), place(j), place(k));
        for (int axis = 0; axis < 3; ++axis) {
          for (const auto& [at, sign] : {std::pair{0, -1.0}, std::pair{n - 1, 1.0}}) {
            if (index[axis] == at) addCell(covering, center, cell, axis, sign);
          }
        }
        covering.positions.push_back(center);
        covering.radii.push_back(0.5 * cell);
      }
    }
  }
  return covering;
}

Covering footCovering(int n) {
  Covering covering;
  const double cell = kCubeSide / n;
  const auto place = [&](int i) { return (i + 0.5) * cell - 0.5 * kCubeSide; };
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const Vector3 center(place(i), 0.5 * (cell - kCubeSide), place(k));
      addCell(covering, center, cell, 1, -1.0);
      covering.positions.push_back(center);
      covering.radii.push_back(0.5 * cell);
    }
  }
  return covering;
}

CubeBounce dropCube(const CubeDrop& drop) {
  const double gap = 0.01 * kCubeSide;
  CubeOnPlane cube(drop.covering, drop.pair,
                   {.pose = placed(drop.pose, -gap), .velocity = {0.0, -drop.speed, 0.0}}, Vector3::Zero(),
                   drop.integrator);
  CubeBounce bounce;
  const double dt = 1e-4;
  for (int n = 0; n < 100000; ++n) {
    const StepReport report = cube.system().step(dt);
    const RigidMotion now = cube.motion();
    bounce.overlap = std::max(bounce.overlap, touchingHeight(drop.pose) - now.pose.position.y());
    if (report.contacts > 0 || now.velocity.y() <= 0.0) continue;
    bounce.restitution = now.velocity.y() / drop.speed;
    return bounce;
  }
  throw std::runtime_error("dropCube: the cube does not leave the plane");
}

double cubeStiffness(const Covering& covering, CubePose pose, double depth) {
  CubeOnPlane cube(covering, givenPair(1.0), {.pose = placed(pose, depth)}, Vector3::Zero(), {});
  return cube.contact().force.y() / depth;
}

double exactStiffness(CubePose pose, double depth) {
  // kStiffness times the volume below the plane, over the depth: of a box, a prism and a pyramid.
  switch (pose) {
    case CubePose::Flat:
      return kStiffness * kCubeSide * kCubeSide;
    case CubePose::Edge:
      return kStiffness * kCubeSide * depth;
    case CubePose::Corner:
      return 0.5 * std::numbers::sqrt3 * kStiffness * depth * depth;
  }
  return 0.0;
}

double exactDropSpeed(CubePose pose, double depth) {
  const double power = pose == CubePose::Flat   ? 2.0
                       : pose == CubePose::Edge ? 3.0
                                                : 4.0;  // of the energy in depth
  return std::sqrt(2.0 * exactStiffness(pose, depth) * depth * depth / (power * kCubeMass));
}

CubeBounce dropCubeTo(const Covering& covering, CubePose pose, double depth) {
  const double speed = exactDropSpeed(pose, depth);
  return dropCube({.covering = covering, .pose = pose, .speed = speed, .pair = givenPair(1.0)});
}

CubeFriction slideCube(const Covering& covering, double friction) {
  const double g = 9.81;
  MaterialPairDef pair{.restitution = 0.2, .restitutionSpeed = 0.02, .friction = friction};
  pair.bodyNormal.stiffness = kStiffness;
  pair.shear = {.law = ShearLaw::StaticFriction, .dampingRatio = 0.5};
  CubeOnPlane cube(covering, pair, {.pose = placed(CubePose::Flat, 0.0)}, {0.0, -g, 0.0},
                   {.tolerance = 1e-6});
  cube.system().step(0.5);
  CubeFriction result;
  const auto foot = [&cube] { return cube.motion().pose.toWorld({0.0, -0.5 * kCubeSide, 0.0}).x(); };
  const double load = 0.3 * friction * kCubeMass * g, before = foot();
  cube.setLoad({load, 0.0, 0.0});
  cube.system().step(0.5);
  result.shearStiffness = load / (foot() - before);
  cube.setLoad(Vector3::Zero());
  RigidMotion pushed = cube.motion();
  pushed.velocity.x() = 1.0;
  cube.setMotion(pushed);
  cube.system().step(0.02);
  const double fast = cube.motion().velocity.x();
  cube.system().step(0.1);
  result.coefficient = (fast - cube.motion().velocity.x()) / (0.1 * g);
  return result;
}

double exactShearStiffness() {
  const double nu = kStone.poissonRatio;
  return 2.0 * (1.0 - nu) / (2.0 - nu) * kStiffness * kCubeSide * kCubeSide;
}

TiltedCube tiltCube(const Covering& covering, double depth, double angle) {
  const Quaternion turn(Eigen::AngleAxisd(angle, Vector3::UnitZ()));
  const Vector3 foot = turn * Vector3(0.0, -0.5 * kCubeSide, 0.0);
  CubeOnPlane cube(covering, givenPair(1.0), {.pose = {{0.0, -depth - foot.y(), 0.0}, turn}}, Vector3::Zero(),
                   {});
  return {cube.contact().force.y(), cube.contact().torque.z()};
}

TiltedCube tiltedSolid(double depth, double angle) {
  const Eigen::Rotation2Dd turn(angle);
  const double height = -depth + 0.5 * kCubeSide * std::cos(angle);  // of the cube's centre
  double area = 0.0,
         moment = 0.0;  // below the plane and over it; of the distance to the cube's centre along x
  const std::array<Eigen::Vector2d, 4> square{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  for (int k = 0; k < 4; ++k) {
    Eigen::Vector2d from = 0.5 * kCubeSide * (turn * square[k]),
                    to = 0.5 * kCubeSide * (turn * square[(k + 1) % 4]);
    if (to.x() <= from.x()) continue;  // the upper side
    double depth1 = -from.y() - height, depth2 = -to.y() - height;
    if (depth1 <= 0.0 && depth2 <= 0.0) continue;
    const Eigen::Vector2d cut = from + depth1 / (depth1 - depth2) * (to - from);
    if (depth1 < 0.0) from = cut, depth1 = 0.0;
    if (depth2 < 0.0) to = cut, depth2 = 0.0;
    const double width = to.x() - from.x();
    area += 0.5 * width * (depth1 + depth2);
    moment += width / 6.0 * (from.x() * (2.0 * depth1 + depth2) + to.x() * (depth1 + 2.0 * depth2));
  }
  return {kStiffness * kCubeSide * area, kStiffness * kCubeSide * moment};
}

std::vector<CoveringSeries> coveringSeries(const std::vector<double>& radii) {
  std::vector<CoveringSeries> all;
  for (const CubePose pose : {CubePose::Flat, CubePose::Edge, CubePose::Corner}) {
    CoveringSeries series{.pose = pose};
    const double depth = depthOf(pose);
    for (const double radius : radii) {
      const Covering covering = coverMesh(makeBox(Vector3::Constant(kCubeSide)), {.particleRadius = radius});
      series.particles.push_back(static_cast<double>(covering.positions.size()));
      series.restitution.push_back(dropCube({.covering = covering, .pose = pose, .speed = 0.5}).restitution);
      series.overlap.push_back(dropCubeTo(covering, pose, depth).overlap / depth);
      series.stiffness.push_back(cubeStiffness(covering, pose, depth) / exactStiffness(pose, depth));
      if (pose != CubePose::Flat) continue;
      const CubeFriction friction = slideCube(covering, 0.4);
      series.friction.push_back(friction.coefficient / 0.4);
      series.shearStiffness.push_back(friction.shearStiffness / exactShearStiffness());
    }
    all.push_back(series);
  }
  return all;
}

}  // namespace granular::verification
