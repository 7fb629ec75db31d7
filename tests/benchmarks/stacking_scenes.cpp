// SPDX-License-Identifier: MIT
#include "tests/benchmarks/stacking_scenes.h"

#include <cmath>
#include <numbers>

#include "bullet_bridge/convert.h"

namespace granular_bench {
namespace {

using bullet_bridge::toBullet;
using granular::Quaternion;
using granular::Vector3;

constexpr double kDensity = 1000.0;  // kg/m^3

StackScene sceneOf(const std::string& name, double size = 1.0) {
  StackScene scene{.name = name, .size = size};
  scene.put(scene.box({40.0 * size, 2.0 * size, 40.0 * size}), 0.0, {0.0, -size, 0.0});
  return scene;
}

Quaternion turnAboutZ(double angle) {
  return Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitZ()));
}

std::string number(double value) {
  std::string text = std::to_string(value);
  while (text.back() == '0') text.pop_back();
  if (text.back() == '.') text.pop_back();
  return text;
}

StackScene column(int count, double edge) {
  StackScene scene = sceneOf("column of " + std::to_string(count) + ", " + number(edge) + " m", edge);
  btBoxShape& cube = scene.box(Vector3::Constant(edge));
  for (int i = 0; i < count; ++i) scene.put(cube, kDensity * std::pow(edge, 3), {0.0, (i + 0.5) * edge, 0.0});
  return scene;
}

StackScene heavyOnLight(double ratio) {
  StackScene scene = sceneOf("heavy on light 1:" + number(ratio));
  btBoxShape& cube = scene.box(Vector3::Ones());
  scene.put(cube, kDensity, {0.0, 0.5, 0.0});
  scene.put(cube, ratio * kDensity, {0.0, 1.5, 0.0});
  return scene;
}

/// Square layers, each a block narrower.
StackScene pyramid(int base) {
  StackScene scene = sceneOf("pyramid, base " + std::to_string(base));
  btBoxShape& cube = scene.box(Vector3::Ones());
  for (int layer = 0; layer < base; ++layer) {
    const int width = base - layer;
    for (int i = 0; i < width * width; ++i) {
      const double x = i % width - 0.5 * (width - 1), z = i / width - 0.5 * (width - 1);
      scene.put(cube, kDensity, {x, layer + 0.5, z});
    }
  }
  return scene;
}

/// Every other row is shifted by a quarter of a block: by half, the blocks at its ends would be about to tip.
StackScene wall(int rows, int width) {
  StackScene scene = sceneOf("wall " + std::to_string(width) + " x " + std::to_string(rows));
  btBoxShape& cube = scene.box(Vector3::Ones());
  for (int row = 0; row < rows; ++row) {
    for (int i = 0; i < width; ++i)
      scene.put(cube, kDensity, {i - 0.5 * width + (row % 2 ? 0.25 : 0.0), row + 0.5, 0.0});
  }
  return scene;
}

/// Two cards on their edges lean against each other at `angle` from the vertical: friction on the ground must
/// bear a thrust of tan(angle) / 2 of the weight on it.
StackScene cardFrame(double frictionOverLimit) {
  StackScene scene = sceneOf("A-frame, friction " + number(frictionOverLimit) + " of the limit");
  const double angle = 25.0 * std::numbers::pi / 180.0, thickness = 0.1;
  scene.friction = frictionOverLimit * std::tan(angle) / 2.0;
  scene.stands = frictionOverLimit > 1.0;
  btBoxShape& card = scene.box({thickness, 1.0, 1.0});
  // The lowest corner on the ground, the foremost of the upper end at the other card's.
  const double height = 0.5 * (std::cos(angle) + thickness * std::sin(angle));
  const double inward = 0.5 * (std::sin(angle) + thickness * std::cos(angle));
  for (const double side : {-1.0, 1.0}) {
    scene.put(card, kDensity * thickness, {side * inward, height, 0.0}, turnAboutZ(side * angle));
  }
  return scene;
}

/// Blocks each shifted over the one below by L / (2 k), k counted from the top: the most that statics allows.
StackScene overhang(double shareOfLimit) {
  constexpr int kCount = 5;
  StackScene scene = sceneOf("overhang, " + number(shareOfLimit) + " of the limit");
  scene.stands = shareOfLimit < 1.0;
  btBoxShape& plank = scene.box({1.0, 0.2, 0.5});
  double x = 0.0;
  for (int i = 0; i < kCount; ++i) {  // the lowest lies on a fixed block and hangs over that too
    if (i == 0) scene.put(plank, 0.0, {0.0, 0.1, 0.0});
    x += shareOfLimit * 0.5 / (kCount - i);
    scene.put(plank, 0.1 * kDensity, {x, 0.2 * i + 0.3, 0.0});
  }
  return scene;
}

btConvexHullShape& hullOf(StackScene& scene, const std::vector<Vector3>& corners) {
  auto& hull = scene.add<btConvexHullShape>();
  for (const Vector3& corner : corners) hull.addPoint(toBullet(corner), false);
  hull.recalcLocalAabb();
  hull.setMargin(btScalar(0.001));
  return hull;
}

/// Half a ring of wedges on the ground, thick enough for the line of thrust of a half circle (t / R > 0.1075,
/// Heyman 1966).
StackScene arch(int wedges) {
  StackScene scene = sceneOf("arch of " + std::to_string(wedges));
  scene.friction = 0.6;
  const double inner = 1.6, outer = 2.4, width = 0.8, half = 0.5 * std::numbers::pi / wedges;
  const double middle = 0.5 * (inner + outer);
  std::vector<Vector3> corners;
  for (const double r : {inner, outer}) {
    for (const double side : {-1.0, 1.0}) {
      for (const double z : {-0.5, 0.5}) {
        corners.push_back({r * std::cos(half) - middle, side * r * std::sin(half), z * width});
      }
    }
  }
  btConvexHullShape& wedge = hullOf(scene, corners);
  const double mass = kDensity * width * std::sin(2.0 * half) * 0.5 * (outer * outer - inner * inner);
  for (int i = 0; i < wedges; ++i) {
    const double angle = (2 * i + 1) * half;
    scene.put(wedge, mass, {middle * std::cos(angle), middle * std::sin(angle), 0.0}, turnAboutZ(angle));
  }
  return scene;
}

/// A block on a slope, drawn level under gravity that leans: it tips beyond tan = width / height, as friction
/// would hold it further.
StackScene tipOrSlide(double slopeOverLimit) {
  StackScene scene = sceneOf("tip or slide, slope " + number(slopeOverLimit) + " of tipping");
  scene.friction = 0.8;
  const double width = 0.5, slope = std::atan(slopeOverLimit * width);
  scene.stands = slopeOverLimit < 1.0;
  scene.gravity = 9.81 * Vector3(std::sin(slope), -std::cos(slope), 0.0);
  scene.put(scene.box({width, 1.0, 0.5}), 0.25 * kDensity, {0.0, 0.5, 0.0});
  return scene;
}

/// Rings of blocks dropped over a pole, one upon the other.
StackScene rings(int count) {
  StackScene scene = sceneOf("rings on a pole, " + std::to_string(count));
  constexpr int kParts = 12;
  const double pole = 0.25, radius = 0.5, height = 0.2;
  const double length = 2.0 * (radius + 0.1) * std::tan(std::numbers::pi / kParts);
  btBoxShape& part = scene.box({0.2, height, length});
  auto& ring = scene.add<btCompoundShape>();
  for (int i = 0; i < kParts; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kParts;
    const Quaternion turn(Eigen::AngleAxisd(angle, Vector3::UnitY()));
    ring.addChildShape(toBullet(granular::Pose{turn * Vector3(radius, 0.0, 0.0), turn}), &part);
  }
  const double length2 = 0.5 * (count + 1) * height * 2.0;
  scene.put(scene.add<btCylinderShape>(toBullet(Vector3(pole, length2, pole))), 0.0, {0.0, length2, 0.0});
  for (int i = 0; i < count; ++i)
    scene.put(ring, 50.0, {0.05 * (i % 3 - 1), (i + 0.5) * height * 1.2, 0.05 * (i % 2)});
  return scene;
}

}  // namespace

btBoxShape& StackScene::box(const Vector3& edges) {
  return add<btBoxShape>(toBullet(Vector3(0.5 * edges)));
}

void StackScene::put(btCollisionShape& shape, double mass, const Vector3& position, const Quaternion& turn) {
  pieces.push_back({.shape = &shape, .mass = mass, .pose = {position, turn}});
}

std::vector<StackScene> stackScenes(bool full) {
  std::vector<StackScene> scenes;
  for (const int count : {10, 20, 30}) {
    if (full || count == 10) scenes.push_back(column(count, 1.0));
  }
  if (full) scenes.push_back(column(50, 1.0));
  for (const int count : {10, 20, 30}) {
    if (full || count == 10) scenes.push_back(column(count, 0.01));
  }
  for (const double ratio : {10.0, 100.0, 1000.0}) scenes.push_back(heavyOnLight(ratio));
  scenes.push_back(pyramid(full ? 5 : 3));
  scenes.push_back(full ? wall(10, 10) : wall(4, 4));
  for (const double share : {0.8, 1.25}) scenes.push_back(cardFrame(share));
  for (const double share : {0.9, 1.1}) scenes.push_back(overhang(share));
  scenes.push_back(arch(9));
  for (const double share : {0.9, 1.1}) scenes.push_back(tipOrSlide(share));
  scenes.push_back(rings(full ? 8 : 3));
  return scenes;
}

}  // namespace granular_bench
