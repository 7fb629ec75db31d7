// SPDX-License-Identifier: MIT
#include <limits>

#include "demos/scene_readers.h"

namespace granular_demo {
namespace {

constexpr double kForever = std::numeric_limits<double>::infinity();

MeshShape readMeshShape(JsonObject& object, const std::filesystem::path& folder) {
  MeshShape shape;
  const JsonPlace file = object.at("file");
  shape.file = folder / file.string();
  if (!std::filesystem::is_regular_file(shape.file)) file.fail("a mesh file, relative to the scene file");
  shape.boundingSize = object.optionalNumber("boundingSize", Range::positive());
  shape.scale = object.number("scale", Range::positive(), shape.scale);
  if (object.has("scale") && shape.boundingSize)
    object.at("scale").fail("none, since \"boundingSize\" is given too");
  if (object.has("center")) shape.center = object.vector3("center");
  return shape;
}

BodyShapeDef readShape(const JsonPlace& place, const std::filesystem::path& folder);

CompoundShape readCompound(const JsonPlace& place, const std::filesystem::path& folder) {
  CompoundShape compound;
  for (const JsonPlace& element : place.elements()) {
    JsonObject child(element);
    const Pose pose = readPose(child);
    const JsonPlace shape = child.at("shape");
    compound.children.push_back({readShape(shape, folder), pose});
    if (std::holds_alternative<HalfSpaceShape>(compound.children.back().shape))
      shape.fail("any shape but a halfSpace, which has no end");
    child.finish();
  }
  if (compound.children.empty()) place.fail("at least one child");
  return compound;
}

BodyShapeDef readShape(const JsonPlace& place, const std::filesystem::path& folder) {
  JsonObject object(place);
  const auto length = [&](const char* key) { return object.number(key, Range::positive()); };
  BodyShapeDef shape;
  switch (object.choice("type", {"mesh", "box", "sphere", "capsule", "cylinder", "cone", "planePatch",
                                 "halfSpace", "compound"})) {
    case 0:
      shape = readMeshShape(object, folder);
      break;
    case 1: {
      const Vector3 size = object.vector3("size");
      if (size.minCoeff() <= 0.0) object.at("size").fail("three numbers > 0");
      shape = BoxShape{size};
      break;
    }
    case 2:
      shape = SphereShape{length("radius")};
      break;
    case 3:
      shape = CapsuleShape{length("radius"), length("height")};
      break;
    case 4:
      shape = CylinderShape{length("radius"), length("height")};
      break;
    case 5:
      shape = ConeShape{length("radius"), length("height")};
      break;
    case 6:
      shape = PlanePatchShape{length("sizeX"), length("sizeZ")};
      break;
    case 7:
      shape = HalfSpaceShape{.normal = object.direction("normal", Vector3::UnitY()).normalized(),
                             .height = object.number("height", Range::any(), 0.0),
                             .shownSize = object.number("shownSize", Range::positive(), 1.0)};
      break;
    default:
      shape = readCompound(object.at("children"), folder);
  }
  object.finish();
  return shape;
}

LayerDef readLayer(JsonObject& object) {
  LayerDef layer;
  layer.particleRadius = object.number("particleRadius", Range::positive());
  layer.density = object.optionalNumber("density", Range::positive());
  layer.offset = object.optionalNumber("offset", Range::any());
  return layer;
}

CoveringPart readCovering(JsonObject object) {
  CoveringPart part;
  part.layer = readLayer(object);
  part.seed =
      static_cast<std::uint64_t>(object.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 1));
  if (object.has("roughness")) {
    JsonObject roughness = object.object("roughness");
    part.roughness = readLayer(roughness);
    roughness.finish();
  }
  object.finish();
  return part;
}

std::vector<ScriptPoint> readPath(const JsonPlace& place) {
  std::vector<ScriptPoint> path;
  for (const JsonPlace& element : place.elements()) {
    JsonObject object(element);
    const Range later = path.empty() ? Range::notNegative() : Range{.low = path.back().time, .openLow = true};
    path.push_back({object.number("time", later), object.vector3("offset")});
    object.finish();
  }
  return path;
}

ScriptDef readScript(const JsonPlace& place) {
  JsonObject object(place);
  ScriptDef script;
  if (object.has("path")) script.path = readPath(object.at("path"));
  if (object.has("shake")) {
    JsonObject shake = object.object("shake");
    ScriptShake& def = script.shake.emplace();
    def.amplitude = shake.vector3("amplitude");
    def.frequency = shake.number("frequency", Range::positive());
    def.phase = shake.number("phase", Range::any(), 0.0);
    def.from = shake.number("from", Range::notNegative(), 0.0);
    def.to = shake.number("to", {.low = def.from}, kForever);
    shake.finish();
  }
  if (object.has("turn")) {
    JsonObject turn = object.object("turn");
    ScriptTurn& def = script.turn.emplace();
    def.axis = turn.direction("axis", Vector3::UnitY()).normalized();
    def.rate = turn.number("rate", Range::any());
    def.from = turn.number("from", Range::notNegative(), 0.0);
    def.to = turn.number("to", {.low = def.from}, kForever);
    turn.finish();
  }
  object.finish();
  return script;
}

/// Moments of a solid: none exceeds the sum of the other two (a flat body reaches it).
void readInertia(JsonObject& object, BodyPart& part) {
  if (!object.has("inertia")) return;
  const JsonPlace place = object.at("inertia");
  const Vector3 inertia = place.vector3();
  if (!part.mass) place.fail("only together with \"mass\"");
  if (inertia.minCoeff() <= 0.0) place.fail("three numbers > 0");
  if (2.0 * inertia.maxCoeff() > inertia.sum() * (1.0 + 1e-9)) {
    place.fail("three numbers of which none exceeds the sum of the other two");
  }
  part.inertia = inertia;
}

/// A dynamic body needs exactly one of mass and density; for others they mean nothing.
void readMass(JsonObject& object, BodyPart& part) {
  part.mass = object.optionalNumber("mass", Range::positive());
  part.density = object.optionalNumber("density", Range::positive());
  if (part.motion != BodyKind::dynamic) {
    if (part.mass) object.at("mass").fail("only for \"motion\": \"dynamic\"");
    if (part.density) object.at("density").fail("only for \"motion\": \"dynamic\"");
    return;
  }
  if (part.mass && part.density) object.at("density").fail("none, since \"mass\" is given too");
  if (!part.mass && !part.density) object.place().fail("with \"mass\" or \"density\", since it is dynamic");
}

bool isOpen(const BodyShapeDef& shape) {
  return std::holds_alternative<PlanePatchShape>(shape) || std::holds_alternative<HalfSpaceShape>(shape);
}

void readContact(JsonObject& object, BodyPart& part) {
  const bool isEndless = std::holds_alternative<HalfSpaceShape>(part.shape);
  const bool canBeExact = !std::holds_alternative<PlanePatchShape>(part.shape) &&
                          !std::holds_alternative<CompoundShape>(part.shape);
  part.contact = static_cast<BodyContact>(object.choice("contact", {"particles", "exact"}, 0));
  if (object.has("covering")) part.covering = readCovering(object.object("covering"));
  if (part.contact == BodyContact::exact && !canBeExact)
    object.at("contact").fail("\"particles\" for a planePatch or a compound");
  if (part.contact == BodyContact::exact && part.covering)
    object.at("covering").fail("none, since \"contact\" is \"exact\"");
  if (part.covering && isEndless) object.at("covering").fail("none for a halfSpace: \"contact\": \"exact\"");
}

BodyPart readBody(const std::string& name, const JsonPlace& place,
                  const std::vector<std::string>& materialNames, const std::vector<std::string>& scriptNames,
                  const std::filesystem::path& folder) {
  JsonObject object(place);
  BodyPart part;
  part.name = name;
  part.shape = readShape(object.at("shape"), folder);
  part.motion = static_cast<BodyKind>(object.choice("motion", {"static", "kinematic", "dynamic"}, 0));
  if (part.motion == BodyKind::dynamic && isOpen(part.shape)) {
    object.at("motion").fail("\"static\" or \"kinematic\" for a planePatch or halfSpace");
  }
  readMass(object, part);
  readInertia(object, part);
  part.material = materialNames[object.choice("material", materialNames)];
  readContact(object, part);
  part.pose = readPose(object);
  part.velocity = object.vector3("velocity", part.velocity);
  part.spin = object.vector3("spin", part.spin);
  if (object.has("script")) {
    part.script = scriptNames[object.choice("script", scriptNames)];
    if (part.motion != BodyKind::kinematic) object.at("script").fail("only for \"motion\": \"kinematic\"");
  }
  for (const char* key : {"velocity", "spin"}) {
    if (object.has(key) && part.motion != BodyKind::dynamic)
      object.at(key).fail("only for \"motion\": \"dynamic\"");
  }
  part.replaceableByMesh = object.boolean("replaceableByMesh", false);
  if (object.has("look")) part.look = readBodyLook(object.at("look"));
  object.finish();
  return part;
}

}  // namespace

std::map<std::string, ScriptDef> readScripts(const JsonPlace& place) {
  std::map<std::string, ScriptDef> all;
  for (const auto& [name, member] : JsonObject(place).members()) all[name] = readScript(member);
  return all;
}

std::vector<BodyPart> readBodies(const JsonPlace& place, const std::vector<std::string>& materialNames,
                                 const std::vector<std::string>& scriptNames,
                                 const std::filesystem::path& folder) {
  std::vector<BodyPart> all;
  for (const auto& [name, member] : JsonObject(place).members()) {
    all.push_back(readBody(name, member, materialNames, scriptNames, folder));
  }
  return all;
}

}  // namespace granular_demo
