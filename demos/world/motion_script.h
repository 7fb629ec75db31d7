// SPDX-License-Identifier: MIT
// Where a scripted (kinematic) body is at a time.
#pragma once

#include "demos/scene/scene_def.h"

namespace granular_demo {

/// Pose at `time` (s) of a body placed at `start`: path and shake shift it, the turn rotates it about its own
/// origin.
Pose poseAt(const ScriptDef& script, const Pose& start, double time);

}  // namespace granular_demo
