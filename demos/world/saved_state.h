// SPDX-License-Identifier: MIT
// A scene as it stands at one moment, in a file: to go on from, or for another scene to begin with.
// Holds the scene's own JSON (so shapes, materials and coverings come with it; mesh files are named), and
// what moves: grains, bodies, emitters, broken joints, contact memory, and who sleeps. CBOR (RFC 8949) of one
// object with numbers in plain arrays, a motion as 13 numbers: position, orientation w x y z, velocity,
// angular velocity.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "granular/system/granular_system.h"

namespace granular_demo {

struct SavedState {
  std::string document;  ///< of the scene, its scale applied: SceneDef::document
  std::string scene;
  std::string scale;
  std::uint64_t seed = 1;
  double time = 0.0;  ///< s
  std::int64_t ticks = 0;

  struct Grain {
    std::int32_t source = 0;  ///< index into `sources`
    double scale = 1.0;
    granular::RigidMotion motion;
  };
  struct Body {
    std::string name;
    granular::RigidMotion motion;  ///< of the body frame
  };
  struct Emitter {
    std::string name;
    double seconds = 0.0;  ///< poured for
    std::int64_t poured = 0;
  };
  std::vector<std::string> sources;  ///< "fills.heap": where grains came from, which gives shape and material
  std::vector<Grain> grains;
  std::vector<Body> bodies;  ///< dynamic ones
  std::vector<Emitter> emitters;
  std::vector<std::string> brokenJoints;
  /// Owners by place in `grains`; bodies by place among all bodies of the scene, see `bodyNames`.
  std::vector<granular::RememberedContact> memory;
  granular::SleepState sleep;  ///< owners as in `memory`
  std::vector<std::string> bodyNames;
};

/// Throws std::runtime_error if the file cannot be written.
void writeState(const SavedState& state, const std::filesystem::path& file);

/// Throws SceneError naming the file, the key and what is wrong: not such a file, cut off, damaged (its
/// checksum differs), of a later version, arrays of unequal length, numbers that are not finite.
SavedState readState(const std::filesystem::path& file);

}  // namespace granular_demo
