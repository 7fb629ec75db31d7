// SPDX-License-Identifier: MIT
// The scenes that come with the program: the files of one folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace granular_demo {

/// Folder of the scene files: that of the source tree where the program was built there, else the installed
/// one. Throws std::runtime_error if neither exists.
std::filesystem::path sceneFolder();

/// Names of all scenes in it, sorted.
std::vector<std::string> sceneNames();

/// The file meant by an argument: a path to a file, or the name of a scene that comes with the program.
/// Throws SceneError (json_object.h) if there is neither.
std::filesystem::path findScene(const std::string& nameOrFile);

}  // namespace granular_demo
