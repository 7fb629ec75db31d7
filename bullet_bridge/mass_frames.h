// SPDX-License-Identifier: MIT
// A btRigidBody turns about its origin, along its own axes. A covered body has its mass where its solid has
// it. While Bullet's solver runs, such a body is shown to it as Bullet would have it: origin at the true
// centre of mass, axes along the principal ones, the true moments, and every joint's frame told in these
// axes; a jointed body also at another moment of the tick, its contacts going with it. Afterwards each number
// is put back bit for bit, so nothing of this is seen outside the solver (but by contact callbacks that it
// calls).
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <unordered_map>
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

  /// @param start      of the mass frame, at the start of the tick, for which Bullet found its contacts
  /// @param worldPose  of the mass frame, as it is shown
  void show(btRigidBody& body, const granular::Pose& start, const granular::Pose& worldPose,
            const btVector3& inverseInertia);
  /// Contact points keep their levers about bodies that are shown elsewhere than they started.
  void showContacts(btDispatcher& dispatcher);
  /// Joints of Bullet's own classes; the frames of others stay.
  void showJoints(btDiscreteDynamicsWorld& world, const FrameOf& frameOf);
  void hide();

 private:
  struct Shown {
    btRigidBody* body;
    btTransform transform;
    btVector3 inverseInertia;
  };
  struct ShiftedPoint {
    btManifoldPoint* point;
    btVector3 onA, onB;
  };
  btVector3 shiftOf(const btCollisionObject* body) const;

  std::vector<Shown> bodies_;
  std::unordered_map<const btCollisionObject*, btVector3> shifts_;  // of those shown elsewhere
  std::vector<ShiftedPoint> points_;
  std::vector<std::function<void()>> undoJoints_;
};

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
