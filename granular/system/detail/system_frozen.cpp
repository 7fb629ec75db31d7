// SPDX-License-Identifier: MIT
// What is kept of sleepers while they stand still: contacts among them, frozen with their forces and
// memories, sums over these, and all of it for files.
#include <algorithm>
#include <tuple>
#include <utility>

#include "granular/base/require.h"
#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

namespace state = detail::state;

}  // namespace

bool GranularSystem::Impl::exists(OwnerKind kind, std::int32_t index) const {
  const std::size_t known = kind == OwnerKind::Grain ? grains.size() : bodies.size();
  if (index < 0 || static_cast<std::size_t>(index) >= known) return false;
  return kind == OwnerKind::Grain ? grains[index].alive : bodies[index].alive;
}

bool GranularSystem::Impl::exists(const RememberedContact& c) const {
  return exists(c.kind[0], c.index[0]) && exists(c.kind[1], c.index[1]);
}

/// Those of contacts that are not frozen.
std::vector<RememberedContact> GranularSystem::Impl::amongAwake(std::vector<RememberedContact> memory) const {
  std::erase_if(memory, [&](const RememberedContact& c) {
    return !exists(c) || (!isAwake(c.kind[0], c.index[0]) && !isAwake(c.kind[1], c.index[1]));
  });
  return memory;
}

/// What the next layout's contacts remember. Frozen contacts of what has woken are among them, and frozen no
/// longer; those of owners that are gone are forgotten.
std::vector<RememberedContact> GranularSystem::Impl::memoryOfAwake() {
  std::vector<RememberedContact> memory = evaluation.exportMemory(y);
  if (frozen.empty()) return memory;
  memory = amongAwake(std::move(memory));
  std::erase_if(frozen, [&](const FrozenContact& contact) {
    const RememberedContact& c = contact.memory;
    const bool isThere = exists(c);
    if (isThere && !isAwake(c.kind[0], c.index[0]) && !isAwake(c.kind[1], c.index[1])) return false;
    if (isThere && contact.remembers) memory.push_back(c);
    return true;
  });
  return memory;
}

void GranularSystem::Impl::loadSleepers() {
  const detail::Layout& layout = evaluation.layout();
  std::vector<Pose>& asleep = evaluation.surroundings().asleep;
  asleep.clear();
  for (std::int32_t o = layout.firstSleeper; o < static_cast<std::int32_t>(layout.owners.size()); ++o) {
    const detail::Owner& owner = layout.owners[o];
    const bool isGrain = owner.kind == OwnerKind::Grain;
    asleep.push_back(isGrain ? grainMotions[owner.index].pose : bodies[owner.index].motion.pose);
  }
}

/// Everything about sleepers that stays until somebody wakes or falls asleep.
void GranularSystem::Impl::sumFrozen() {
  const detail::Layout& layout = evaluation.layout();
  frozenTotals = {};
  frozenEnds.clear();
  frozenWrenches.assign(bodies.size(), Wrench{});
  for (const FrozenContact& contact : frozen) {
    const RememberedContact& c = contact.memory;
    std::int32_t owners[2];
    for (int side = 0; side < 2; ++side) {
      const bool isBody = c.kind[side] == OwnerKind::Body;
      owners[side] = (isBody ? ownerOfBody : ownerOfGrain)[c.index[side]];
      if (!isBody) continue;
      const Vector3 force = side == 0 ? contact.force : Vector3(-contact.force);
      Wrench& wrench = frozenWrenches[c.index[side]];
      wrench.force += force;
      wrench.torque += (contact.point - bodies[c.index[side]].motion.pose.position).cross(force);
    }
    frozenEnds.push_back({owners[0], owners[1]});
    frozenTotals.elastic += contact.normalEnergy + memoryEnergy(c.stiffness, c.displacement);
    frozenTotals.overlapSum += contact.relativeOverlap;
    frozenTotals.largestOverlap = std::max(frozenTotals.largestOverlap, contact.relativeOverlap);
  }
  std::vector<Vector3> weights;
  std::vector<Wrench> loads;
  for (std::int32_t o = layout.firstSleeper; o < static_cast<std::int32_t>(layout.owners.size()); ++o) {
    const detail::Owner& owner = layout.owners[o];
    const bool isGrain = owner.kind == OwnerKind::Grain;
    const Vector3 pull = isGrain ? gravity : bodies[owner.index].gravity.value_or(gravity);
    const double mass = isGrain ? grains[owner.index].mass : bodies[owner.index].mass;
    weights.push_back(mass * pull);
    loads.push_back(isGrain ? Wrench{} : bodies[owner.index].load);
    frozenTotals.potential -= mass * owner.body->linearFactor.cwiseProduct(pull).dot(evaluation.center(o));
  }
  sleeperLoads.reset(evaluation, frozen, frozenEnds, weights, loads);
}

/// The quiet ones stand still from now on, and contacts among what stands still stay as they are. What was
/// left of their motion has become heat.
void GranularSystem::Impl::freeze(const std::vector<char>& quiet) {
  const detail::Layout& layout = evaluation.layout();
  const auto isStill = [&](std::int32_t o) { return o < layout.dynamicCount() ? quiet[o] : !movesUnfelt(o); };
  evaluation.forEachContact([&](const detail::Contact& contact, const detail::ContactForce& f) {
    if (!isStill(layout.ownerOfSlot[contact.slot1]) || !isStill(layout.ownerOfSlot[contact.slot2])) return;
    FrozenContact& still = frozen.emplace_back();
    still.remembers = evaluation.describe(contact, y, still.memory);
    still.force = f.force;
    still.point = f.point;
    still.overlap = f.overlap;
    still.relativeOverlap = evaluation.relativeOverlap(contact, f.overlap);
    still.normalEnergy = evaluation.elasticEnergy(contact, f);
  });
  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) {
    if (!quiet[o]) continue;
    const detail::Owner& owner = layout.owners[o];
    const auto own = layout.numbersOf(o, y.data());
    auto velocity = own.velocity(), angularMomentum = own.angularMomentum();
    const Vector3 momentum = velocity / owner.inverseMass;
    heat += 0.5 * momentum.dot(velocity) + 0.5 * readOwner(o).angularVelocity.dot(angularMomentum);
    heldImpulse += momentum;
    velocity.setZero();
    angularMomentum.setZero();
    (owner.kind == OwnerKind::Grain ? grains[owner.index].asleep : bodies[owner.index].asleep) = true;
    sleeperLoads.begin(owner.kind, owner.index, clock);
    ++fellAsleep;
  }
}

/// Impulses of frozen contacts over dt: what a sleeping body is carried with, and on kinematic bodies.
void GranularSystem::Impl::storeSleepers(double dt) {
  const detail::Layout& layout = evaluation.layout();
  const std::int32_t firstBody = layout.firstSleeper + layout.sleepingGrains;
  for (std::int32_t o = firstBody; o < static_cast<std::int32_t>(layout.owners.size()); ++o) {
    detail::BodyRecord& record = bodies[layout.owners[o].index];
    const Vector3 weight = record.mass * record.gravity.value_or(gravity);
    record.impulse.force -= dt * (record.linearFactor.cwiseProduct(weight) + record.load.force);
    record.impulse.torque -= dt * record.load.torque;
  }
  if (frozen.empty()) return;
  for (std::int32_t o = layout.dynamicCount(); o < layout.movingCount(); ++o) {
    const std::int32_t b = layout.owners[o].index;
    bodies[b].impulse.force += dt * frozenWrenches[b].force;
    bodies[b].impulse.torque += dt * frozenWrenches[b].torque;
  }
}

/// Puts frozen contacts among those that were evaluated, each seen from the owner that it is seen from when
/// all are awake, in the order that they then have.
void GranularSystem::Impl::addFrozen(std::vector<ContactView>& contacts) const {
  for (const FrozenContact& still : frozen) {
    ContactView view{.point = still.point, .force = still.force, .overlap = still.overlap};
    for (int side = 0; side < 2; ++side) {
      view.ownerKind[side] = still.memory.kind[side];
      view.ownerIndex[side] = still.memory.index[side];
      view.particle[side] = still.memory.local[side];
    }
    contacts.push_back(view);
  }
  const auto place = [&](const ContactView& view, int side) {
    const bool isGrain = view.ownerKind[side] == OwnerKind::Grain;
    const BodyMotion type = isGrain ? BodyMotion::Dynamic : bodies[view.ownerIndex[side]].motionType;
    const int held = type == BodyMotion::Dynamic ? 0 : type == BodyMotion::Kinematic ? 1 : 2;
    const bool isSurface = view.particle[side] < 0;
    return std::tuple(isSurface, held, !isGrain, view.ownerIndex[side], view.particle[side]);
  };
  for (ContactView& view : contacts) {
    if (place(view, 0) < place(view, 1)) continue;
    std::swap(view.ownerKind[0], view.ownerKind[1]);
    std::swap(view.ownerIndex[0], view.ownerIndex[1]);
    std::swap(view.particle[0], view.particle[1]);
    view.force = -view.force;
  }
  std::sort(contacts.begin(), contacts.end(), [&](const ContactView& a, const ContactView& b) {
    return std::pair(place(a, 0), place(a, 1)) < std::pair(place(b, 0), place(b, 1));
  });
}

/// As GranularSystem::setSleepState. All stands where it stood when the state was read, also what the host
/// has just put there.
void GranularSystem::Impl::putToSleep(const SleepState& kept) {
  wakeAll();
  frozen.clear();
  layoutIsOld = true;
  if (!sleep.enabled) return;
  placedBodies.clear();
  restOfGrain.resize(grains.size(), detail::Rest{clock, {}});
  restOfBody.resize(bodies.size(), detail::Rest{clock, {}});
  guardedFrom.assign(bodies.size(), std::nullopt);
  for (const SleepState::Sleeper& sleeper : kept.sleepers) {
    if (!exists(sleeper.kind, sleeper.index) || !isAwake(sleeper.kind, sleeper.index)) continue;
    const bool isGrain = sleeper.kind == OwnerKind::Grain;
    (isGrain ? grains[sleeper.index].asleep : bodies[sleeper.index].asleep) = true;
    sleeperLoads.begin(sleeper.kind, sleeper.index, clock, sleeper.held);
  }
  for (const FrozenContact& contact : kept.frozen) {
    if (exists(contact.memory)) frozen.push_back(contact);
  }
}

SleepState GranularSystem::sleepState() const {
  const Impl& s = *impl_;
  SleepState kept{.sleepers = {}, .frozen = s.frozen};
  const auto add = [&](OwnerKind kind, std::int32_t index) {
    kept.sleepers.push_back({kind, index, s.sleeperLoads.heldBy(kind, index, s.sleep.restTime)});
  };
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(s.grains.size()); ++g) {
    if (s.grains[g].alive && s.grains[g].asleep) add(OwnerKind::Grain, g);
  }
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(s.bodies.size()); ++b) {
    if (s.bodies[b].alive && s.bodies[b].asleep) add(OwnerKind::Body, b);
  }
  return kept;
}

void GranularSystem::setSleepState(const SleepState& kept) {
  for (const SleepState::Sleeper& sleeper : kept.sleepers) {
    requireFinite(sleeper.held.force, "SleepState.sleepers.held.force", "N");
    requireFinite(sleeper.held.torque, "SleepState.sleepers.held.torque", "N m");
  }
  for (const FrozenContact& contact : kept.frozen) {
    requireFinite(contact.force, "SleepState.frozen.force", "N");
    requireFinite(contact.point, "SleepState.frozen.point", "m");
    requireFinite(contact.memory.displacement, "SleepState.frozen.memory.displacement", "m");
  }
  impl_->putToSleep(kept);
}

}  // namespace granular
