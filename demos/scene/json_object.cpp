// SPDX-License-Identifier: MIT
#include "demos/scene/json_object.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace granular_demo {
namespace {

// A wrong value is shown so far; a whole object in an error line would hide the rest.
constexpr std::size_t kShownLength = 60;

std::string shown(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= kShownLength ? text : text.substr(0, kShownLength) + "...";
}

std::string withoutTrailingZeros(double x) {
  std::ostringstream text;
  text << x;
  return text.str();
}

}  // namespace

SceneError::SceneError(std::string inFile, std::string atPath, std::string isWrong)
    : std::runtime_error(inFile + ": " + (atPath.empty() ? "" : atPath + ": ") + isWrong),
      file(std::move(inFile)),
      path(std::move(atPath)),
      problem(std::move(isWrong)) {}

bool Range::holds(double x) const {
  return std::isfinite(x) && (openLow ? x > low : x >= low) && (openHigh ? x < high : x <= high);
}

std::string Range::text() const {
  const bool hasLow = std::isfinite(low);
  const bool hasHigh = std::isfinite(high);
  if (hasLow && hasHigh) {
    return std::string("a number in ") + (openLow ? "(" : "[") + withoutTrailingZeros(low) + ", " +
           withoutTrailingZeros(high) + (openHigh ? ")" : "]");
  }
  if (hasLow) return std::string("a number ") + (openLow ? "> " : ">= ") + withoutTrailingZeros(low);
  if (hasHigh) return std::string("a number ") + (openHigh ? "< " : "<= ") + withoutTrailingZeros(high);
  return "a number";
}

void JsonPlace::fail(const std::string& allowed) const {
  throw SceneError(file, path.empty() ? "the file" : path,
                   "value " + shown(*value) + "; allowed: " + allowed);
}

double JsonPlace::number(const Range& range) const {
  if (!value->is_number()) fail(range.text());
  const double x = value->get<double>();
  if (!range.holds(x)) fail(range.text());
  return x;
}

granular::Vector3 JsonPlace::vector3() const {
  if (!value->is_array() || value->size() != 3) fail("three numbers [x, y, z]");
  granular::Vector3 v;
  for (int i = 0; i < 3; ++i) {
    v[i] = JsonPlace{&(*value)[i], file, path + "[" + std::to_string(i) + "]"}.number(Range::any());
  }
  return v;
}

std::string JsonPlace::string() const {
  if (!value->is_string()) fail("a string");
  return value->get<std::string>();
}

std::vector<JsonPlace> JsonPlace::elements() const {
  if (!value->is_array()) fail("an array");
  std::vector<JsonPlace> all;
  for (std::size_t i = 0; i < value->size(); ++i) {
    all.push_back({&(*value)[i], file, path + "[" + std::to_string(i) + "]"});
  }
  return all;
}

JsonObject::JsonObject(JsonPlace place) : place_(std::move(place)) {
  if (!place_.value->is_object()) place_.fail("an object");
}

bool JsonObject::has(const std::string& key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  return place_.value->contains(key);
}

JsonPlace JsonObject::at(const std::string& key) {
  const std::string path = place_.path.empty() ? key : place_.path + "." + key;
  if (!has(key)) throw SceneError(place_.file, path, "is missing");
  return {&(*place_.value)[key], place_.file, path};
}

std::vector<std::pair<std::string, JsonPlace>> JsonObject::members() {
  std::vector<std::pair<std::string, JsonPlace>> all;
  for (const auto& item : place_.value->items()) all.emplace_back(item.key(), at(item.key()));
  return all;
}

double JsonObject::number(const std::string& key, const Range& range, double fallback) {
  return has(key) ? at(key).number(range) : fallback;
}

std::optional<double> JsonObject::optionalNumber(const std::string& key, const Range& range) {
  return has(key) ? std::optional(at(key).number(range)) : std::nullopt;
}

std::int64_t JsonObject::integer(const std::string& key, std::int64_t low, std::int64_t high,
                                 std::int64_t fallback) {
  if (!has(key)) return fallback;
  const JsonPlace value = at(key);
  const std::string allowed =
      high == std::numeric_limits<std::int64_t>::max()
          ? "an integer >= " + std::to_string(low)
          : "an integer in [" + std::to_string(low) + ", " + std::to_string(high) + "]";
  const bool tooLarge = value.value->is_number_unsigned() &&
                        value.value->get<std::uint64_t>() >
                            static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (!value.value->is_number_integer() || tooLarge) value.fail(allowed);
  const auto x = value.value->get<std::int64_t>();
  if (x < low || x > high) value.fail(allowed);
  return x;
}

bool JsonObject::boolean(const std::string& key, bool fallback) {
  if (!has(key)) return fallback;
  const JsonPlace value = at(key);
  if (!value.value->is_boolean()) value.fail("true or false");
  return value.value->get<bool>();
}

std::string JsonObject::string(const std::string& key, const std::string& fallback) {
  return has(key) ? at(key).string() : fallback;
}

granular::Vector3 JsonObject::vector3(const std::string& key, const granular::Vector3& fallback) {
  return has(key) ? at(key).vector3() : fallback;
}

granular::Vector3 JsonObject::direction(const std::string& key, const granular::Vector3& fallback) {
  if (!has(key)) return fallback;
  const granular::Vector3 v = at(key).vector3();
  if (v.norm() == 0.0) at(key).fail("a direction, not zero");
  return v;
}

granular::Quaternion JsonObject::quaternion(const std::string& key) {
  if (!has(key)) return granular::Quaternion::Identity();
  const JsonPlace place = at(key);
  const std::string allowed = "four numbers [w, x, y, z], not all zero";
  if (!place.value->is_array() || place.value->size() != 4) place.fail(allowed);
  double q[4];
  const std::vector<JsonPlace> elements = place.elements();
  for (int i = 0; i < 4; ++i) q[i] = elements[i].number(Range::any());
  const granular::Quaternion rotation(q[0], q[1], q[2], q[3]);
  if (rotation.norm() == 0.0) place.fail(allowed);
  return rotation.normalized();
}

Color JsonObject::color(const std::string& key, const Color& fallback) {
  if (!has(key)) return fallback;
  const granular::Vector3 c = at(key).vector3();
  if (c.minCoeff() < 0.0 || c.maxCoeff() > 1.0) at(key).fail("three numbers in [0, 1]: red, green, blue");
  return c.cast<float>().array();
}

std::size_t JsonObject::choice(const std::string& key, const std::vector<std::string>& names) {
  const JsonPlace place = at(key);
  const std::string allowed = "one of " + joined(names);
  if (!place.value->is_string()) place.fail(allowed);
  const auto found = std::find(names.begin(), names.end(), place.value->get<std::string>());
  if (found == names.end()) place.fail(allowed);
  return static_cast<std::size_t>(found - names.begin());
}

std::size_t JsonObject::choice(const std::string& key, const std::vector<std::string>& names,
                               std::size_t fallback) {
  return has(key) ? choice(key, names) : fallback;
}

void JsonObject::finish() const {
  for (const auto& item : place_.value->items()) {
    if (std::find(known_.begin(), known_.end(), item.key()) != known_.end()) continue;
    const std::string path = place_.path.empty() ? item.key() : place_.path + "." + item.key();
    throw SceneError(place_.file, path, "unknown key; allowed here: " + joined(known_));
  }
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace granular_demo
