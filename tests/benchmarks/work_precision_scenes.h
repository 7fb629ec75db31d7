// SPDX-License-Identifier: MIT
// Scenes whose runs are compared with themselves at a far smaller error: what each is made of, and the state
// in which the comparison starts. Short horizons, so that chaos does not decide.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "granular/granular.h"

namespace granular_bench {

/// Grains and bodies of one moment, by their indices.
struct SceneState {
  std::vector<granular::RigidMotion> grains, bodies;
};

struct PrecisionScene {
  std::string name, description;
  double horizon = 0.0;  ///< s
  double radius = 0.0;   ///< in which errors of position are given, m
  /// The scene as it is made, before anything has moved.
  std::function<granular::GranularSystem(const granular::IntegratorDef&)> build;
  /// Runs it, just built, to where the comparison starts; may take bodies out of the way.
  std::function<void(granular::GranularSystem&)> settle;
};

/// All scenes; the numbers of grains of those of spheres follow from `spheresPerSide`.
std::vector<PrecisionScene> precisionScenes(int spheresPerSide);

SceneState readState(const granular::GranularSystem& system);
void writeState(const SceneState& state, granular::GranularSystem& system);

}  // namespace granular_bench
