// SPDX-License-Identifier: MIT
// A btRigidBody turns about its origin, along its own axes. A covered body has its mass where its solid has
// it. While Bullet's solver runs, such a body is shown to it as Bullet would have it: origin at the true
// centre of mass, axes along the principal ones, the true moments, and every joint's frame told in these
// axes. Afterwards each number is put back bit for bit, so nothing of this is seen outside the solver (but by
// contact callbacks that it calls).
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <vector>

#include "bullet_bridge/precision.h"
#include "granular/base/pose.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

class MassFrames {
 public:
  /// The body's mass frame within its own; null: the body is as Bullet has it.
  using FrameOf = std::function<const granular::Pose*(const btRigidBody&)>;

  /// @param worldPose  of the mass frame
  void show(btRigidBody& body, const granular::Pose& worldPose, const btVector3& inverseInertia);
  /// Joints of Bullet's own classes; the frames of others stay.
  void showJoints(btDiscreteDynamicsWorld& world, const FrameOf& frameOf);
  void hide();

 private:
  struct Shown {
    btRigidBody* body;
    btTransform transform;
    btVector3 inverseInertia;
  };
  std::vector<Shown> bodies_;
  std::vector<std::function<void()>> undoJoints_;
};

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
