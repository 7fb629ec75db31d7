// SPDX-License-Identifier: MIT
// What is kept of sleepers while they stand still: contacts among them, frozen with their forces and
// memories. For files: system_sleep_state.cpp.
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

/// What the next layout's contacts remember. Those of owners that are gone are forgotten.
std::vector<RememberedContact> GranularSystem::Impl::memoryOfAwake() {
  std::vector<RememberedContact> memory = evaluation.exportMemory(y);
  memory.insert(memory.end(), thawed.begin(), thawed.end());
  thawed.clear();
  return frozen.empty() ? memory : amongAwake(std::move(memory));
}

bool GranularSystem::Impl::isAsleep(detail::OwnerKey owner) const {
  return owner.kind == OwnerKind::Grain ? grains[owner.index].asleep : bodies[owner.index].asleep;
}

/// Contacts of one that has woken are frozen no longer; what they remember is kept.
void GranularSystem::Impl::thaw(detail::OwnerKey owner) {
  for (const FrozenContact& contact : frozen.takeOut(owner)) {
    const RememberedContact& c = contact.memory;
    for (int side = 0; side < 2; ++side) sleepers.noteChange({c.kind[side], c.index[side]});
    if (contact.remembers) thawed.push_back(c);
  }
}

/// One that is removed leaves no contacts.
void GranularSystem::Impl::removeSleeper(detail::OwnerKey owner) {
  if (!isAsleep(owner)) return;
  sleepers.end(owner);
  for (const FrozenContact& contact : frozen.takeOut(owner)) {
    for (int side = 0; side < 2; ++side) {
      sleepers.noteChange({contact.memory.kind[side], contact.memory.index[side]});
    }
  }
  if (owner.kind == OwnerKind::Grain) sleepingGrains.remove(owner.index);
}

detail::SleeperTraits GranularSystem::Impl::traitsOf(detail::OwnerKey owner) const {
  detail::SleeperTraits traits;
  if (owner.kind == OwnerKind::Grain) {
    const detail::GrainRecord& record = grains[owner.index];
    traits.center = grainMotions[owner.index].pose.position;
    traits.weight = record.mass * gravity;
    traits.reach = record.scale * shapes[record.shape.index].boundingRadius;
    return traits;
  }
  const detail::BodyRecord& record = bodies[owner.index];
  traits.center = record.motion.pose.position;
  traits.weight = record.mass * record.gravity.value_or(gravity);
  traits.hostLoad = record.load;
  traits.linearFactor = record.linearFactor;
  traits.angularFactor = record.angularFactor;
  traits.reach = record.reach;
  return traits;
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

/// The quiet ones stand still from now on, and contacts among what stands still stay as they are. What was
/// left of their motion has become heat.
void GranularSystem::Impl::freeze(const std::vector<char>& quiet) {
  const detail::Layout& layout = evaluation.layout();
  const auto isStill = [&](std::int32_t o) { return o < layout.dynamicCount() ? quiet[o] : !movesUnfelt(o); };
  evaluation.forEachContact([&](const detail::Contact& contact, const detail::ContactForce& f) {
    if (!isStill(layout.ownerOfSlot[contact.slot1]) || !isStill(layout.ownerOfSlot[contact.slot2])) return;
    FrozenContact still;
    still.remembers = evaluation.describe(contact, y, still.memory);
    still.force = f.force;
    still.point = evaluation.pointOf(contact, f);
    still.overlap = f.overlap;
    still.relativeOverlap = evaluation.relativeOverlap(contact, f.overlap);
    still.normalEnergy = evaluation.elasticEnergy(contact, f);
    frozen.add(still);
    for (int side = 0; side < 2; ++side) {
      sleepers.noteChange({still.memory.kind[side], still.memory.index[side]});
    }
  });
  std::vector<detail::SleeperGrid::Grain> nowAsleep;
  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) {
    if (!quiet[o]) continue;
    const detail::Owner& owner = layout.owners[o];
    const bool isGrain = owner.kind == OwnerKind::Grain;
    const auto own = layout.numbersOf(o, y.data());
    auto velocity = own.velocity(), angularMomentum = own.angularMomentum();
    const Vector3 momentum = velocity / owner.inverseMass;
    heat += 0.5 * momentum.dot(velocity) + 0.5 * readOwner(o).angularVelocity.dot(angularMomentum);
    heldImpulse += momentum;
    velocity.setZero();
    angularMomentum.setZero();
    (isGrain ? grains[owner.index].asleep : bodies[owner.index].asleep) = true;
    sleepers.begin({owner.kind, owner.index}, clock);
    if (isGrain) nowAsleep.push_back({owner.index, own.position(), owner.reach});
    ++fellAsleep;
  }
  sleepingGrains.insert(nowAsleep);
}

/// What frozen contacts do to kinematic bodies until somebody wakes or falls asleep.
void GranularSystem::Impl::noteFrozenOnKinematic() {
  const detail::Layout& layout = evaluation.layout();
  frozenOnKinematic.clear();
  for (std::int32_t o = layout.dynamicCount(); o < layout.movingCount(); ++o) {
    const std::int32_t b = layout.owners[o].index;
    frozenOnKinematic.push_back(frozen.wrenchOn(b, bodies[b].motion.pose.position));
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
  for (std::int32_t k = 0; k < layout.kinematicBodies; ++k) {
    Wrench& impulse = bodies[layout.owners[layout.dynamicCount() + k].index].impulse;
    impulse.force += dt * frozenOnKinematic[k].force;
    impulse.torque += dt * frozenOnKinematic[k].torque;
  }
}

/// Puts frozen contacts among those that were evaluated, each seen from the owner that it is seen from when
/// all are awake, in the order that they then have.
void GranularSystem::Impl::addFrozen(std::vector<ContactView>& contacts) const {
  for (const FrozenContact& still : frozen.all()) {
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

}  // namespace granular
