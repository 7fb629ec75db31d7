// SPDX-License-Identifier: MIT
#include "demos/scene/scene_catalog.h"

#include <algorithm>
#include <stdexcept>

#include "demos/scene/json_object.h"

namespace granular_demo {

std::filesystem::path sceneFolder() {
  for (const char* folder : {GRANULAR_SCENE_FOLDER, GRANULAR_INSTALLED_SCENE_FOLDER}) {
    if (std::filesystem::is_directory(folder)) return folder;
  }
  throw std::runtime_error(std::string("no scene folder: neither ") + GRANULAR_SCENE_FOLDER + " nor " +
                           GRANULAR_INSTALLED_SCENE_FOLDER + " exists");
}

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(sceneFolder())) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::filesystem::path findScene(const std::string& nameOrFile) {
  if (std::filesystem::is_regular_file(nameOrFile)) return nameOrFile;
  const std::vector<std::string> names = sceneNames();
  if (std::find(names.begin(), names.end(), nameOrFile) != names.end())
    return sceneFolder() / (nameOrFile + ".json");
  throw SceneError(nameOrFile, "", "no such file or scene; scenes: " + joined(names));
}

}  // namespace granular_demo
