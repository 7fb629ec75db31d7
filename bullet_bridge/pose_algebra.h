// SPDX-License-Identifier: MIT
// Frames within frames: what a granular::Pose needs where bodies are drawn in one frame and move in another.
#pragma once

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

}  // namespace bullet_bridge
