// SPDX-License-Identifier: MIT
// The one place where numbers pass between Bullet and the core. Into the core nothing is lost. Out of it, a
// double becomes a btScalar: with float Bullet 1e-7 of the value, which is why the core keeps its own state
// and takes Bullet's only where the program changed it.
#pragma once

#include <LinearMath/btTransform.h>

#include "bullet_bridge/precision.h"
#include "granular/base/pose.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

inline granular::Vector3 fromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}

inline granular::Quaternion fromBullet(const btMatrix3x3& basis) {
  granular::Matrix3 m;
  for (int row = 0; row < 3; ++row) m.row(row) = fromBullet(basis[row]);
  return granular::Quaternion(m).normalized();
}

inline granular::Pose fromBullet(const btTransform& t) {
  return {.position = fromBullet(t.getOrigin()), .orientation = fromBullet(t.getBasis())};
}

inline btVector3 toBullet(const granular::Vector3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

/// The matrix is worked out in double and then rounded: a float quaternion would lose twice.
inline btTransform toBullet(const granular::Pose& pose) {
  const granular::Matrix3 m = pose.orientation.toRotationMatrix();
  btMatrix3x3 basis;
  for (int row = 0; row < 3; ++row) basis[row] = toBullet(granular::Vector3(m.row(row)));
  return btTransform(basis, toBullet(pose.position));
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
