// SPDX-License-Identifier: MIT
// Cubes on the ground in a Bullet world, all covered: what stacks are tested with.
#pragma once

#include <cmath>
#include <vector>

#include "bridge_fixture.h"

namespace bridge_test {

inline constexpr double kGravity = 9.81;  // m/s^2
inline constexpr double kTick = 1.0 / 60.0;
inline constexpr double kDensity = 1000.0;  // kg/m^3

inline double massOfCube(double edge) {
  return kDensity * edge * edge * edge;
}

/// Static ground below y = 0 and cubes above it, everything covered, nothing ever asleep.
class Cubes {
 public:
  explicit Cubes(double edge) : edge_(edge) {
    scene.world->setGravity(vec(0, -kGravity, 0));
    ground = &scene.body(0, scene.box(2 * edge, edge, 2 * edge), at(0, -edge, 0));
    scene.world->coverBody(*ground);
  }

  btRigidBody& add(const Vector3& center) {
    btRigidBody& cube = scene.body(massOfCube(edge_), scene.box(edge_ / 2, edge_ / 2, edge_ / 2),
                                   at(center.x(), center.y(), center.z()));
    cube.setActivationState(DISABLE_DEACTIVATION);
    scene.world->coverBody(cube);
    cubes.push_back(&cube);
    return cube;
  }
  void run(double time) {
    for (double t = 0.0; t < time - 0.5 * kTick; t += kTick)
      scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  }
  /// Of the foundation between two bodies, N/m^3.
  double stiffness(const btRigidBody& a, const btRigidBody& b) {
    granular::GranularSystem& core = scene.world->grains();
    const auto materialOf = [&](const btRigidBody& body) {
      return core.bodyDef(scene.world->bodyIdOf(body)).material;
    };
    return core.materialPair(materialOf(a), materialOf(b)).bodyNormal.stiffness.value();
  }

  SandScene scene;
  btRigidBody* ground = nullptr;
  std::vector<btRigidBody*> cubes;

 private:
  double edge_;
};

}  // namespace bridge_test
