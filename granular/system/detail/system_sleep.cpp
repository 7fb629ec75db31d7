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
#include <variant>

#include "granular/system/detail/placed_particles.h"
#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

namespace state = detail::state;

constexpr double kLooksPerRest = 8.0;

// Where a front creeps through a bed, a few more wake in every sub-step, and each time is a new layout. So
// they wait for one another this many times shorter than restTime, unless somebody's need is urgent. A ball
// on a bed of 10,446 made 307 layouts in 0.5 s without.
constexpr double kWakingsPerRest = 32.0;

// How many contacts away from a sleeper that lost its balance others are woken too.
constexpr int kWakeRings = 1;

// What moves keeps this distance to sleepers, in smallest radii, where forces could not wake them in time;
// looked at anew whenever it has moved half as far. A sub-step moves nothing farther than a quarter radius.
constexpr double kGuard = 1.0;

double wayBetween(const Pose& a, const Pose& b, double reach) {
  return (a.position - b.position).norm() + a.orientation.angularDistance(b.orientation) * reach;
}

bool isMoving(const RigidMotion& motion) {
  return !(motion.velocity.isZero(0.0) && motion.angularVelocity.isZero(0.0));
}

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
  layoutIsOld = true;
  ++woken;
}

void GranularSystem::Impl::wakeAll() {
  for (std::size_t g = 0; g < grains.size(); ++g) wake(OwnerKind::Grain, static_cast<std::int32_t>(g));
  for (std::size_t b = 0; b < bodies.size(); ++b) wake(OwnerKind::Body, static_cast<std::int32_t>(b));
}

/// Sleepers that touch this body, which is about to go.
void GranularSystem::Impl::wakeTouching(std::int32_t body) {
  for (const FrozenContact& contact : frozen) {
    for (int side = 0; side < 2; ++side) {
      if (contact.memory.kind[side] == OwnerKind::Body && contact.memory.index[side] == body) {
        wake(contact.memory.kind[1 - side], contact.memory.index[1 - side]);
      }
    }
  }
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
  const double passed = now - clock;
  clock = now;
  bool changed = wakeUnbalanced(now, passed);
  changed |= wakeNearMoving();
  if (now >= nextInspection) {
    nextInspection = now + sleep.restTime / kLooksPerRest;
    changed |= fallAsleep();
  }
  return changed;
}

bool GranularSystem::Impl::wakeUnbalanced(double now, double passed) {
  const detail::Layout& layout = evaluation.layout();
  if (layout.sleeperCount() == 0) return false;
  const Vector3 netBefore = sleeperLoads.netForce();
  const std::vector<std::int32_t>& lost =
      sleeperLoads.findUnbalanced(evaluation, sleep.wakeImbalance, now, sleep.restTime);
  heldImpulse += 0.5 * passed * (netBefore + sleeperLoads.netForce());
  if (lost.empty() || (now < nextWaking && !sleeperLoads.isUrgent())) return false;
  nextWaking = now + sleep.restTime / kWakingsPerRest;
  std::vector<char> wakes(layout.owners.size(), 0);
  for (const std::int32_t o : lost) wakes[o] = 1;
  for (int ring = 0; ring < kWakeRings; ++ring) {
    const std::vector<char> before = wakes;
    for (const auto& [a, b] : frozenEnds) {
      if (before[a] && b >= layout.firstSleeper) wakes[b] = 1;
      if (before[b] && a >= layout.firstSleeper) wakes[a] = 1;
    }
  }
  for (std::int32_t o = layout.firstSleeper; o < static_cast<std::int32_t>(wakes.size()); ++o) {
    if (wakes[o]) wake(layout.owners[o].kind, layout.owners[o].index);
  }
  return true;
}

/// Marks in near[o - first] which owners in [first, last) are within the guarded distance of this body's
/// exact surface or, unless it is dynamic, of its particles.
void GranularSystem::Impl::markNear(std::int32_t body, std::int32_t first, std::int32_t last,
                                    std::vector<char>& near) const {
  const detail::Layout& layout = evaluation.layout();
  const detail::Owner& self = layout.owners[body];
  const double margin = kGuard * layout.smallestRadius;
  const auto at = std::find(layout.ownerOfSurface.begin(), layout.ownerOfSurface.end(), body);
  const SurfaceRow* surface = at == layout.ownerOfSurface.end()
                                  ? nullptr
                                  : &evaluation.surfaces()[at - layout.ownerOfSurface.begin()];
  detail::PlacedParticles around(2.0 * layout.largestRadius + margin, margin);
  const bool byParticles = body >= layout.dynamicCount() && !self.particles.empty();
  if (byParticles) {
    for (const ParticleRow& row : evaluation.particlesOf(self)) {
      around.add({Vector3(row.x, row.y, row.z), row.radius});
    }
  }
  for (std::int32_t o = first; o < last; ++o) {
    const detail::Owner& other = layout.owners[o];
    if (o == body || near[o - first] || !layout.rules.mayMeet(body, o)) continue;
    const bool bySurface = surface && layout.rules.surfaceMeets(o, body);
    const double reach = self.reach + other.reach + margin;
    const bool isFar = (evaluation.center(o) - evaluation.center(body)).squaredNorm() > reach * reach;
    const auto rows = evaluation.particlesOf(other);
    near[o - first] = std::any_of(rows.begin(), rows.end(), [&](const ParticleRow& row) {
      const Vector3 p(row.x, row.y, row.z);
      return (bySurface && surface->mayBeWithin(p, row.radius + layout.overhangOf(o) + margin)) ||
             (byParticles && !isFar && !around.isClear({p, row.radius}));
    });
  }
}

/// Wakes what comes near a body that moves and would not feel it in time, and what a body that was put
/// somewhere by hand stands near now.
bool GranularSystem::Impl::wakeNearMoving() {
  const detail::Layout& layout = evaluation.layout();
  const std::int32_t first = layout.firstSleeper, last = static_cast<std::int32_t>(layout.owners.size());
  std::vector<std::int32_t> moved;
  for (const std::int32_t b : placedBodies) {
    if (ownerOfBody[b] >= 0) moved.push_back(ownerOfBody[b]);
  }
  placedBodies.clear();
  if (first == last) return false;
  for (std::int32_t o = layout.dynamicGrains; o < layout.movingCount(); ++o) {
    if (!movesUnfelt(o)) continue;
    const detail::Owner& owner = layout.owners[o];
    const Pose here{evaluation.center(o), Quaternion(evaluation.rotation(o))};
    std::optional<Pose>& guarded = guardedFrom[owner.index];
    const bool isPlane = owner.body->exact && std::holds_alternative<HalfSpace>(*owner.body->exact);
    if (guarded && !isPlane &&
        wayBetween(here, *guarded, owner.reach) <= 0.5 * kGuard * layout.smallestRadius) {
      continue;
    }
    guarded = here;
    moved.push_back(o);
  }
  if (moved.empty()) return false;
  std::vector<char> near(last - first, 0);
  for (const std::int32_t o : moved) markNear(o, first, last, near);
  bool any = false;
  for (std::int32_t o = first; o < last; ++o) {
    if (!near[o - first]) continue;
    wake(layout.owners[o].kind, layout.owners[o].index);
    any = true;
  }
  return any;
}

/// Whether sleepers would not feel this moving owner by contacts with awake particles of its own.
bool GranularSystem::Impl::movesUnfelt(std::int32_t o) const {
  const detail::Layout& layout = evaluation.layout();
  if (o < layout.dynamicGrains || o >= layout.movingCount()) return false;
  if (o < layout.dynamicCount()) return layout.owners[o].body->exact != nullptr;
  return isMoving(evaluation.surroundings().kinematic[o - layout.dynamicCount()]);
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
    const bool rests = (isGrain ? grains[owner.index].maySleep : bodies[owner.index].maySleep) && quiet[o] &&
                       carried[o] > 0.0 && !isUnbalanced(owner, force, torque, carried[o], sleep.balance) &&
                       wayBetween(pose, rest.pose, owner.reach) <= sleep.restWay * layout.smallestRadius;
    if (!rests) rest = {clock, pose};
    quiet[o] = rests && clock - rest.since >= sleep.restTime;
  }
  return quiet;
}

/// Nothing falls asleep near what moves and would not be felt; bodies with exact surfaces that stay awake by
/// it are such themselves.
void GranularSystem::Impl::keepAwakeNearMoving(std::vector<char>& quiet) const {
  const detail::Layout& layout = evaluation.layout();
  const std::int32_t dynamic = layout.dynamicCount();
  std::vector<std::int32_t> moving;
  for (std::int32_t o = layout.dynamicGrains; o < layout.movingCount(); ++o) {
    if (movesUnfelt(o) && (o >= dynamic || !quiet[o])) moving.push_back(o);
  }
  for (std::size_t k = 0; k < moving.size(); ++k) {
    std::vector<char> near(dynamic, 0);
    for (std::int32_t o = 0; o < dynamic; ++o) near[o] = !quiet[o];  // nothing to find out
    markNear(moving[k], 0, dynamic, near);
    for (std::int32_t o = 0; o < dynamic; ++o) {
      if (!quiet[o] || !near[o]) continue;
      quiet[o] = 0;
      if (movesUnfelt(o)) moving.push_back(o);
    }
  }
}

bool GranularSystem::Impl::fallAsleep() {
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
