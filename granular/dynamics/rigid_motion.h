// SPDX-License-Identifier: MIT
// How a rigid thing stands and moves, and what pushes it.
#pragma once

#include "granular/base/pose.h"

namespace granular {

/// Where a grain's or body's own frame (centre of mass, principal axes) is and how it moves.
struct RigidMotion {
  Pose pose;                                  ///< of the principal frame, world
  Vector3 velocity = Vector3::Zero();         ///< of the centre of mass, m/s, world
  Vector3 angularVelocity = Vector3::Zero();  ///< rad/s, world
};

/// Force and torque, world frame, torque about the owner's centre of mass.
struct Wrench {
  Vector3 force = Vector3::Zero();   ///< N
  Vector3 torque = Vector3::Zero();  ///< N m
};

/// Where it is after t seconds at constant velocity and angular velocity.
inline RigidMotion advanced(const RigidMotion& motion, double t) {
  RigidMotion later = motion;
  later.pose.position += t * motion.velocity;
  const double angle = t * motion.angularVelocity.norm();
  if (angle != 0.0) {
    const Quaternion turn(Eigen::AngleAxisd(angle, motion.angularVelocity.normalized()));
    later.pose.orientation = (turn * motion.pose.orientation).normalized();
  }
  return later;
}

}  // namespace granular
