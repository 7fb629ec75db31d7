// SPDX-License-Identifier: MIT
#include "demos/world/saved_state.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "demos/scene/json_object.h"

namespace granular_demo {
namespace {

using granular::RememberedContact;
using granular::RigidMotion;

constexpr const char* kFormat = "granular-state";
constexpr int kVersion = 4;
constexpr std::size_t kMotionSize = 13;

void add3(Json& numbers, const granular::Vector3& v) {
  for (int i = 0; i < 3; ++i) numbers.push_back(v[i]);
}

void addPose(Json& numbers, const granular::Pose& pose) {
  const granular::Quaternion& q = pose.orientation;
  add3(numbers, pose.position);
  for (const double x : {q.w(), q.x(), q.y(), q.z()}) numbers.push_back(x);
}

granular::Pose poseOf(const double* x) {
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5], x[6]}};
}

void addMotion(Json& numbers, const RigidMotion& m) {
  addPose(numbers, m.pose);
  add3(numbers, m.velocity);
  add3(numbers, m.angularVelocity);
}

RigidMotion motionAt(const std::vector<double>& n, std::size_t i) {
  const double* x = n.data() + kMotionSize * i;
  return {.pose = poseOf(x), .velocity = {x[7], x[8], x[9]}, .angularVelocity = {x[10], x[11], x[12]}};
}

/// FNV-1a of the bytes of everything but the checksum.
std::string checksumOf(const Json& state) {
  std::uint64_t hash = 0xcbf29ce484222325ull;
  for (const std::uint8_t byte : Json::to_cbor(state)) hash = (hash ^ byte) * 0x100000001b3ull;
  return std::to_string(hash);
}

/// The numbers of an array; as many as `size` unless that is negative.
std::vector<double> numbersAt(JsonObject& object, const char* key, std::int64_t size) {
  const JsonPlace place = object.at(key);
  if (!place.value->is_array()) place.fail("an array of numbers");
  if (size >= 0 && place.value->size() != static_cast<std::size_t>(size))
    throw SceneError(place.file, place.path,
                     std::to_string(place.value->size()) + " numbers; allowed: " + std::to_string(size) +
                         ", to match the other arrays");
  std::vector<double> numbers;
  numbers.reserve(place.value->size());
  for (const Json& number : *place.value) {
    if (!number.is_number() || !std::isfinite(number.get<double>()))
      throw SceneError(place.file, place.path + "[" + std::to_string(numbers.size()) + "]",
                       "value " + number.dump() + "; allowed: a finite number");
    numbers.push_back(number.get<double>());
  }
  return numbers;
}

std::vector<std::string> textsAt(JsonObject& object, const char* key) {
  std::vector<std::string> texts;
  for (const JsonPlace& element : object.at(key).elements()) texts.push_back(element.string());
  return texts;
}

Json grainsOf(const SavedState& state) {
  Json source = Json::array(), scale = Json::array(), motion = Json::array();
  for (const SavedState::Grain& grain : state.grains) {
    source.push_back(grain.source);
    scale.push_back(grain.scale);
    addMotion(motion, grain.motion);
  }
  return {{"sources", state.sources}, {"source", source}, {"scale", scale}, {"motion", motion}};
}

void readGrains(JsonObject object, SavedState& state) {
  state.sources = textsAt(object, "sources");
  const std::vector<double> source = numbersAt(object, "source", -1);
  const auto count = static_cast<std::int64_t>(source.size());
  const std::vector<double> scale = numbersAt(object, "scale", count);
  const std::vector<double> motion =
      numbersAt(object, "motion", count * static_cast<std::int64_t>(kMotionSize));
  for (std::size_t i = 0; i < source.size(); ++i) {
    if (!(source[i] >= 0.0 && source[i] < static_cast<double>(state.sources.size())))
      object.at("source").fail("numbers of entries of \"sources\"");
    state.grains.push_back({static_cast<std::int32_t>(source[i]), scale[i], motionAt(motion, i)});
  }
  object.finish();
}

Json bodiesOf(const SavedState& state) {
  Json names = Json::array(), motion = Json::array();
  for (const SavedState::Body& body : state.bodies) {
    names.push_back(body.name);
    addMotion(motion, body.motion);
  }
  return {{"names", names}, {"motion", motion}};
}

void readBodies(JsonObject object, SavedState& state) {
  const std::vector<std::string> names = textsAt(object, "names");
  const std::vector<double> motion =
      numbersAt(object, "motion", static_cast<std::int64_t>(kMotionSize * names.size()));
  for (std::size_t i = 0; i < names.size(); ++i) state.bodies.push_back({names[i], motionAt(motion, i)});
  object.finish();
}

// Numbers a remembered contact: kind, index, local of both owners, displacement, stiffness, slides.
constexpr std::size_t kMemorySize = 11;

void addContact(Json& numbers, const RememberedContact& c) {
  for (int side = 0; side < 2; ++side) {
    numbers.push_back(static_cast<int>(c.kind[side]));
    numbers.push_back(c.index[side]);
    numbers.push_back(c.local[side]);
  }
  add3(numbers, c.displacement);
  numbers.push_back(c.stiffness);
  numbers.push_back(c.slides ? 1 : 0);
}

/// Whether kind n[0] and index n[1] are those of an owner in the file; then they are put into these.
bool readOwner(const double* n, const SavedState& state, granular::OwnerKind& kind, std::int32_t& index) {
  kind = n[0] == 0.0 ? granular::OwnerKind::Grain : granular::OwnerKind::Body;
  const std::size_t known = n[0] == 0.0 ? state.grains.size() : state.bodyNames.size();
  if (!(n[1] >= 0.0 && n[1] < static_cast<double>(known))) return false;
  index = static_cast<std::int32_t>(n[1]);
  return true;
}

bool readContact(const double* n, const SavedState& state, RememberedContact& contact) {
  for (int side = 0; side < 2; ++side) {
    if (!readOwner(n + 3 * side, state, contact.kind[side], contact.index[side])) return false;
    contact.local[side] = static_cast<std::int32_t>(n[3 * side + 2]);
  }
  contact.displacement = {n[6], n[7], n[8]};
  contact.stiffness = n[9];
  contact.slides = n[10] != 0.0;
  return true;
}

Json memoryOf(const SavedState& state) {
  Json numbers = Json::array();
  for (const RememberedContact& c : state.memory) addContact(numbers, c);
  return {{"bodyNames", state.bodyNames}, {"contacts", numbers}};
}

void readMemory(JsonObject object, SavedState& state) {
  state.bodyNames = textsAt(object, "bodyNames");
  const std::vector<double> n = numbersAt(object, "contacts", -1);
  if (n.size() % kMemorySize != 0) object.at("contacts").fail("eleven numbers a contact");
  for (std::size_t i = 0; i < n.size(); i += kMemorySize) {
    if (!readContact(n.data() + i, state, state.memory.emplace_back()))
      object.at("contacts").fail("owners that are in the file");
  }
  object.finish();
}

// Numbers a sleeper: kind, index, force and torque held, force carried. One that rests: kind, index, seconds,
// where. A frozen contact: those of a remembered one, whether it does remember, force, point, overlap,
// overlap in radii, energy.
constexpr std::size_t kSleeperSize = 9, kResterSize = 10, kFrozenSize = kMemorySize + 10;

Json sleepOf(const SavedState& state) {
  Json sleepers = Json::array(), resters = Json::array(), frozen = Json::array();
  for (const granular::SleepState::Sleeper& sleeper : state.sleep.sleepers) {
    sleepers.push_back(static_cast<int>(sleeper.kind));
    sleepers.push_back(sleeper.index);
    add3(sleepers, sleeper.held.force);
    add3(sleepers, sleeper.held.torque);
    sleepers.push_back(sleeper.carried);
  }
  for (const granular::SleepState::Rester& rester : state.sleep.resters) {
    resters.push_back(static_cast<int>(rester.kind));
    resters.push_back(rester.index);
    resters.push_back(rester.seconds);
    addPose(resters, rester.pose);
  }
  for (const granular::FrozenContact& contact : state.sleep.frozen) {
    addContact(frozen, contact.memory);
    frozen.push_back(contact.remembers ? 1 : 0);
    add3(frozen, contact.force);
    add3(frozen, contact.point);
    for (const double x : {contact.overlap, contact.relativeOverlap, contact.normalEnergy})
      frozen.push_back(x);
  }
  return {{"sleepers", sleepers},
          {"resters", resters},
          {"frozen", frozen},
          {"untilLook", state.sleep.untilLook},
          {"untilWaking", state.sleep.untilWaking}};
}

void readSleep(JsonObject object, SavedState& state) {
  const std::vector<double> sleepers = numbersAt(object, "sleepers", -1);
  if (sleepers.size() % kSleeperSize != 0) object.at("sleepers").fail("nine numbers a sleeper");
  for (std::size_t i = 0; i < sleepers.size(); i += kSleeperSize) {
    const double* n = sleepers.data() + i;
    granular::SleepState::Sleeper& sleeper = state.sleep.sleepers.emplace_back();
    if (!readOwner(n, state, sleeper.kind, sleeper.index))
      object.at("sleepers").fail("owners that are in the file");
    sleeper.held = {.force = {n[2], n[3], n[4]}, .torque = {n[5], n[6], n[7]}};
    sleeper.carried = n[8];
  }
  const std::vector<double> resters = numbersAt(object, "resters", -1);
  if (resters.size() % kResterSize != 0) object.at("resters").fail("ten numbers one that rests");
  for (std::size_t i = 0; i < resters.size(); i += kResterSize) {
    const double* n = resters.data() + i;
    granular::SleepState::Rester& rester = state.sleep.resters.emplace_back();
    if (!readOwner(n, state, rester.kind, rester.index))
      object.at("resters").fail("owners that are in the file");
    rester.seconds = n[2];
    rester.pose = poseOf(n + 3);
  }
  state.sleep.untilLook = object.number("untilLook", Range::notNegative());
  state.sleep.untilWaking = object.number("untilWaking", Range::notNegative());
  const std::vector<double> frozen = numbersAt(object, "frozen", -1);
  if (frozen.size() % kFrozenSize != 0) object.at("frozen").fail("21 numbers a frozen contact");
  for (std::size_t i = 0; i < frozen.size(); i += kFrozenSize) {
    granular::FrozenContact& contact = state.sleep.frozen.emplace_back();
    if (!readContact(frozen.data() + i, state, contact.memory))
      object.at("frozen").fail("owners that are in the file");
    const double* n = frozen.data() + i + kMemorySize;
    contact.remembers = n[0] != 0.0;
    contact.force = {n[1], n[2], n[3]};
    contact.point = {n[4], n[5], n[6]};
    contact.overlap = n[7];
    contact.relativeOverlap = n[8];
    contact.normalEnergy = n[9];
  }
  object.finish();
}

Json emittersOf(const SavedState& state) {
  Json all = Json::array();
  for (const SavedState::Emitter& emitter : state.emitters)
    all.push_back({{"name", emitter.name}, {"seconds", emitter.seconds}, {"poured", emitter.poured}});
  return all;
}

void readEmitters(const JsonPlace& place, SavedState& state) {
  for (const JsonPlace& element : place.elements()) {
    JsonObject object(element);
    SavedState::Emitter emitter;
    emitter.name = object.string("name");
    emitter.seconds = object.number("seconds", Range::notNegative());
    emitter.poured = object.integer("poured", 0, std::numeric_limits<std::int64_t>::max(), 0);
    object.finish();
    state.emitters.push_back(emitter);
  }
}

}  // namespace

void writeState(const SavedState& state, const std::filesystem::path& file) {
  Json json = {{"format", kFormat},
               {"version", kVersion},
               {"scene", state.scene},
               {"scale", state.scale},
               {"seed", state.seed},
               {"time", state.time},
               {"ticks", state.ticks},
               {"document", state.document},
               {"grains", grainsOf(state)},
               {"bodies", bodiesOf(state)},
               {"emitters", emittersOf(state)},
               {"brokenJoints", state.brokenJoints},
               {"memory", memoryOf(state)},
               {"sleep", sleepOf(state)}};
  json["checksum"] = checksumOf(json);
  const std::vector<std::uint8_t> bytes = Json::to_cbor(json);
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw std::runtime_error(file.string() + ": cannot be written");
}

SavedState readState(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) throw SceneError(file.string(), "", "cannot be opened");
  const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  Json json;
  try {
    json = Json::from_cbor(bytes);
  } catch (const Json::exception&) {
    throw SceneError(file.string(), "", "not a state file, or cut off: it is not whole CBOR");
  }
  if (!json.is_object() || !json.contains("format") || json["format"] != kFormat)
    throw SceneError(file.string(), "", "not a state file: \"format\" is not \"granular-state\"");
  JsonObject object({&json, file.string(), ""});
  if (object.integer("version", 1, std::numeric_limits<int>::max(), 1) != kVersion)
    object.at("version").fail(std::to_string(kVersion) + ", the version this program reads");
  const std::string checksum = object.string("checksum");
  Json unsummed = json;
  unsummed.erase("checksum");
  if (checksumOf(unsummed) != checksum)
    throw SceneError(file.string(), "checksum", "differs from the content: the file is damaged");

  object.string("format");
  SavedState state;
  state.document = object.string("document");
  state.scene = object.string("scene");
  state.scale = object.string("scale");
  state.seed =
      static_cast<std::uint64_t>(object.integer("seed", 0, std::numeric_limits<std::int64_t>::max(), 1));
  state.time = object.number("time", Range::notNegative());
  state.ticks = object.integer("ticks", 0, std::numeric_limits<std::int64_t>::max(), 0);
  readGrains(object.object("grains"), state);
  readBodies(object.object("bodies"), state);
  readEmitters(object.at("emitters"), state);
  state.brokenJoints = textsAt(object, "brokenJoints");
  readMemory(object.object("memory"), state);
  readSleep(object.object("sleep"), state);
  object.finish();
  return state;
}

}  // namespace granular_demo
