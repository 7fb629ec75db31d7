// SPDX-License-Identifier: MIT
// What sleepers are pressed with. Contacts between two that do not move are frozen: kept as they were, with
// what they remember, and not evaluated. The sum of the frozen forces on a sleeper and of the forces that
// awake neighbours put on it at present is its balance; where that is lost, it wakes.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "granular/system/detail/evaluation.h"
#include "granular/system/granular_system.h"

namespace granular::detail {

/// A contact between two owners of which none is awake.
struct FrozenContact {
  RememberedContact memory;         ///< who touches whom; what it remembers only where `remembers`
  bool remembers = false;           ///< under laws 17 and 19
  Vector3 force = Vector3::Zero();  ///< N, on the first owner, world
  Vector3 point = Vector3::Zero();  ///< m, world
  double overlap = 0.0;             ///< m
  double relativeOverlap = 0.0;     ///< in smaller radii of the pair
  double normalEnergy = 0.0;        ///< in its normal spring, J
};

/// Sums over frozen contacts and sleepers: they stay while nobody wakes or falls asleep.
struct FrozenTotals {
  double elastic = 0.0, potential = 0.0;          ///< J
  double overlapSum = 0.0, largestOverlap = 0.0;  ///< in smaller radii of the pairs
};

/// What one sleeper is pressed with: by frozen contacts and gravity, and by awake owners at present.
struct SleeperLoad {
  Vector3 force = Vector3::Zero(), torque = Vector3::Zero();            // N, N m about its centre
  Vector3 awakeForce = Vector3::Zero(), awakeTorque = Vector3::Zero();  // the same
  double carried = 0.0, awakeCarried = 0.0;  // sum of the sizes of contact forces, N
  Wrench hostLoad;
  bool wasTouched = false;
};

/// Since when something has been at rest, and where.
struct Rest {
  double since = 0.0;  // s
  Pose pose;
};

/// Whether the net force and torque on an owner exceed this fraction of what it carries.
inline bool isUnbalanced(const Owner& owner, const Vector3& force, const Vector3& torque, double carried,
                         double fraction) {
  const double most = fraction * carried;
  return !(force.norm() <= most && torque.norm() <= most * owner.reach);
}

/// What presses on the sleepers of a layout, which are numbered [0, layout.sleeperCount()).
class SleeperLoads {
 public:
  /// weights: m g of each; hostLoads: what the host puts on them; endsOfFrozen: owners of each frozen
  /// contact.
  void reset(const Evaluation& evaluation, std::span<const FrozenContact> frozen,
             std::span<const std::pair<std::int32_t, std::int32_t>> endsOfFrozen,
             std::span<const Vector3> weights, std::span<const Wrench> hostLoads);
  /// Takes what awake owners put on sleepers from the contacts that were evaluated last. Returns the
  /// sleepers, by owner, whose net force or torque is beyond this fraction of what they carry: of those that
  /// awake owners touch now or touched at the last call, of all of them at the first one after reset().
  const std::vector<std::int32_t>& findUnbalanced(const Evaluation& evaluation, double fraction);
  /// On all sleepers at the last call, N.
  Vector3 netForce() const { return frozenNet_ + awakeNet_; }

 private:
  Vector3 takeAwake(const Evaluation& evaluation);

  std::vector<SleeperLoad> loads_;
  std::vector<std::int32_t> touched_, lookAt_, unbalanced_;
  Vector3 frozenNet_ = Vector3::Zero(), awakeNet_ = Vector3::Zero();
};

}  // namespace granular::detail
