// SPDX-License-Identifier: MIT
// Who falls asleep and who wakes, looked at between sub-steps (sleep.h says when).
//
// Falling asleep: the forces have balanced and nothing has moved for a while, at every look. Contacts among
// what stands still are frozen. Waking: frozen and present forces on a sleeper no longer balance. Something
// that wakes takes its nearest neighbours with it, so that a wave does not make a new layout at every contact
// that it reaches. Contacts in which only a surface could tell (no particle of the awake side is in the
// candidate list) are not left to forces: what comes near a moving body's exact surface, or near a kinematic
// body that moves, is woken before they touch, and stays awake. What is kept of sleepers: system_frozen.cpp.
#include <algorithm>
#include <cmath>
#include <utility>

#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

namespace state = detail::state;

constexpr double kLooksPerRest = 8.0;

// Times are sums of sub-steps: far above what is rounded off, far below what matters. In restTime.
constexpr double kRounding = 1e-9;

// Where a front creeps through a bed, a few more wake in every sub-step, and each time is a new layout. So
// they wait for one another this many times shorter than restTime, unless somebody's need is urgent. A ball
// on a bed of 10,446 made 307 layouts in 0.5 s without.
constexpr double kWakingsPerRest = 32.0;

// How many contacts away from a sleeper that lost its balance others are woken too.
constexpr int kWakeRings = 1;

}  // namespace

bool GranularSystem::Impl::isAwake(OwnerKind kind, std::int32_t index) const {
  if (kind == OwnerKind::Grain) return grains[index].alive && !grains[index].asleep;
  const detail::BodyRecord& record = bodies[index];
  return record.alive && record.motionType == BodyMotion::Dynamic && !record.asleep;
}

void GranularSystem::Impl::wake(OwnerKind kind, std::int32_t index) {
  const bool isGrain = kind == OwnerKind::Grain;
  bool& asleep = isGrain ? grains[index].asleep : bodies[index].asleep;
  if (!asleep) return;
  asleep = false;
  (isGrain ? restOfGrain : restOfBody)[index].since = clock;
  sleepers.end({kind, index});
  thaw({kind, index});
  if (isGrain) {
    sleepingGrains.remove(index);
    awakeGrains.push_back(index);
  }
  layoutIsOld = true;
  ++woken;
}

void GranularSystem::Impl::wakeAll() {
  for (std::size_t g = 0; g < grains.size(); ++g) wake(OwnerKind::Grain, static_cast<std::int32_t>(g));
  for (std::size_t b = 0; b < bodies.size(); ++b) wake(OwnerKind::Body, static_cast<std::int32_t>(b));
}

/// Sleepers that touch this body, which is about to go.
void GranularSystem::Impl::wakeTouching(std::int32_t body) {
  std::vector<detail::OwnerKey> touching;
  for (const auto& at : frozen.of({OwnerKind::Body, body})) touching.push_back(at.other());
  for (const detail::OwnerKey owner : touching) wake(owner.kind, owner.index);
}

/// A static or kinematic body stands where it did not stand before, or meets what it did not meet.
void GranularSystem::Impl::notePlaced(std::int32_t body) {
  if (sleep.enabled) placedBodies.push_back(body);
}

/// Between two sub-steps, the present state just evaluated. Whether the layout has become old by it.
bool GranularSystem::Impl::sleepOrWake(double now) {
  if (!sleep.enabled) return false;
  restOfGrain.resize(grains.size(), detail::Rest{now, {}});
  restOfBody.resize(bodies.size(), detail::Rest{now, {}});
  guardedFrom.resize(bodies.size());
  if (leavesNear()) {
    layoutIsOld = true;
    return true;
  }
  const double passed = now - clock;
  clock = now;
  bool changed = wakeUnbalanced(now, passed);
  changed |= wakeNearMoving();
  if (now >= nextInspection - kRounding * sleep.restTime) {
    nextInspection = now + sleep.restTime / kLooksPerRest;
    changed |= fallAsleep();
  }
  return changed;
}

bool GranularSystem::Impl::wakeUnbalanced(double now, double passed) {
  if (sleepingGrains.size() == 0 && evaluation.layout().sleeperCount() == 0) return false;
  evaluation.listContacts(y);
  const Vector3 netBefore = sleepers.netForce();
  const std::vector<detail::OwnerKey>& lost =
      sleepers.findUnbalanced(evaluation, sleep.wakeImbalance, now, sleep.restTime);
  heldImpulse += 0.5 * passed * (netBefore + sleepers.netForce());
  if (lost.empty() || (now < nextWaking && !sleepers.isUrgent())) return false;
  nextWaking = now + sleep.restTime / kWakingsPerRest;
  std::vector<detail::OwnerKey> wakes = lost;
  for (int ring = 0; ring < kWakeRings; ++ring) {
    const std::vector<detail::OwnerKey> before = wakes;
    for (const detail::OwnerKey owner : before) {
      for (const auto& at : frozen.of(owner)) wakes.push_back(at.other());
    }
    std::sort(wakes.begin(), wakes.end());
    wakes.erase(std::unique(wakes.begin(), wakes.end()), wakes.end());
    std::erase_if(wakes, [&](detail::OwnerKey owner) { return !isAsleep(owner); });
  }
  for (const detail::OwnerKey owner : wakes) wake(owner.kind, owner.index);
  return true;
}

/// Of awake owners: whose forces balance and who has not moved, now and at every look for restTime.
std::vector<char> GranularSystem::Impl::findQuiet() {
  const detail::Layout& layout = evaluation.layout();
  const std::int32_t dynamic = layout.dynamicCount();
  std::vector<char> quiet(dynamic, 1);
  std::vector<double> carried(dynamic, 0.0);
  evaluation.forEachContact([&](const detail::Contact& contact, const detail::ContactForce& f) {
    const std::int32_t owner1 = layout.ownerOfSlot[contact.slot1];
    const std::int32_t owner2 = layout.ownerOfSlot[contact.slot2];
    carried[owner1] += f.force.norm();
    if (owner2 < dynamic) carried[owner2] += f.force.norm();
    if (owner2 >= dynamic && movesUnfelt(owner2)) quiet[owner1] = 0;
  });
  for (std::int32_t o = 0; o < dynamic; ++o) {
    const detail::Owner& owner = layout.owners[o];
    const bool isGrain = owner.kind == OwnerKind::Grain;
    const auto rate = layout.ratesAt(layout.placeOfOwner[o], stepper->firstRate().data(),
                                     lackingOf(stepper->firstRate(), y));
    const Vector3 force = rate.velocity() / owner.inverseMass, torque = rate.angularMomentum();
    const Pose pose = readOwner(o).pose;
    detail::Rest& rest = (isGrain ? restOfGrain : restOfBody)[owner.index];
    const bool rests =
        (isGrain ? grains[owner.index].maySleep : bodies[owner.index].maySleep) && quiet[o] &&
        carried[o] > 0.0 && !detail::isUnbalanced(owner.reach, force, torque, carried[o], sleep.balance) &&
        detail::wayBetween(pose, rest.pose, owner.reach) <= sleep.restWay * layout.smallestRadius;
    if (!rests) rest = {clock, pose};
    quiet[o] = rests && clock - rest.since >= (1.0 - kRounding) * sleep.restTime;
  }
  return quiet;
}

bool GranularSystem::Impl::fallAsleep() {
  evaluation.listContacts(y);
  std::vector<char> quiet = findQuiet();
  if (std::none_of(quiet.begin(), quiet.end(), [](char q) { return q != 0; })) return false;
  keepAwakeNearMoving(quiet);
  if (std::none_of(quiet.begin(), quiet.end(), [](char q) { return q != 0; })) return false;
  freeze(quiet);
  guardedFrom.assign(bodies.size(), std::nullopt);  // new sleepers
  layoutIsOld = true;
  return true;
}

}  // namespace granular
