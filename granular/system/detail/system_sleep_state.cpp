// SPDX-License-Identifier: MIT
// Who sleeps and who is about to, for files: out of a system, and back into one like it.
#include <algorithm>
#include <optional>

#include "granular/base/require.h"
#include "granular/system/detail/system_impl.h"

namespace granular {

/// As GranularSystem::setSleepState. All stands where it stood when the state was read, also what the host
/// has just put there.
void GranularSystem::Impl::putToSleep(const SleepState& kept) {
  wakeAll();
  thawed.clear();
  everythingChanged();
  if (!sleep.enabled) return;
  clock = time;
  nextInspection = clock + kept.untilLook;
  nextWaking = clock + kept.untilWaking;
  placedBodies.clear();
  restOfGrain.resize(grains.size(), detail::Rest{clock, {}});
  restOfBody.resize(bodies.size(), detail::Rest{clock, {}});
  for (const SleepState::Rester& rester : kept.resters) {
    if (!exists(rester.kind, rester.index)) continue;
    const bool isGrain = rester.kind == OwnerKind::Grain;
    (isGrain ? restOfGrain : restOfBody)[rester.index] = {clock - rester.seconds, rester.pose};
  }
  guardedFrom.assign(bodies.size(), std::nullopt);
  std::vector<detail::SleeperGrid::Grain> nowAsleep;
  for (const SleepState::Sleeper& sleeper : kept.sleepers) {
    if (!exists(sleeper.kind, sleeper.index) || !isAwake(sleeper.kind, sleeper.index)) continue;
    const detail::OwnerKey owner{sleeper.kind, sleeper.index};
    const bool isGrain = sleeper.kind == OwnerKind::Grain;
    (isGrain ? grains[sleeper.index].asleep : bodies[sleeper.index].asleep) = true;
    sleepers.begin(owner, clock, sleeper.held, sleeper.carried);
    const detail::SleeperTraits traits = traitsOf(owner);
    if (isGrain) nowAsleep.push_back({sleeper.index, traits.center, traits.reach});
  }
  sleepingGrains.insert(nowAsleep);
  for (const FrozenContact& contact : kept.frozen) {
    const RememberedContact& c = contact.memory;
    if (!exists(c)) continue;
    if (!isAwake(c.kind[0], c.index[0]) && !isAwake(c.kind[1], c.index[1])) {
      frozen.add(contact);
    } else if (contact.remembers) {
      thawed.push_back(c);
    }
  }
}

SleepState GranularSystem::sleepState() const {
  const Impl& s = *impl_;
  SleepState kept;
  kept.frozen = s.frozen.all();
  kept.untilLook = std::max(0.0, s.nextInspection - s.clock);
  kept.untilWaking = std::max(0.0, s.nextWaking - s.clock);
  const auto add = [&](OwnerKind kind, std::int32_t index) {
    const detail::OwnerKey owner{kind, index};
    const std::vector<detail::Rest>& rests = kind == OwnerKind::Grain ? s.restOfGrain : s.restOfBody;
    if (s.isAsleep(owner)) {
      kept.sleepers.push_back(
          {kind, index, s.sleepers.heldBy(owner, s.sleep.restTime), s.sleepers.carriedBy(owner)});
    } else if (index < std::ssize(rests) && s.isAwake(kind, index)) {
      kept.resters.push_back({kind, index, s.clock - rests[index].since, rests[index].pose});
    }
  };
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(s.grains.size()); ++g) {
    if (s.grains[g].alive) add(OwnerKind::Grain, g);
  }
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(s.bodies.size()); ++b) {
    if (s.bodies[b].alive) add(OwnerKind::Body, b);
  }
  return kept;
}

void GranularSystem::setSleepState(const SleepState& kept) {
  for (const SleepState::Sleeper& sleeper : kept.sleepers) {
    requireFinite(sleeper.held.force, "SleepState.sleepers.held.force", "N");
    requireFinite(sleeper.held.torque, "SleepState.sleepers.held.torque", "N m");
    requireNotNegative(sleeper.carried, "SleepState.sleepers.carried", "N");
  }
  for (const SleepState::Rester& rester : kept.resters) {
    requireNotNegative(rester.seconds, "SleepState.resters.seconds", "s");
    requireFinite(rester.pose.position, "SleepState.resters.pose.position", "m");
    requireRotation(rester.pose.orientation, "SleepState.resters.pose.orientation");
  }
  requireNotNegative(kept.untilLook, "SleepState.untilLook", "s");
  requireNotNegative(kept.untilWaking, "SleepState.untilWaking", "s");
  for (const FrozenContact& contact : kept.frozen) {
    requireFinite(contact.force, "SleepState.frozen.force", "N");
    requireFinite(contact.point, "SleepState.frozen.point", "m");
    requireFinite(contact.memory.displacement, "SleepState.frozen.memory.displacement", "m");
  }
  impl_->putToSleep(kept);
}

}  // namespace granular
