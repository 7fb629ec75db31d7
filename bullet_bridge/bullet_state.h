// SPDX-License-Identifier: MIT
// What Bullet holds of a body's motion, compared bit for bit: a difference from what was last written is the
// program's doing.
#pragma once

#include <btBulletDynamicsCommon.h>

#include "bullet_bridge/convert.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

struct BulletState {
  btTransform transform;
  btVector3 velocity;
  btVector3 angularVelocity;
};

inline BulletState stateOf(const btRigidBody& body) {
  return {body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity()};
}

inline bool isFinite(const BulletState& s) {
  const btMatrix3x3& basis = s.transform.getBasis();
  for (const btVector3& v :
       {s.transform.getOrigin(), basis[0], basis[1], basis[2], s.velocity, s.angularVelocity}) {
    if (!fromBullet(v).allFinite()) return false;
  }
  return true;
}

/// Bit for bit in all that counts (the fourth component of a btVector3 is padding).
inline bool isSame(const btVector3& a, const btVector3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}
inline bool isSame(const btMatrix3x3& a, const btMatrix3x3& b) {
  return isSame(a[0], b[0]) && isSame(a[1], b[1]) && isSame(a[2], b[2]);
}
inline bool isSame(const btTransform& a, const btTransform& b) {
  return isSame(a.getOrigin(), b.getOrigin()) && isSame(a.getBasis(), b.getBasis());
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
