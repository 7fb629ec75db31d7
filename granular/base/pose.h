// SPDX-License-Identifier: MIT
// Vectors, rotations and rigid placement: the vocabulary of every other header. SI units everywhere.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace granular {

using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;

/// Placement of a rigid thing: takes its own frame to the world frame, p_world = position + orientation *
/// p_own.
struct Pose {
  Vector3 position = Vector3::Zero();               ///< m, world frame
  Quaternion orientation = Quaternion::Identity();  ///< unit quaternion

  Vector3 toWorld(const Vector3& p) const { return position + orientation * p; }
  Vector3 toOwn(const Vector3& p) const { return orientation.conjugate() * (p - position); }
};

/// Axis-aligned box, world frame unless said otherwise.
struct Box {
  Vector3 lower = Vector3::Zero();  ///< m
  Vector3 upper = Vector3::Zero();  ///< m

  Vector3 size() const { return upper - lower; }
  Vector3 center() const { return 0.5 * (lower + upper); }
};

}  // namespace granular
