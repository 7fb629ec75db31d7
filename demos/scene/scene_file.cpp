// SPDX-License-Identifier: MIT
#include "demos/scene/scene_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <sstream>

#include "demos/scene/scene_readers.h"

namespace granular_demo {
namespace {

/// "line 3, column 7" of a place in the text; both count from 1, columns in bytes.
std::string lineAndColumn(const std::string& text, std::size_t byte) {
  const std::string before = text.substr(0, std::min(byte, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t lastBreak = before.rfind('\n');
  const std::size_t column = lastBreak == std::string::npos ? before.size() : before.size() - lastBreak - 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(std::max<std::size_t>(1, column));
}

/// What nlohmann-json found wrong, without its own place and number.
std::string reasonOf(const Json::parse_error& error) {
  const std::string text = error.what();
  const std::size_t column = text.find("column ");
  const std::size_t colon = text.find(": ", column == std::string::npos ? 0 : column);
  std::string reason = colon == std::string::npos ? text : text.substr(colon + 2);
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return reason;
}

/// Finds keys given twice in one object, of which JSON libraries silently drop one.
class DuplicateKeys {
 public:
  bool operator()(int, Json::parse_event_t event, Json& parsed) {
    using Event = Json::parse_event_t;
    if (event == Event::object_start) open_.emplace_back();
    if (event == Event::object_end) open_.pop_back();
    if (event == Event::key && !open_.back().insert(parsed.get<std::string>()).second && found.empty()) {
      found = parsed.get<std::string>();
    }
    return true;
  }

  std::string found;

 private:
  std::vector<std::set<std::string>> open_;
};

Json parse(const std::string& text, const std::string& file) {
  DuplicateKeys duplicates;
  try {
    Json json = Json::parse(text, std::ref(duplicates));
    if (!duplicates.found.empty())
      throw SceneError(file, "", "key \"" + duplicates.found + "\" is given twice in one object");
    return json;
  } catch (const Json::parse_error& error) {
    throw SceneError(file, lineAndColumn(text, error.byte), "not JSON: " + reasonOf(error));
  } catch (const Json::out_of_range&) {
    throw SceneError(file, "", "holds a number too large for a double");
  }
}

std::string textOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) throw SceneError(file.string(), "", "cannot be opened");
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::vector<std::string> scaleNames(const Json& json, const std::string& file) {
  std::vector<std::string> names;
  if (json.is_object() && json.contains("scales")) {
    for (const auto& [name, patch] : JsonObject({&json["scales"], file, "scales"}).members()) {
      JsonObject{patch};  // an object, or it throws
      names.push_back(name);
    }
  }
  if (std::find(names.begin(), names.end(), "default") == names.end()) names.push_back("default");
  return names;
}

/// A named patch and its name.
struct Patch {
  std::string name;
  Json json;
};

/// The patches of a scale, or of several joined by "+".
std::vector<Patch> patchesOf(const Json& json, const std::string& scale, const std::string& file) {
  const std::vector<std::string> names = scaleNames(json, file);
  std::vector<Patch> patches;
  std::istringstream parts(scale);
  for (std::string name; std::getline(parts, name, '+');) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw SceneError(file, "scales", "value \"" + name + "\"; allowed: one of " + joined(names));
    const bool there = json.is_object() && json.contains("scales") && json["scales"].contains(name);
    patches.push_back({name, there ? json["scales"][name] : Json::object()});
  }
  return patches;
}

/// Whether a key path such as "bodies.ball.shape" is set by a patch.
bool isSetBy(const Json& patch, const std::string& path) {
  const Json* at = &patch;
  std::istringstream keys(path);
  for (std::string key; std::getline(keys, key, '.');) {
    if (at->is_array()) return true;  // arrays are replaced as a whole
    key = key.substr(0, key.find('['));
    if (!at->is_object() || !at->contains(key)) return false;
    at = &(*at)[key];
  }
  return true;
}

granular::IntegratorDef readIntegrator(const JsonPlace& place) {
  JsonObject object(place);
  granular::IntegratorDef def;
  def.stepper = static_cast<granular::Stepper>(object.choice("stepper", stepperNames(), 0));
  def.fixedSubStep = object.number("fixedSubStep", Range::notNegative(), def.fixedSubStep);
  def.tolerance = object.number("tolerance", Range::positive(), def.tolerance);
  def.contactTimeFraction = object.number("contactTimeFraction", {.low = 0.0, .high = 0.3, .openLow = true},
                                          def.contactTimeFraction);
  def.eventFraction =
      object.number("eventFraction", {.low = 0.0, .high = 1.0, .openLow = true}, def.eventFraction);
  def.eventContacts = static_cast<int>(
      object.integer("eventContacts", 0, std::numeric_limits<int>::max(), def.eventContacts));
  def.precision = static_cast<granular::ContactPrecision>(object.choice("precision", precisionNames(), 0));
  def.turnSpheres = object.boolean("turnSpheres", def.turnSpheres);
  def.smallestSubStep = object.number("smallestSubStep", Range::positive(), def.smallestSubStep);
  def.trialLimit =
      static_cast<int>(object.integer("trialLimit", 1, std::numeric_limits<int>::max(), def.trialLimit));
  object.finish();
  return def;
}

granular::SleepDef readSleep(const JsonPlace& place) {
  JsonObject object(place);
  granular::SleepDef def;
  def.enabled = object.boolean("enabled", true);
  def.restTime = object.number("restTime", Range::positive(), def.restTime);
  def.restWay = object.number("restWay", Range::positive(), def.restWay);
  def.balance = object.number("balance", Range::positive(), def.balance);
  def.wakeImbalance =
      object.number("wakeImbalance", {.low = def.balance}, std::max(def.balance, def.wakeImbalance));
  object.finish();
  return def;
}

ContainerDef readContainer(JsonObject object) {
  ContainerDef def;
  def.box = readBox(object);
  def.closed = object.boolean("closed", def.closed);
  object.finish();
  return def;
}

void readTimes(JsonObject& object, SceneDef& scene) {
  scene.duration = object.number("duration", Range::positive());
  scene.frameRate = object.number("frameRate", Range::positive(), scene.frameRate);
  scene.ticksPerFrame = static_cast<int>(object.integer("ticksPerFrame", 1, 1000000, scene.ticksPerFrame));
  if (scene.duration * scene.frameRate > 1e9) object.at("duration").fail("less than 1e9 frames");
}

SceneDef readDocument(const Json& json, const std::filesystem::path& file) {
  const Json none = Json::object();
  const Json nothing = Json::array();
  JsonObject object({&json, file.string(), ""});
  const auto named = [&](const char* key) {
    return object.has(key) ? object.at(key) : JsonPlace{&none, file.string(), key};
  };
  const auto listed = [&](const char* key) {
    return object.has(key) ? object.at(key) : JsonPlace{&nothing, file.string(), key};
  };

  SceneDef scene;
  scene.file = file;
  scene.name = object.string("name");
  scene.description = object.string("description", "");
  scene.continues = object.string("continues", "");
  scene.gravity = object.vector3("gravity", scene.gravity);
  readTimes(object, scene);
  scene.seed =
      static_cast<std::uint64_t>(object.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 1));
  scene.integrator = readIntegrator(named("integrator"));
  if (object.has("sleep")) scene.sleep = readSleep(object.at("sleep"));
  scene.materials = readMaterials(object.at("materials"));
  const std::vector<std::string> materials = namesOf(scene.materials);
  scene.pairs = readPairs(listed("pairs"), materials);
  scene.shapes = readGrainShapes(named("shapes"));
  scene.fills = readFills(named("fills"), namesOf(scene.shapes), materials, file.parent_path());
  scene.grains = readGrains(named("grains"), namesOf(scene.shapes), materials);
  scene.scripts = readScripts(named("scripts"));
  std::vector<std::string> scripts;
  for (const auto& script : scene.scripts) scripts.push_back(script.first);
  scene.bodies = readBodies(named("bodies"), materials, scripts, file.parent_path());
  scene.emitters = readEmitters(named("emitters"), namesOf(scene.shapes), materials, file.parent_path());
  scene.joints = readJoints(named("joints"), scene.bodies);
  scene.meters = readMeters(named("meters"), scene.bodies);
  scene.expected = readExpected(listed("expect"), scene.meters);
  scene.largestStartOverlap =
      object.number("largestStartOverlap", Range::notNegative(), scene.largestStartOverlap);
  if (object.has("container")) scene.container = readContainer(object.object("container"));
  scene.groundHeight = object.optionalNumber("groundHeight", Range::any());
  scene.cameras = readCameras(named("cameras"));
  scene.look = readLook(named("look"));
  std::vector<std::string> single;
  for (const BodyPart& body : scene.bodies) {
    if (!body.copies) single.push_back(body.name);
  }
  scene.outputs = readOutputs(named("outputs"), single, namesOf(scene.grains));
  object.finish();
  return scene;
}

}  // namespace

int SceneDef::frameCount() const {
  return std::max(1, static_cast<int>(std::ceil(duration * frameRate - 1e-6)));
}

Pose readPose(JsonObject& object) {
  Pose pose;
  pose.position = object.vector3("position", pose.position);
  if (!object.has("orientation") || object.at("orientation").value->is_array()) {
    pose.orientation = object.quaternion("orientation");
    return pose;
  }
  JsonObject turn = object.object("orientation");
  const double degrees = turn.number("degrees", Range::any());
  const Vector3 axis = turn.direction("axis", Vector3::UnitY()).normalized();
  pose.orientation = Quaternion(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, axis));
  turn.finish();
  return pose;
}

Box readBox(JsonObject& object) {
  const Box box = {object.vector3("lower"), object.vector3("upper")};
  if ((box.size().array() <= 0.0).any()) object.at("upper").fail("greater than \"lower\" in x, y and z");
  return box;
}

const std::vector<std::string>& stepperNames() {
  static const std::vector<std::string> names = {"rkf45", "leapfrog", "verlet", "semiImplicitEuler",
                                                 "bogackiShampine"};
  return names;
}

const std::vector<std::string>& precisionNames() {
  static const std::vector<std::string> names = {"double", "mixed"};
  return names;
}

SceneDef readScene(const std::string& text, const std::filesystem::path& file, const std::string& scale,
                   const std::string& base) {
  Json json = parse(text, file.string());
  const std::vector<Patch> patches = patchesOf(json, scale, file.string());
  if (json.is_object()) {
    json.erase("scales");
    for (const Patch& patch : patches) json.merge_patch(patch.json);
    if (base.empty() && json.contains("continues")) {
      const std::string from = JsonObject({&json, file.string(), ""}).string("continues");
      throw SceneError(file.string(), "continues",
                       "begins with the end of \"" + from + "\": needs its state file (granular_demo run " +
                           from + " writes it, --resume FILE reads it)");
    }
    if (!base.empty()) {
      Json whole = parse(base, file.string());
      whole.merge_patch(json);
      json = std::move(whole);
    }
  }
  try {
    SceneDef scene = readDocument(json, file);
    scene.scale = scale;
    scene.document = json.dump();
    return scene;
  } catch (const SceneError& error) {
    const auto last = std::find_if(patches.rbegin(), patches.rend(),
                                   [&](const Patch& patch) { return isSetBy(patch.json, error.path); });
    if (last == patches.rend()) throw;
    throw SceneError(error.file, "scales." + last->name + "." + error.path, error.problem);
  }
}

SceneDef readSceneFile(const std::filesystem::path& file, const std::string& scale, const std::string& base) {
  return readScene(textOf(file), file, scale, base);
}

SceneTitle readTitle(const std::filesystem::path& file) {
  const Json json = parse(textOf(file), file.string());
  JsonObject object({&json, file.string(), ""});
  return {object.string("name"), object.string("description", ""), object.string("continues", "")};
}

std::vector<std::string> scalesOf(const std::filesystem::path& file) {
  return scaleNames(parse(textOf(file), file.string()), file.string());
}

}  // namespace granular_demo
