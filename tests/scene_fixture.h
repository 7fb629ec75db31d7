// SPDX-License-Identifier: MIT
// A small scene in text for tests of the loader, and what it says about a change to it.
#pragma once

#include <string>

#include "demos/scene/json_object.h"
#include "demos/scene/scene_file.h"

namespace granular_demo::testing {

/// A scene with one of everything. Lengths in m.
inline Json smallScene() {
  return Json::parse(R"({
    "name": "test", "duration": 0.5, "frameRate": 20, "ticksPerFrame": 2, "seed": 3,
    "integrator": {"stepper": "rkf45", "tolerance": 1e-3},
    "materials": {"sand": {"density": 2600, "youngsModulus": 1e7, "restitution": 0.4, "friction": 0.5},
                  "steel": {"density": 7800, "youngsModulus": 1e8}},
    "pairs": [{"between": ["sand", "steel"],
               "normal": {"law": "hertz-viscoelastic", "restitution": 0.6, "atSpeed": 2},
               "shear": {"law": "regularised-coulomb", "friction": 0.3, "viscosity": 5}}],
    "shapes": {"tetra": {"type": "tetrahedron", "particleRadius": 0.01},
               "pair": {"type": "particles", "particles": [{"position": [0, 0, 0], "radius": 0.01},
                                                           {"position": [0.02, 0, 0], "radius": 0.012}]}},
    "fills": {"heap": {"region": {"type": "cone", "foot": [0, 0.02, 0], "radius": 0.2, "height": 0.15},
                       "shape": "tetra", "material": "sand", "count": 20, "scale": [0.9, 1.1],
                       "velocity": [0, -1, 0], "look": {"coloring": "speed", "fastest": 3}}},
    "grains": {"first": {"shape": "pair", "material": "sand", "position": [0, 0.5, 0],
                         "orientation": [1, 0, 0, 1], "velocity": [1, 2, 3], "spin": [0, 5, 0]}},
    "scripts": {"wobble": {"path": [{"time": 0, "offset": [0, 0, 0]}, {"time": 1, "offset": [0.1, 0, 0]}],
                           "shake": {"amplitude": [0, 0.01, 0], "frequency": 5},
                           "turn": {"axis": [0, 1, 0], "rate": 2, "from": 0.5}}},
    "bodies": {"ball": {"shape": {"type": "sphere", "radius": 0.05}, "motion": "dynamic", "density": 7800,
                        "material": "steel", "position": [0, 1, 0], "velocity": [0, -3, 0],
                        "covering": {"particleRadius": 0.01}, "replaceableByMesh": true,
                        "look": {"color": [0.8, 0.8, 0.8], "metallic": 1, "roughness": 0.2}},
               "plate": {"shape": {"type": "box", "size": [1, 0.1, 1]}, "motion": "kinematic",
                         "material": "steel", "position": [0, -0.05, 0], "script": "wobble"}},
    "container": {"lower": [-1, -1, -1], "upper": [1, 2, 1], "closed": true},
    "groundHeight": 0,
    "cameras": {"front": {"eye": [0, 1, 3], "target": [0, 0, 0]}},
    "look": {"ground": {"height": 0, "color": [0.6, 0.6, 0.6]}},
    "outputs": {"width": 320, "height": 180, "trajectories": {"bodies": ["ball"], "grains": ["first"]}},
    "scales": {"small": {"fills": {"heap": {"count": 5}}}, "still": {"bodies": {"ball": {"velocity": null}}}}
  })");
}

/// The scene with the value at a JSON pointer replaced.
inline Json withValue(const std::string& pointer, const Json& value) {
  Json scene = smallScene();
  scene[Json::json_pointer(pointer)] = value;
  return scene;
}

inline SceneDef read(const Json& scene, const std::string& scale = "default") {
  return readScene(scene.dump(), "folder/test.json", scale);
}

/// The loader's complaint about a text; empty if it has none.
inline std::string complaintAboutText(const std::string& text, const std::string& scale = "default") {
  try {
    readScene(text, "folder/test.json", scale);
    return "";
  } catch (const SceneError& error) {
    return error.what();
  }
}

inline std::string complaintAbout(const Json& scene, const std::string& scale = "default") {
  return complaintAboutText(scene.dump(), scale);
}

}  // namespace granular_demo::testing
