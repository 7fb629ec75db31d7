// SPDX-License-Identifier: MIT
// Is all energy accounted for? E(t) + heat = E(0) + what came in; what is left over is the balance error.
#pragma once

#include "demos/world/built_scene.h"

namespace granular_demo {

/// E = kinetic + gravitational + elastic energy of grains and dynamic bodies. Came in: by emitters, by moved
/// bodies, by the host's loads, by Bullet's joints. The error is told as a fraction of the energy put in so
/// far: that of the start, with heights above the scene's floor, what was emitted, likewise, and what moved
/// bodies, loads and joints gave (what they took is not subtracted).
class EnergyBalance {
 public:
  /// Call once with the state at the start and then after every tick.
  void add(const granular::StepReport& report, const BuiltScene& scene);

  double putIn() const { return putIn_; }          ///< J, so far
  double error() const { return error_; }          ///< J, now; > 0: there is more energy than there should be
  double fraction() const;                         ///< of |error()| in putIn()
  double worstFraction() const { return worst_; }  ///< since the start
  double worstTime() const { return worstTime_; }  ///< s

 private:
  bool started_ = false;
  double energyAtStart_ = 0.0, heatAtStart_ = 0.0, floorEnergy_ = 0.0, putInAtStart_ = 0.0;
  double gained_ = 0.0;  // by moved bodies, loads and joints, where they gave
  double lastMoved_ = 0.0, lastLoads_ = 0.0, lastJoints_ = 0.0;
  double putIn_ = 0.0, error_ = 0.0, worst_ = 0.0, worstTime_ = 0.0;
};

}  // namespace granular_demo
