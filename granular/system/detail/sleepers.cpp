// SPDX-License-Identifier: MIT
#include "granular/system/detail/sleepers.h"

#include <algorithm>
#include <cmath>

namespace granular::detail {
namespace {

// Over the fraction at which a sleeper is to wake: it is not kept waiting for others beyond this.
constexpr double kUrgentImbalance = 2.0;

/// By how much a mean over `memory` seconds goes towards what has been for `passed` seconds.
double shareOf(double passed, double memory) {
  return passed > 0.0 ? -std::expm1(-passed / memory) : 0.0;
}

void relax(Wrench& mean, const Wrench& net, double share) {
  mean.force += share * (net.force - mean.force);
  mean.torque += share * (net.torque - mean.torque);
}

}  // namespace

/// None for who does not sleep.
Sleepers::Sleeper* Sleepers::find(OwnerKey owner) {
  std::vector<Sleeper>& all = sleepers_[static_cast<int>(owner.kind)];
  if (owner.index >= std::ssize(all) || !all[owner.index].isAsleep) return nullptr;
  return &all[owner.index];
}

void Sleepers::begin(OwnerKey owner, double now, const Wrench& mean, double carried) {
  std::vector<Sleeper>& all = sleepers_[static_cast<int>(owner.kind)];
  if (owner.index >= std::ssize(all)) all.resize(owner.index + 1);
  all[owner.index] = {.held = {.mean = mean, .last = {}, .carried = carried, .time = now}, .isAsleep = true};
  noteChange(owner);
}

void Sleepers::end(OwnerKey owner) {
  Sleeper* sleeper = find(owner);
  if (sleeper == nullptr) return;
  count(*sleeper, Vector3::Zero(), 0.0);
  sleeper->isAsleep = false;
}

void Sleepers::noteChange(OwnerKey owner) {
  Sleeper* sleeper = find(owner);
  if (sleeper == nullptr || sleeper->isOld) return;
  sleeper->isOld = true;
  old_.push_back(owner);
}

/// Has these in the sums over all sleepers, instead of what was.
void Sleepers::count(Sleeper& sleeper, const Vector3& net, double potential) {
  for (int axis = 0; axis < 3; ++axis) {
    frozenNet_[axis].add(-sleeper.counted[axis]);
    frozenNet_[axis].add(net[axis]);
  }
  potential_.add(-sleeper.potential);
  potential_.add(potential);
  sleeper.counted = net;
  sleeper.potential = potential;
}

void Sleepers::sum(OwnerKey owner, Sleeper& sleeper, const FrozenContacts& frozen) {
  const SleeperTraits traits = traitsOf_(owner);
  sleeper.force = traits.weight;
  sleeper.torque = Vector3::Zero();
  sleeper.carried = 0.0;
  for (const FrozenContacts::Side& at : frozen.of(owner)) {
    sleeper.force += at.force();
    sleeper.torque += (at.contact->point - traits.center).cross(at.force());
    sleeper.carried += at.force().norm();
  }
  sleeper.isOld = false;
  count(sleeper, traits.linearFactor.cwiseProduct(sleeper.force) + traits.hostLoad.force,
        -traits.linearFactor.cwiseProduct(traits.weight).dot(traits.center));
}

void Sleepers::update(const FrozenContacts& frozen) {
  std::sort(old_.begin(), old_.end());
  for (const OwnerKey owner : old_) {
    Sleeper* sleeper = find(owner);
    if (sleeper == nullptr || !sleeper->isOld) continue;
    sum(owner, *sleeper, frozen);
    lookAt_.push_back(owner);
  }
  old_.clear();
}

/// Leaves in touched_ whom awake owners touch, in the order of the contacts, and the sum of the forces.
void Sleepers::takeAwake(const Evaluation& evaluation) {
  for (const OwnerKey owner : touched_) {
    Sleeper* sleeper = find(owner);
    if (sleeper == nullptr) continue;
    sleeper->awakeForce = sleeper->awakeTorque = Vector3::Zero();
    sleeper->awakeCarried = 0.0;
    sleeper->isTouched = false;
  }
  touched_.clear();
  awakeNet_ = Vector3::Zero();
  const Layout& layout = evaluation.layout();
  evaluation.forEachContact([&](const Contact& contact, const ContactForce& f) {
    const std::int32_t o = layout.ownerOfSlot[contact.slot2];
    if (o < layout.firstSleeper) return;
    const Owner& owner = layout.owners[o];
    Sleeper* sleeper = find({owner.kind, owner.index});
    if (sleeper == nullptr) return;  // woken since the last layout
    if (!sleeper->isTouched) touched_.push_back({owner.kind, owner.index});
    sleeper->isTouched = true;
    sleeper->awakeForce -= f.force;
    sleeper->awakeTorque -= f.torque;
    sleeper->awakeCarried += f.force.norm();
    awakeNet_ -= owner.body->linearFactor.cwiseProduct(f.force);
  });
}

/// Brings what it has held up to now. Whether it has lost its balance.
bool Sleepers::isLost(OwnerKey owner, Sleeper& sleeper, double fraction, double now, double memory) {
  const SleeperTraits traits = traitsOf_(owner);
  const Vector3 force = sleeper.force + sleeper.awakeForce, torque = sleeper.torque + sleeper.awakeTorque;
  const Wrench net{.force = traits.linearFactor.cwiseProduct(force) + traits.hostLoad.force,
                   .torque = traits.angularFactor.cwiseProduct(torque) + traits.hostLoad.torque};
  const double carried = sleeper.carried + sleeper.awakeCarried;
  Held& held = sleeper.held;
  // Before the last look at anybody its forces stayed as they had been when it was looked at.
  relax(held.mean, held.last, shareOf(lastLook_ - held.time, memory));
  const double share = shareOf(now - std::max(lastLook_, held.time), memory);
  relax(held.mean, net, share);
  held.carried = held.carried > 0.0 ? held.carried + share * (carried - held.carried) : carried;
  held.last = net;
  held.time = now;
  // What nobody awake touches is out of balance for good.
  const Wrench& felt = sleeper.isTouched ? held.mean : net;
  const auto isBeyond = [&](double part) {
    return isUnbalanced(traits.reach, felt.force, felt.torque, held.carried, part);
  };
  if (!isBeyond(fraction)) return false;
  isUrgent_ |= !sleeper.isTouched || isBeyond(kUrgentImbalance * fraction);
  return true;
}

const std::vector<OwnerKey>& Sleepers::findUnbalanced(const Evaluation& evaluation, double fraction,
                                                      double now, double memory) {
  unbalanced_.clear();
  isUrgent_ = false;
  takeAwake(evaluation);
  lookAt_.insert(lookAt_.end(), touched_.begin(), touched_.end());
  std::sort(lookAt_.begin(), lookAt_.end());
  lookAt_.erase(std::unique(lookAt_.begin(), lookAt_.end()), lookAt_.end());
  lookedAt_.swap(lookAt_);
  lookAt_ = touched_;
  for (const OwnerKey owner : lookedAt_) {
    Sleeper* sleeper = find(owner);
    if (sleeper != nullptr && isLost(owner, *sleeper, fraction, now, memory)) unbalanced_.push_back(owner);
  }
  lastLook_ = now;
  return unbalanced_;
}

Wrench Sleepers::heldBy(OwnerKey owner, double memory) const {
  const Held& held = sleepers_[static_cast<int>(owner.kind)][owner.index].held;
  Wrench mean = held.mean;
  relax(mean, held.last, shareOf(lastLook_ - held.time, memory));
  return mean;
}

}  // namespace granular::detail
