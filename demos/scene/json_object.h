// SPDX-License-Identifier: MIT
// Reads one object of a scene file key by key and complains in one line that names the file and the key path:
//   splash.json: bodies.ball.density: value -3; allowed: a number > 0
// Every key that was asked for is known; `finish` rejects the others, so that a misspelt key is never
// ignored.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "demos/render/color.h"
#include "granular/base/pose.h"

namespace granular_demo {

using Json = nlohmann::ordered_json;

/// What is wrong with a scene file, in one line: "<file>: <path>: <what>".
class SceneError : public std::runtime_error {
 public:
  SceneError(std::string inFile, std::string atPath, std::string isWrong);

  std::string file;
  std::string path;  ///< key path, "line 3, column 7", or empty for the file as a whole
  std::string problem;
};

/// Which numbers a key takes.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool openLow = false;   ///< low itself is not allowed
  bool openHigh = false;  ///< high itself is not allowed

  bool holds(double x) const;
  std::string text() const;  ///< "a number > 0", "a number in [0, 1]"

  static Range any() { return {}; }
  static Range positive() { return {.low = 0.0, .openLow = true}; }
  static Range notNegative() { return {.low = 0.0}; }
  static Range between(double low, double high) { return {.low = low, .high = high}; }
};

/// A value and where it stands.
struct JsonPlace {
  const Json* value = nullptr;
  std::string file;
  std::string path;

  [[noreturn]] void fail(const std::string& allowed) const;  ///< "value <value>; allowed: <allowed>"
  double number(const Range& range) const;
  granular::Vector3 vector3() const;
  std::string string() const;
  std::vector<JsonPlace> elements() const;  ///< of an array
};

class JsonObject {
 public:
  explicit JsonObject(JsonPlace place);  ///< throws SceneError if it is not an object

  bool has(const std::string& key);
  const JsonPlace& place() const { return place_; }
  /// The value of a key that must be there.
  JsonPlace at(const std::string& key);
  JsonObject object(const std::string& key) { return JsonObject(at(key)); }
  /// All members of an object whose keys are names.
  std::vector<std::pair<std::string, JsonPlace>> members();

  double number(const std::string& key, const Range& range) { return at(key).number(range); }
  double number(const std::string& key, const Range& range, double fallback);
  std::optional<double> optionalNumber(const std::string& key, const Range& range);
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high, std::int64_t fallback);
  bool boolean(const std::string& key, bool fallback);
  std::string string(const std::string& key) { return at(key).string(); }
  std::string string(const std::string& key, const std::string& fallback);
  granular::Vector3 vector3(const std::string& key) { return at(key).vector3(); }
  granular::Vector3 vector3(const std::string& key, const granular::Vector3& fallback);
  granular::Vector3 direction(const std::string& key, const granular::Vector3& fallback);  ///< not zero
  /// w, x, y, z; need not be of length 1 but not zero.
  granular::Quaternion quaternion(const std::string& key);
  Color color(const std::string& key, const Color& fallback);  ///< three numbers in [0, 1]

  /// The key's string as one of `names`; its place in that list.
  std::size_t choice(const std::string& key, const std::vector<std::string>& names);
  std::size_t choice(const std::string& key, const std::vector<std::string>& names, std::size_t fallback);

  /// Throws for the first key that nobody asked for, with those that are known.
  void finish() const;

 private:
  JsonPlace place_;
  std::vector<std::string> known_;
};

/// "a, b, c"
std::string joined(const std::vector<std::string>& names);

}  // namespace granular_demo
