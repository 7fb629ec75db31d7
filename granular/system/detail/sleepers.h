// SPDX-License-Identifier: MIT
// What sleepers are pressed with. Contacts between two that do not move are frozen: kept as they were, with
// what they remember, and not evaluated. The sum of the frozen forces on a sleeper and of the forces that
// awake neighbours put on it at present is its balance; where that is lost for long enough, it wakes.
//
// Lost for long enough: the mean of the net force over some time is compared. What a sleeper can hold is then
// an impulse: a wave of an impact passes, which is strong and short and moves nothing for good; a load that
// stays wakes it, the sooner the larger it is.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "granular/system/detail/evaluation.h"
#include "granular/system/granular_system.h"

namespace granular::detail {

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

/// What a sleeper has held lately.
struct Held {
  Wrench mean;           // of the net force and torque, what is longer ago counting less
  Wrench last;           // net when last looked at
  double carried = 0.0;  // mean of what it carries, N, so that a blow does not count as that; 0: not known
  double time = 0.0;     // when last looked at, s
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
  /// sleepers, by owner, whose mean net force or torque is beyond this fraction of what they carry, the
  /// present one where no awake owner touches them: of those that awake owners touch now or touched at the
  /// last call, of all of them at the first one after reset(). now: s; memory: time over which the mean is
  /// taken, s.
  const std::vector<std::int32_t>& findUnbalanced(const Evaluation& evaluation, double fraction, double now,
                                                  double memory);
  /// Of those that the last call returned: whether somebody is to be woken at once, since it is out of
  /// balance twice as far, or nobody awake touches it, so that its mean will not fade.
  bool isUrgent() const { return isUrgent_; }
  /// It is asleep from now, s, on, and has held this.
  void begin(OwnerKind kind, std::int32_t index, double now, const Wrench& mean = {});
  /// Mean net force and torque on it at the last call of findUnbalanced. memory: as there.
  Wrench heldBy(OwnerKind kind, std::int32_t index, double memory) const;
  /// On all sleepers at the last call, N.
  Vector3 netForce() const { return frozenNet_ + awakeNet_; }

 private:
  Vector3 takeAwake(const Evaluation& evaluation);
  Held& recordOf(OwnerKind kind, std::int32_t index);

  std::vector<SleeperLoad> loads_;
  std::vector<Held> ofGrain_, ofBody_;  // by index: they outlive layouts
  double lastLook_ = 0.0;               // s
  std::vector<std::int32_t> touched_, lookAt_, lookedAt_, unbalanced_;
  bool isUrgent_ = false;
  Vector3 frozenNet_ = Vector3::Zero(), awakeNet_ = Vector3::Zero();
};

}  // namespace granular::detail
