// SPDX-License-Identifier: MIT
// Reads scene files (demos/scenes/README.md). A scale is a named merge patch (RFC 7396) inside the file, so
// that one file holds a scene at all its sizes. Everything wrong is said in one line that names the file and
// the key.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "demos/scene/scene_def.h"

namespace granular_demo {

/// The scene of a file at one of its scales ("small+rough": one patch after the other); file names inside are
/// relative to the file's folder. `base`: JSON of a scene over which the file is laid as a merge patch
/// (SavedState::document); a file with "continues" needs one. Throws SceneError (json_object.h).
SceneDef readSceneFile(const std::filesystem::path& file, const std::string& scale = "default",
                       const std::string& base = "");

/// The same from text in memory. `file` is what messages call it; its folder is where meshes are looked for.
SceneDef readScene(const std::string& text, const std::filesystem::path& file,
                   const std::string& scale = "default", const std::string& base = "");

struct SceneTitle {
  std::string name;
  std::string description;
  std::string continues;  ///< the scene with whose end this one begins; empty: none
};
/// What a file says of itself, the rest unread. Throws SceneError.
SceneTitle readTitle(const std::filesystem::path& file);

/// Names of the scales of a file; "default" is always one of them. Throws SceneError.
std::vector<std::string> scalesOf(const std::filesystem::path& file);

/// Names a stepper has in scene files and on the command line, in the order of granular::Stepper.
const std::vector<std::string>& stepperNames();
/// The same of granular::ContactPrecision.
const std::vector<std::string>& precisionNames();

}  // namespace granular_demo
