// SPDX-License-Identifier: MIT
// Bodies with "copies" become many: one part each, named "brick[0]", "brick[1]", ...
#pragma once

#include <vector>

#include "demos/scene/scene_def.h"

namespace granular_demo {

/// The bodies of a scene, each with copies replaced by its copies, x running fastest, then y, then z. Shifts
/// and orientations depend on the scene's seed and the copies' own.
std::vector<BodyPart> withCopies(const SceneDef& scene);

}  // namespace granular_demo
