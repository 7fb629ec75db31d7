// SPDX-License-Identifier: MIT
#include <algorithm>

#include "demos/scene/scene_readers.h"

namespace granular_demo {
namespace {

Surface readSurface(JsonObject& object, Surface surface) {
  surface.color = object.color("color", surface.color);
  surface.roughness = object.number("roughness", Range::between(0.0, 1.0), surface.roughness);
  surface.metallic = object.number("metallic", Range::between(0.0, 1.0), surface.metallic);
  surface.opacity = object.number("opacity", Range::between(0.0, 1.0), surface.opacity);
  surface.glass = static_cast<Glass>(object.choice("glass", {"thin", "solid"}, 0));
  return surface;
}

Ground readGround(JsonObject object) {
  Ground ground;
  ground.height = object.number("height", Range::any(), ground.height);
  ground.color = object.color("color", ground.color);
  ground.roughness = object.number("roughness", Range::between(0.0, 1.0), ground.roughness);
  ground.gridSpacing = object.number("gridSpacing", Range::notNegative(), ground.gridSpacing);
  object.finish();
  return ground;
}

Camera readCamera(const JsonPlace& place) {
  JsonObject object(place);
  Camera camera;
  camera.eye = object.vector3("eye");
  camera.target = object.vector3("target");
  camera.up = object.direction("up", camera.up);
  camera.verticalFieldOfViewDegrees = object.number(
      "verticalFieldOfViewDegrees", {.low = 0.0, .high = 170.0, .openLow = true, .openHigh = true},
      camera.verticalFieldOfViewDegrees);
  if ((camera.target - camera.eye).cross(camera.up).norm() == 0.0) {
    object.at("target").fail("a point off the line through \"eye\" along \"up\"");
  }
  object.finish();
  return camera;
}

std::vector<std::string> readNames(const JsonPlace& place, const std::vector<std::string>& known) {
  std::vector<std::string> names;
  for (const JsonPlace& element : place.elements()) {
    names.push_back(element.string());
    if (std::find(known.begin(), known.end(), names.back()) == known.end()) {
      element.fail("one of " + joined(known));
    }
  }
  return names;
}

}  // namespace

std::vector<CameraPart> readCameras(const JsonPlace& place) {
  std::vector<CameraPart> all;
  for (const auto& [name, member] : JsonObject(place).members()) all.push_back({name, readCamera(member)});
  return all;
}

GrainLook readGrainLook(const JsonPlace& place) {
  JsonObject object(place);
  GrainLook look;
  look.coloring = static_cast<Coloring>(object.choice("coloring", {"sand", "owner", "speed", "fixed"}, 0));
  look.color = object.color("color", look.color);
  look.fastest = object.number("fastest", Range::positive(), look.fastest);
  object.finish();
  return look;
}

BodyLook readBodyLook(const JsonPlace& place) {
  JsonObject object(place);
  BodyLook look;
  look.surface = readSurface(object, look.surface);
  look.visible = object.boolean("visible", look.visible);
  look.showParticles = object.boolean("showParticles", look.showParticles);
  look.particleColor = object.color("particleColor", look.particleColor);
  object.finish();
  return look;
}

SceneLook readLook(const JsonPlace& place) {
  JsonObject object(place);
  SceneLook look;
  if (object.has("ground")) look.ground = readGround(object.object("ground"));
  if (object.has("sky")) {
    JsonObject sky = object.object("sky");
    look.sky.zenith = sky.color("zenith", look.sky.zenith);
    look.sky.horizon = sky.color("horizon", look.sky.horizon);
    sky.finish();
  }
  if (object.has("sun")) {
    JsonObject sun = object.object("sun");
    look.sun.towards = sun.direction("towards", look.sun.towards);
    look.sun.color = sun.color("color", look.sun.color);
    look.sun.irradiance = sun.number("irradiance", Range::notNegative(), look.sun.irradiance);
    look.sun.angularRadiusDegrees =
        sun.number("angularRadiusDegrees", {.low = 0.0, .high = 45.0}, look.sun.angularRadiusDegrees);
    sun.finish();
  }
  look.ballRoughness = object.number("grainRoughness", Range::between(0.0, 1.0), look.ballRoughness);
  object.finish();
  return look;
}

OutputsDef readOutputs(const JsonPlace& place, const std::vector<std::string>& bodyNames,
                       const std::vector<std::string>& grainNames) {
  JsonObject object(place);
  OutputsDef outputs;
  outputs.pictures = object.boolean("pictures", outputs.pictures);
  outputs.film = object.boolean("film", outputs.film);
  // Larger pictures than any film format takes are a mistake; odd sizes are refused by the film's pixel
  // format.
  outputs.width = static_cast<int>(object.integer("width", 16, 16384, outputs.width));
  outputs.height = static_cast<int>(object.integer("height", 16, 16384, outputs.height));
  if (outputs.width % 2 != 0) object.at("width").fail("an even number");
  if (outputs.height % 2 != 0) object.at("height").fail("an even number");
  outputs.quality = static_cast<Quality>(object.choice("quality", {"preview", "normal", "best"}, 0));
  outputs.vtp = object.boolean("vtp", outputs.vtp);
  outputs.vtpEvery = static_cast<int>(object.integer("vtpEvery", 1, 1000000, outputs.vtpEvery));
  outputs.state = object.boolean("state", outputs.state);
  if (object.has("trajectories")) {
    JsonObject trajectories = object.object("trajectories");
    if (trajectories.has("bodies"))
      outputs.trajectoryBodies = readNames(trajectories.at("bodies"), bodyNames);
    if (trajectories.has("grains"))
      outputs.trajectoryGrains = readNames(trajectories.at("grains"), grainNames);
    trajectories.finish();
  }
  object.finish();
  return outputs;
}

}  // namespace granular_demo
