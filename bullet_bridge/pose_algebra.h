// SPDX-License-Identifier: MIT
// Frames within frames, and turns between them: what a granular::Pose needs where bodies are drawn in one
// frame and move in another.
#pragma once

#include <cmath>

#include "granular/base/pose.h"

namespace bullet_bridge {

/// The pose of what stands at `inner` in a frame that stands at `outer`.
inline granular::Pose composed(const granular::Pose& outer, const granular::Pose& inner) {
  return {outer.toWorld(inner.position), outer.orientation * inner.orientation};
}

/// composed(pose, inverse(pose)) is the identity.
inline granular::Pose inverse(const granular::Pose& pose) {
  const granular::Quaternion back = pose.orientation.conjugate();
  return {-(back * pose.position), back};
}

/// The turn from one orientation to another, the short way round, as axis times angle, world frame, rad.
inline granular::Vector3 turnBetween(const granular::Quaternion& from, const granular::Quaternion& to) {
  granular::Quaternion turn = to * from.conjugate();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (sine == 0.0) return granular::Vector3::Zero();
  return turn.vec() * (2.0 * std::atan2(sine, turn.w()) / sine);
}

inline granular::Quaternion turnBy(const granular::Vector3& turn) {
  const double angle = turn.norm();
  if (angle == 0.0) return granular::Quaternion::Identity();
  return granular::Quaternion(Eigen::AngleAxisd(angle, turn / angle));
}

}  // namespace bullet_bridge
