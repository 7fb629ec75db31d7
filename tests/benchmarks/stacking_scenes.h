// SPDX-License-Identifier: MIT
// Stacks as a Bullet program would build them, with what statics says of each: the same btRigidBody numbers
// for Bullet's solver and for ours. The first piece is the ground, its top at y = 0.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "granular/base/pose.h"

namespace granular_bench {

struct StackPiece {
  btCollisionShape* shape = nullptr;  ///< of the scene's
  double mass = 0.0;                  ///< kg; 0: static
  granular::Pose pose = {};
};

struct StackScene {
  std::string name;
  double size = 1.0;      ///< edge of a block, m: drift and depth are measured in it
  double friction = 0.5;  ///< between any two; Bullet multiplies, each body has its root
  granular::Vector3 gravity = {0.0, -9.81, 0.0};
  std::optional<bool> stands = true;  ///< what statics says; none: it says nothing
  std::vector<std::unique_ptr<btCollisionShape>> shapes = {};
  std::vector<StackPiece> pieces = {};

  template <class Shape, class... Arguments>
  Shape& add(Arguments&&... arguments) {
    shapes.push_back(std::make_unique<Shape>(std::forward<Arguments>(arguments)...));
    return static_cast<Shape&>(*shapes.back());
  }
  btBoxShape& box(const granular::Vector3& edges);
  void put(btCollisionShape& shape, double mass, const granular::Vector3& position,
           const granular::Quaternion& turn = granular::Quaternion::Identity());
};

/// All of VERIFICATION's section "against Bullet's own stacking"; `full` adds the tall and the many.
std::vector<StackScene> stackScenes(bool full);

}  // namespace granular_bench
