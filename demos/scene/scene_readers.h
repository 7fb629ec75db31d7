// SPDX-License-Identifier: MIT
// The parts of a scene file, each read by one function; used by scene_file.cpp alone. All throw SceneError.
#pragma once

#include "demos/scene/json_object.h"
#include "demos/scene/scene_def.h"

namespace granular_demo {

// scene_materials.cpp
std::vector<granular::MaterialDef> readMaterials(const JsonPlace& place);
std::vector<PairDef> readPairs(const JsonPlace& place, const std::vector<std::string>& materialNames);

// scene_grains.cpp
std::vector<granular::GrainShapeDef> readGrainShapes(const JsonPlace& place);
std::vector<FillPart> readFills(const JsonPlace& place, const std::vector<std::string>& shapeNames,
                                const std::vector<std::string>& materialNames,
                                const std::filesystem::path& folder);
std::vector<EmitterPart> readEmitters(const JsonPlace& place, const std::vector<std::string>& shapeNames,
                                      const std::vector<std::string>& materialNames,
                                      const std::filesystem::path& folder);
std::vector<GrainPart> readGrains(const JsonPlace& place, const std::vector<std::string>& shapeNames,
                                  const std::vector<std::string>& materialNames);

// scene_bodies.cpp
std::map<std::string, ScriptDef> readScripts(const JsonPlace& place);
std::vector<BodyPart> readBodies(const JsonPlace& place, const std::vector<std::string>& materialNames,
                                 const std::vector<std::string>& scriptNames,
                                 const std::filesystem::path& folder);

/// Keys of a mesh: "file", "scale" or "boundingSize", "center".
MeshShape readMeshShape(JsonObject& object, const std::filesystem::path& folder);

// scene_joints.cpp
std::vector<JointPart> readJoints(const JsonPlace& place, const std::vector<BodyPart>& bodies);

// scene_meters.cpp
std::vector<MeterPart> readMeters(const JsonPlace& place, const std::vector<BodyPart>& bodies);
std::vector<ExpectedPart> readExpected(const JsonPlace& place, const std::vector<MeterPart>& meters);

// scene_look.cpp
std::vector<CameraPart> readCameras(const JsonPlace& place);
SceneLook readLook(const JsonPlace& place);
GrainLook readGrainLook(const JsonPlace& place);
BodyLook readBodyLook(const JsonPlace& place);
OutputsDef readOutputs(const JsonPlace& place, const std::vector<std::string>& bodyNames,
                       const std::vector<std::string>& grainNames);

/// Keys "position" and "orientation": a quaternion [w, x, y, z] or {"axis": [x, y, z], "degrees": angle}.
Pose readPose(JsonObject& object);
Box readBox(JsonObject& object);  ///< keys "lower" and "upper"

template <class Part>
std::vector<std::string> namesOf(const std::vector<Part>& parts) {
  std::vector<std::string> names;
  for (const Part& part : parts) names.push_back(part.name);
  return names;
}

}  // namespace granular_demo
