// SPDX-License-Identifier: MIT
#include <limits>

#include "demos/scene/scene_readers.h"
#include "demos/world/body_solid.h"

namespace granular_demo {
namespace {

granular::ShapeParticle readShapeParticle(const JsonPlace& place) {
  JsonObject object(place);
  granular::ShapeParticle particle = {object.vector3("position"), object.number("radius", Range::positive())};
  object.finish();
  return particle;
}

granular::GrainShapeDef readParticleList(const JsonPlace& place) {
  granular::GrainShapeDef def;
  for (const JsonPlace& element : place.elements()) def.particles.push_back(readShapeParticle(element));
  if (def.particles.empty()) place.fail("at least one particle");
  return def;
}

granular::GrainShapeDef readGrainShape(const std::string& name, const JsonPlace& place) {
  JsonObject object(place);
  const auto radius = [&] { return object.number("particleRadius", Range::positive()); };
  granular::GrainShapeDef def;
  switch (object.choice("type", {"sphere", "tetrahedron", "cube", "particles"})) {
    case 0:
      def = granular::sphereShape(radius());
      break;
    case 1:
      def = granular::tetrahedronShape(radius());
      break;
    case 2:
      def = granular::cubeShape(radius());
      break;
    default:
      def = readParticleList(object.at("particles"));
  }
  def.name = name;
  object.finish();
  return def;
}

granular::FillRegion readSlope(JsonObject& object) {
  const auto length = [&](const char* key) { return object.number(key, Range::positive()); };
  granular::SlopeDef def;
  def.foot = object.vector3("foot");
  def.uphill = object.direction("uphill", def.uphill);
  def.up = object.direction("up", def.up);
  if (def.uphill.cross(def.up).norm() < 1e-9) object.at("uphill").fail("a direction that is not \"up\"");
  def.angleDegrees = object.number("degrees", {.low = 0.0, .high = 90.0, .openHigh = true});
  def.length = length("length");
  def.width = length("width");
  def.depth = length("depth");
  return granular::slopeRegion(def);
}

granular::FillRegion readMeshRegion(JsonObject& object, const std::filesystem::path& folder) {
  const MeshShape shape = readMeshShape(object, folder);
  const Pose pose = readPose(object);
  try {
    granular::TriangleMesh mesh = readSolidMesh(shape);
    for (Vector3& v : mesh.vertices) v = pose.toWorld(v);
    return granular::meshRegion(mesh);
  } catch (const std::exception& error) {
    throw SceneError(object.place().file, object.place().path + ".file", error.what());
  }
}

granular::FillRegion readRegion(JsonObject object, const std::filesystem::path& folder) {
  granular::FillRegion region;
  const auto length = [&](const char* key) { return object.number(key, Range::positive()); };
  const auto axis = [&] { return object.direction("axis", Vector3::UnitY()); };
  switch (object.choice("type", {"box", "cylinder", "cone", "frustum", "ball", "slope", "mesh"})) {
    case 0:
      region = granular::boxRegion(readBox(object));
      break;
    case 1:
      region = granular::cylinderRegion(object.vector3("foot"), axis(), length("radius"), length("height"));
      break;
    case 2:
      region = granular::coneRegion(object.vector3("foot"), axis(), length("radius"), length("height"));
      break;
    case 3:
      region = granular::frustumRegion(object.vector3("foot"), axis(), length("footRadius"),
                                       object.number("topRadius", Range::notNegative()), length("height"));
      break;
    case 4:
      region = granular::ballRegion(object.vector3("center"), length("radius"));
      break;
    case 5:
      region = readSlope(object);
      break;
    default:
      region = readMeshRegion(object, folder);
  }
  object.finish();
  return region;
}

/// Keys "scale" and "sizes" of fills and emitters.
template <class Def>
void readSizes(JsonObject& object, Def& def) {
  def.sizes =
      static_cast<granular::SizeSpread>(object.choice("sizes", {"uniform", "logUniform", "equalVolume"}, 0));
  if (!object.has("scale")) return;
  const JsonPlace place = object.at("scale");
  const std::vector<JsonPlace> elements = place.elements();
  if (elements.size() != 2) place.fail("two numbers [smallest, largest]");
  def.minScale = elements[0].number(Range::positive());
  def.maxScale = elements[1].number({.low = def.minScale});
}

FillPart readFill(const std::string& name, const JsonPlace& place, const std::vector<std::string>& shapeNames,
                  const std::vector<std::string>& materialNames, const std::filesystem::path& folder) {
  JsonObject object(place);
  FillPart part;
  part.name = name;
  part.region = readRegion(object.object("region"), folder);
  part.shape = shapeNames[object.choice("shape", shapeNames)];
  part.material = materialNames[object.choice("material", materialNames)];
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  part.fill.seed = static_cast<std::uint64_t>(object.integer("seed", 0, kMost, 1));
  if (object.has("count")) part.fill.count = object.integer("count", 1, kMost, 1);
  part.fill.solidFraction =
      object.number("solidFraction", {.low = 0.0, .high = 0.7, .openLow = true}, part.fill.solidFraction);
  part.fill.gap = object.number("gap", Range::notNegative(), part.fill.gap);
  readSizes(object, part.fill);
  part.velocity = object.vector3("velocity", part.velocity);
  part.spin = object.vector3("spin", part.spin);
  if (object.has("look")) part.look = readGrainLook(object.at("look"));
  object.finish();
  return part;
}

EmitterPart readEmitter(const std::string& name, const JsonPlace& place,
                        const std::vector<std::string>& shapeNames,
                        const std::vector<std::string>& materialNames, const std::filesystem::path& folder) {
  JsonObject object(place);
  EmitterPart part;
  part.name = name;
  part.region = readRegion(object.object("region"), folder);
  part.shape = shapeNames[object.choice("shape", shapeNames)];
  part.material = materialNames[object.choice("material", materialNames)];
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  part.emitter.seed = static_cast<std::uint64_t>(object.integer("seed", 0, kMost, 1));
  part.emitter.rate = object.number("rate", Range::positive());
  if (object.has("count")) part.emitter.count = object.integer("count", 1, kMost, 1);
  part.emitter.gap = object.number("gap", Range::notNegative(), part.emitter.gap);
  readSizes(object, part.emitter);
  part.from = object.number("from", Range::notNegative(), part.from);
  part.to = object.number("to", {.low = part.from, .openLow = true}, part.to);
  part.velocity = object.vector3("velocity", part.velocity);
  if (object.has("look")) part.look = readGrainLook(object.at("look"));
  object.finish();
  return part;
}

GrainPart readGrain(const std::string& name, const JsonPlace& place,
                    const std::vector<std::string>& shapeNames,
                    const std::vector<std::string>& materialNames) {
  JsonObject object(place);
  GrainPart part;
  part.name = name;
  part.shape = shapeNames[object.choice("shape", shapeNames)];
  part.material = materialNames[object.choice("material", materialNames)];
  part.pose = readPose(object);
  part.velocity = object.vector3("velocity", part.velocity);
  part.spin = object.vector3("spin", part.spin);
  part.scale = object.number("scale", Range::positive(), part.scale);
  if (object.has("look")) part.look = readGrainLook(object.at("look"));
  object.finish();
  return part;
}

}  // namespace

std::vector<granular::GrainShapeDef> readGrainShapes(const JsonPlace& place) {
  std::vector<granular::GrainShapeDef> all;
  for (const auto& [name, member] : JsonObject(place).members()) all.push_back(readGrainShape(name, member));
  return all;
}

std::vector<FillPart> readFills(const JsonPlace& place, const std::vector<std::string>& shapeNames,
                                const std::vector<std::string>& materialNames,
                                const std::filesystem::path& folder) {
  std::vector<FillPart> all;
  for (const auto& [name, member] : JsonObject(place).members()) {
    all.push_back(readFill(name, member, shapeNames, materialNames, folder));
  }
  return all;
}

std::vector<EmitterPart> readEmitters(const JsonPlace& place, const std::vector<std::string>& shapeNames,
                                      const std::vector<std::string>& materialNames,
                                      const std::filesystem::path& folder) {
  std::vector<EmitterPart> all;
  for (const auto& [name, member] : JsonObject(place).members()) {
    all.push_back(readEmitter(name, member, shapeNames, materialNames, folder));
  }
  return all;
}

std::vector<GrainPart> readGrains(const JsonPlace& place, const std::vector<std::string>& shapeNames,
                                  const std::vector<std::string>& materialNames) {
  std::vector<GrainPart> all;
  for (const auto& [name, member] : JsonObject(place).members()) {
    all.push_back(readGrain(name, member, shapeNames, materialNames));
  }
  return all;
}

}  // namespace granular_demo
