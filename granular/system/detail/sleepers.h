// SPDX-License-Identifier: MIT
// What sleepers are pressed with. Contacts between two that do not move are frozen: kept as they were, with
// what they remember, and not evaluated. The sum of the frozen forces on a sleeper and of the forces that
// awake neighbours put on it at present is its balance; where that is lost for long enough, it wakes.
//
// Lost for long enough: the mean of the net force over some time is compared. What a sleeper can hold is then
// an impulse: a wave of an impact passes, which is strong and short and moves nothing for good; a load that
// stays wakes it, the sooner the larger it is.
//
// Known by kind and index, whatever the layout. A look costs what awake owners touch, and what has changed.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/frozen_contacts.h"
#include "granular/system/granular_system.h"

namespace granular::detail {

/// What does not change while an owner sleeps.
struct SleeperTraits {
  Vector3 center = Vector3::Zero();  ///< m
  Vector3 weight = Vector3::Zero();  ///< N
  Wrench hostLoad;
  Vector3 linearFactor = Vector3::Ones(), angularFactor = Vector3::Ones();
  double reach = 0.0;  ///< as Owner::reach, m
};
using TraitsOfSleeper = std::function<SleeperTraits(OwnerKey)>;

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

/// How far any point of what reaches so far has moved, at most, m.
inline double wayBetween(const Pose& a, const Pose& b, double reach) {
  return (a.position - b.position).norm() + a.orientation.angularDistance(b.orientation) * reach;
}

/// Whether the net force and torque on what reaches so far exceed this fraction of what it carries.
inline bool isUnbalanced(double reach, const Vector3& force, const Vector3& torque, double carried,
                         double fraction) {
  const double most = fraction * carried;
  return !(force.norm() <= most && torque.norm() <= most * reach);
}

/// What presses on those that sleep.
class Sleepers {
 public:
  explicit Sleepers(TraitsOfSleeper traitsOf) : traitsOf_(std::move(traitsOf)) {}

  /// It is asleep from now, s, on, and has held and carried this.
  void begin(OwnerKey owner, double now, const Wrench& mean = {}, double carried = 0.0);
  /// It is not asleep any more.
  void end(OwnerKey owner);
  /// Its frozen contacts are others than before. Nothing for who does not sleep.
  void noteChange(OwnerKey owner);
  /// Sums up the frozen contacts of those that were noted.
  void update(const FrozenContacts& frozen);

  /// Takes what awake owners put on sleepers from the contacts that were evaluated last. Returns the
  /// sleepers, in order, whose mean net force or torque is beyond this fraction of what they carry, the
  /// present one where no awake owner touches them: of those that awake owners touch now or touched at the
  /// last call, or that were noted before the last update. now: s; memory: time over which the mean is taken,
  /// s.
  const std::vector<OwnerKey>& findUnbalanced(const Evaluation& evaluation, double fraction, double now,
                                              double memory);
  /// Of those that the last call returned: whether somebody is to be woken at once, since it is out of
  /// balance twice as far, or nobody awake touches it, so that its mean will not fade.
  bool isUrgent() const { return isUrgent_; }
  /// Mean net force and torque on it at the last call of findUnbalanced. memory: as there.
  Wrench heldBy(OwnerKey owner, double memory) const;
  /// Mean of what it carried when it was looked at last, N; 0: not known.
  double carriedBy(OwnerKey owner) const {
    return sleepers_[static_cast<int>(owner.kind)][owner.index].held.carried;
  }
  /// On all sleepers at the last call, N.
  Vector3 netForce() const {
    return Vector3(frozenNet_[0].value(), frozenNet_[1].value(), frozenNet_[2].value()) + awakeNet_;
  }
  /// Of all sleepers in gravity, as Energy::potential, J.
  double potential() const { return potential_.value(); }

 private:
  struct Sleeper {
    Vector3 force = Vector3::Zero(), torque = Vector3::Zero();            // of frozen contacts and gravity,
    Vector3 awakeForce = Vector3::Zero(), awakeTorque = Vector3::Zero();  // of awake owners; N, N m
    double carried = 0.0, awakeCarried = 0.0;  // sums of the sizes of contact forces, N
    Held held;
    Vector3 counted = Vector3::Zero();  // what of it is in frozenNet_, N
    double potential = 0.0;             // the same of potential_, J
    bool isAsleep = false, isTouched = false, isOld = false;
  };
  Sleeper* find(OwnerKey owner);
  void takeAwake(const Evaluation& evaluation);
  bool isLost(OwnerKey owner, Sleeper& sleeper, double fraction, double now, double memory);
  void sum(OwnerKey owner, Sleeper& sleeper, const FrozenContacts& frozen);
  void count(Sleeper& sleeper, const Vector3& net, double potential);

  TraitsOfSleeper traitsOf_;
  std::array<std::vector<Sleeper>, 2> sleepers_;  // by kind and index
  std::vector<OwnerKey> old_, touched_, lookAt_, lookedAt_, unbalanced_;
  std::array<RunningSum, 3> frozenNet_;
  RunningSum potential_;
  Vector3 awakeNet_ = Vector3::Zero();
  double lastLook_ = 0.0;  // s
  bool isUrgent_ = false;
};

}  // namespace granular::detail
