// SPDX-License-Identifier: MIT
// How fast things will hit each other in a scene: what its advice is given for.
#pragma once

#include <string>

namespace granular_demo {

class BuiltScene;

struct ImpactSpeed {
  double speed = 0.0;  ///< m/s
  std::string reason;  ///< where it comes from, in a few words
};

/// The larger of the largest speed at the start and sqrt(2 g h), h the height of the scene: from the lowest
/// to the highest point that anything can touch, along gravity. Half-spaces count where they lie under the
/// grains and bodies.
ImpactSpeed impactSpeedOf(const BuiltScene& scene);

}  // namespace granular_demo
