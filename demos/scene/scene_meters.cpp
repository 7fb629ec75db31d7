// SPDX-License-Identifier: MIT
#include <algorithm>

#include "demos/scene/scene_readers.h"

namespace granular_demo {
namespace {

FlowMeterDef readFlow(JsonObject& object) {
  FlowMeterDef def;
  def.point = object.vector3("point");
  def.direction = object.direction("direction", def.direction).normalized();
  def.from = object.number("from", Range::between(0.0, 1.0), def.from);
  def.to = object.number("to", {.low = def.from, .high = 1.0, .openLow = true}, def.to);
  return def;
}

RingMeterDef readRings(JsonObject& object, const std::vector<std::string>& bodies) {
  RingMeterDef def;
  def.rings = bodies[object.choice("rings", bodies)];
  def.poles = bodies[object.choice("poles", bodies)];
  def.holeRadius = object.number("holeRadius", Range::positive());
  def.nearPole = object.number("nearPole", Range::positive());
  JsonObject walls = object.object("walls");
  def.walls = readBox(walls);
  walls.finish();
  def.nearWall = object.number("nearWall", Range::positive());
  return def;
}

DisplacementMeterDef readDisplacement(JsonObject& object, const std::vector<std::string>& bodies) {
  DisplacementMeterDef def;
  const JsonPlace place = object.at("bodies");
  for (const JsonPlace& element : place.elements()) {
    def.bodies.push_back(element.string());
    if (std::find(bodies.begin(), bodies.end(), def.bodies.back()) == bodies.end())
      element.fail("one of " + joined(bodies));
  }
  if (def.bodies.empty()) place.fail("at least one name");
  def.distance = object.number("distance", Range::positive());
  return def;
}

PushMeterDef readPush(JsonObject& object, const std::vector<BodyPart>& bodies) {
  PushMeterDef def;
  std::vector<std::string> moved;
  for (const BodyPart& body : bodies) {
    if (body.motion != BodyKind::fixed && body.meetsGrains() && !body.copies) moved.push_back(body.name);
  }
  if (moved.empty()) object.at("body").fail("none, since no body moves and meets grains");
  def.body = moved[object.choice("body", moved)];
  def.direction = object.direction("direction", def.direction).normalized();
  def.distance = object.number("distance", Range::positive());
  return def;
}

}  // namespace

std::vector<MeterPart> readMeters(const JsonPlace& place, const std::vector<BodyPart>& bodies) {
  std::vector<MeterPart> all;
  const std::vector<std::string> names = namesOf(bodies);
  for (const auto& [name, member] : JsonObject(place).members()) {
    JsonObject object(member);
    MeterPart part;
    part.name = name;
    switch (object.choice("type", {"flow", "rings", "displacement", "push"})) {
      case 0:
        part.def = readFlow(object);
        break;
      case 1:
        part.def = readRings(object, names);
        break;
      case 2:
        part.def = readDisplacement(object, names);
        break;
      default:
        part.def = readPush(object, bodies);
    }
    object.finish();
    all.push_back(std::move(part));
  }
  return all;
}

std::vector<ExpectedPart> readExpected(const JsonPlace& place, const std::vector<MeterPart>& meters) {
  std::vector<ExpectedPart> all;
  const std::vector<std::string> names = namesOf(meters);
  for (const JsonPlace& element : place.elements()) {
    JsonObject object(element);
    ExpectedPart part;
    part.meter = names.empty() ? object.string("meter") : names[object.choice("meter", names)];
    if (names.empty()) object.at("meter").fail("none, since the scene has no meters");
    part.value = object.string("value");
    part.atLeast = object.optionalNumber("atLeast", Range::any());
    part.atMost = object.optionalNumber("atMost", Range::any());
    if (!part.atLeast && !part.atMost) element.fail("with \"atLeast\" or \"atMost\"");
    object.finish();
    all.push_back(std::move(part));
  }
  return all;
}

}  // namespace granular_demo
