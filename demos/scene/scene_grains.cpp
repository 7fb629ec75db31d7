// SPDX-License-Identifier: MIT
#include <limits>

#include "demos/scene/scene_readers.h"

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

granular::FillRegion readRegion(JsonObject object) {
  granular::FillRegion region;
  const auto length = [&](const char* key) { return object.number(key, Range::positive()); };
  const auto axis = [&] { return object.direction("axis", Vector3::UnitY()); };
  switch (object.choice("type", {"box", "cylinder", "cone", "frustum", "ball"})) {
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
    default:
      region = granular::ballRegion(object.vector3("center"), length("radius"));
  }
  object.finish();
  return region;
}

void readScaleRange(const JsonPlace& place, granular::FillDef& fill) {
  const std::vector<JsonPlace> elements = place.elements();
  if (elements.size() != 2) place.fail("two numbers [smallest, largest]");
  fill.minScale = elements[0].number(Range::positive());
  fill.maxScale = elements[1].number({.low = fill.minScale});
}

FillPart readFill(const std::string& name, const JsonPlace& place, const std::vector<std::string>& shapeNames,
                  const std::vector<std::string>& materialNames) {
  JsonObject object(place);
  FillPart part;
  part.name = name;
  part.region = readRegion(object.object("region"));
  part.shape = shapeNames[object.choice("shape", shapeNames)];
  part.material = materialNames[object.choice("material", materialNames)];
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  part.fill.seed = static_cast<std::uint64_t>(object.integer("seed", 0, kMost, 1));
  if (object.has("count")) part.fill.count = object.integer("count", 1, kMost, 1);
  part.fill.solidFraction =
      object.number("solidFraction", {.low = 0.0, .high = 0.7, .openLow = true}, part.fill.solidFraction);
  part.fill.gap = object.number("gap", Range::notNegative(), part.fill.gap);
  if (object.has("scale")) readScaleRange(object.at("scale"), part.fill);
  part.velocity = object.vector3("velocity", part.velocity);
  part.spin = object.vector3("spin", part.spin);
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
                                const std::vector<std::string>& materialNames) {
  std::vector<FillPart> all;
  for (const auto& [name, member] : JsonObject(place).members()) {
    all.push_back(readFill(name, member, shapeNames, materialNames));
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
