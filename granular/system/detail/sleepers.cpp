// SPDX-License-Identifier: MIT
#include "granular/system/detail/sleepers.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace granular::detail {
namespace {

// Over the fraction at which a sleeper is to wake: it is not kept waiting for others beyond this.
constexpr double kUrgentImbalance = 2.0;

/// The sleeper's number, or -1 for another owner.
std::int32_t sleeperOf(const Layout& layout, std::int32_t owner) {
  return owner >= layout.firstSleeper ? owner - layout.firstSleeper : -1;
}

Vector3 netForceOn(const Owner& owner, const SleeperLoad& load) {
  return owner.body->linearFactor.cwiseProduct(load.force + load.awakeForce) + load.hostLoad.force;
}
Vector3 netTorqueOn(const Owner& owner, const SleeperLoad& load) {
  return owner.body->angularFactor.cwiseProduct(load.torque + load.awakeTorque) + load.hostLoad.torque;
}

/// By how much a mean over `memory` seconds goes towards what has been for `passed` seconds.
double shareOf(double passed, double memory) {
  return passed > 0.0 ? -std::expm1(-passed / memory) : 0.0;
}

void relax(Wrench& mean, const Wrench& net, double share) {
  mean.force += share * (net.force - mean.force);
  mean.torque += share * (net.torque - mean.torque);
}

}  // namespace

void SleeperLoads::reset(const Evaluation& evaluation, std::span<const FrozenContact> frozen,
                         std::span<const std::pair<std::int32_t, std::int32_t>> endsOfFrozen,
                         std::span<const Vector3> weights, std::span<const Wrench> hostLoads) {
  const Layout& layout = evaluation.layout();
  loads_.assign(layout.sleeperCount(), SleeperLoad{});
  for (std::size_t s = 0; s < loads_.size(); ++s) {
    loads_[s].force = weights[s];
    loads_[s].hostLoad = hostLoads[s];
  }
  for (std::size_t n = 0; n < frozen.size(); ++n) {
    const FrozenContact& contact = frozen[n];
    const std::int32_t owners[2] = {endsOfFrozen[n].first, endsOfFrozen[n].second};
    for (int side = 0; side < 2; ++side) {
      const std::int32_t s = sleeperOf(layout, owners[side]);
      if (s < 0) continue;
      const Vector3 force = side == 0 ? contact.force : Vector3(-contact.force);
      loads_[s].force += force;
      loads_[s].torque += (contact.point - evaluation.center(owners[side])).cross(force);
      loads_[s].carried += force.norm();
    }
  }
  frozenNet_ = awakeNet_ = Vector3::Zero();
  for (std::size_t s = 0; s < loads_.size(); ++s) {
    frozenNet_ += netForceOn(layout.owners[layout.firstSleeper + s], loads_[s]);
  }
  touched_.clear();
  lookAt_.resize(loads_.size());
  std::iota(lookAt_.begin(), lookAt_.end(), 0);
}

/// Leaves in touched_ whom awake owners touch, in the order of the contacts. Returns the sum of the forces.
Vector3 SleeperLoads::takeAwake(const Evaluation& evaluation) {
  const Layout& layout = evaluation.layout();
  for (const std::int32_t s : touched_) {
    SleeperLoad& load = loads_[s];
    load.awakeForce = load.awakeTorque = Vector3::Zero();
    load.awakeCarried = 0.0;
    load.wasTouched = false;
  }
  touched_.clear();
  Vector3 sum = Vector3::Zero();
  evaluation.forEachContact([&](const Contact& contact, const ContactForce& f) {
    const std::int32_t owner = layout.ownerOfSlot[contact.slot2];
    const std::int32_t s = sleeperOf(layout, owner);
    if (s < 0) return;
    SleeperLoad& load = loads_[s];
    if (!load.wasTouched) touched_.push_back(s);
    load.wasTouched = true;
    load.awakeForce -= f.force;
    load.awakeTorque -= (f.point - evaluation.center(owner)).cross(f.force);
    load.awakeCarried += f.force.norm();
    sum -= layout.owners[owner].body->linearFactor.cwiseProduct(f.force);
  });
  return sum;
}

Held& SleeperLoads::recordOf(OwnerKind kind, std::int32_t index) {
  std::vector<Held>& all = kind == OwnerKind::Grain ? ofGrain_ : ofBody_;
  if (all.size() <= static_cast<std::size_t>(index)) all.resize(index + 1);
  return all[index];
}

void SleeperLoads::begin(OwnerKind kind, std::int32_t index, double now, const Wrench& mean) {
  recordOf(kind, index) = {.mean = mean, .last = {}, .carried = 0.0, .time = now};
}

Wrench SleeperLoads::heldBy(OwnerKind kind, std::int32_t index, double memory) const {
  const std::vector<Held>& all = kind == OwnerKind::Grain ? ofGrain_ : ofBody_;
  if (all.size() <= static_cast<std::size_t>(index)) return {};
  Wrench mean = all[index].mean;
  relax(mean, all[index].last, shareOf(lastLook_ - all[index].time, memory));
  return mean;
}

const std::vector<std::int32_t>& SleeperLoads::findUnbalanced(const Evaluation& evaluation, double fraction,
                                                              double now, double memory) {
  const Layout& layout = evaluation.layout();
  unbalanced_.clear();
  isUrgent_ = false;
  awakeNet_ = takeAwake(evaluation);
  lookAt_.insert(lookAt_.end(), touched_.begin(), touched_.end());
  std::sort(lookAt_.begin(), lookAt_.end());
  lookAt_.erase(std::unique(lookAt_.begin(), lookAt_.end()), lookAt_.end());
  lookedAt_.swap(lookAt_);
  lookAt_ = touched_;
  for (const std::int32_t s : lookedAt_) {
    const std::int32_t o = layout.firstSleeper + s;
    const Owner& owner = layout.owners[o];
    const SleeperLoad& load = loads_[s];
    const Wrench net{.force = netForceOn(owner, load), .torque = netTorqueOn(owner, load)};
    const double carried = load.carried + load.awakeCarried;
    Held& held = recordOf(owner.kind, owner.index);
    // Before the last look at anybody its forces stayed as they had been when it was looked at.
    relax(held.mean, held.last, shareOf(lastLook_ - held.time, memory));
    const double share = shareOf(now - std::max(lastLook_, held.time), memory);
    relax(held.mean, net, share);
    held.carried = held.carried > 0.0 ? held.carried + share * (carried - held.carried) : carried;
    held.last = net;
    held.time = now;
    // What nobody awake touches is out of balance for good.
    const Wrench& felt = load.wasTouched ? held.mean : net;
    if (!isUnbalanced(owner, felt.force, felt.torque, held.carried, fraction)) continue;
    unbalanced_.push_back(o);
    isUrgent_ |= !load.wasTouched ||
                 isUnbalanced(owner, felt.force, felt.torque, held.carried, kUrgentImbalance * fraction);
  }
  lastLook_ = now;
  return unbalanced_;
}

}  // namespace granular::detail
