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
constexpr int kVersion = 2;
constexpr std::size_t kMotionSize = 13;

void addMotion(Json& numbers, const RigidMotion& m) {
  const auto add3 = [&](const granular::Vector3& v) {
    for (int i = 0; i < 3; ++i) numbers.push_back(v[i]);
  };
  const granular::Quaternion& q = m.pose.orientation;
  add3(m.pose.position);
  for (const double x : {q.w(), q.x(), q.y(), q.z()}) numbers.push_back(x);
  add3(m.velocity);
  add3(m.angularVelocity);
}

RigidMotion motionAt(const std::vector<double>& n, std::size_t i) {
  const double* x = n.data() + kMotionSize * i;
  return {.pose = {{x[0], x[1], x[2]}, {x[3], x[4], x[5], x[6]}},
          .velocity = {x[7], x[8], x[9]},
          .angularVelocity = {x[10], x[11], x[12]}};
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

Json memoryOf(const SavedState& state) {
  Json numbers = Json::array();
  for (const RememberedContact& c : state.memory) {
    for (int side = 0; side < 2; ++side) {
      numbers.push_back(static_cast<int>(c.kind[side]));
      numbers.push_back(c.index[side]);
      numbers.push_back(c.local[side]);
    }
    for (int i = 0; i < 3; ++i) numbers.push_back(c.displacement[i]);
    numbers.push_back(c.stiffness);
    numbers.push_back(c.slides ? 1 : 0);
  }
  return {{"bodyNames", state.bodyNames}, {"contacts", numbers}};
}

void readMemory(JsonObject object, SavedState& state) {
  state.bodyNames = textsAt(object, "bodyNames");
  const std::vector<double> n = numbersAt(object, "contacts", -1);
  if (n.size() % kMemorySize != 0) object.at("contacts").fail("eleven numbers a contact");
  for (std::size_t i = 0; i < n.size(); i += kMemorySize) {
    RememberedContact contact;
    for (std::size_t side = 0; side < 2; ++side) {
      const double* own = n.data() + i + 3 * side;
      contact.kind[side] = own[0] == 0.0 ? granular::OwnerKind::Grain : granular::OwnerKind::Body;
      const std::size_t known = own[0] == 0.0 ? state.grains.size() : state.bodyNames.size();
      if (!(own[1] >= 0.0 && own[1] < static_cast<double>(known)))
        object.at("contacts").fail("owners that are in the file");
      contact.index[side] = static_cast<std::int32_t>(own[1]);
      contact.local[side] = static_cast<std::int32_t>(own[2]);
    }
    contact.displacement = {n[i + 6], n[i + 7], n[i + 8]};
    contact.stiffness = n[i + 9];
    contact.slides = n[i + 10] != 0.0;
    state.memory.push_back(contact);
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
               {"memory", memoryOf(state)}};
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
  object.finish();
  return state;
}

}  // namespace granular_demo
