// SPDX-License-Identifier: MIT
// Who is near sleepers.
//
// A layout holds only those sleeping grains that something awake may touch before it has gone some way; who
// leaves what it was surrounded by makes the next one. So a change of who is awake costs what is awake, not
// what sleeps.
//
// Contacts in which only a surface could tell (no particle of the awake side is in the candidate list) are
// not left to forces: what comes near a moving body's exact surface, or near a kinematic body that moves, is
// woken before they touch, and stays awake.
#include <algorithm>
#include <limits>
#include <utility>
#include <variant>

#include "granular/system/detail/placed_particles.h"
#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

// What moves keeps this distance to sleepers, in smallest radii, where forces could not wake them in time;
// looked at anew whenever it has moved half as far. A sub-step moves nothing farther than a quarter radius.
constexpr double kGuard = 1.0;

// How far something may go until its surroundings are looked for anew: so many of the largest radii, and what
// it goes at its speed in so many times restTime. Half of it is left for one sub-step. Shorter ways leave out
// more, and longer ones make fewer layouts; who wakes and falls asleep makes one several times in restTime.
constexpr double kLeastWay = 1.0, kRestTimes = 2.0;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool isMoving(const RigidMotion& motion) {
  return !(motion.velocity.isZero(0.0) && motion.angularVelocity.isZero(0.0));
}

bool isPlane(const detail::Owner& owner) {
  return owner.body->exact && std::holds_alternative<HalfSpace>(*owner.body->exact);
}

}  // namespace

/// Within which way of this owner, of the layout that is being made, sleepers are looked for.
GranularSystem::Impl::Watch GranularSystem::Impl::watchOf(std::int32_t o, bool isPlaced) const {
  const detail::Owner& owner = evaluation.layout().owners[o];
  const RigidMotion& motion = motionOf(owner);
  Watch watch{motion.pose.position, -1.0};
  if (o >= evaluation.layout().dynamicCount() && !isPlaced && !isMoving(motion)) return watch;
  watch.way = isPlane(owner)
                  ? kInfinity
                  : kLeastWay * largestRadius + kRestTimes * sleep.restTime * motion.velocity.norm();
  return watch;
}

/// The sleeping grains that belong into the layout that is being made and holds all others already, in order.
std::vector<std::int32_t> GranularSystem::Impl::findNearSleepers() {
  const std::vector<detail::Owner>& owners = evaluation.layout().owners;
  std::vector<std::int32_t> near;
  watched.clear();
  sleepingGrains.startSearch();
  layoutHasAll = everythingIsOld || sleepingGrains.size() <= evaluation.layout().dynamicGrains;
  if (layoutHasAll) {
    sleepingGrains.find(Vector3::Zero(), kInfinity, near);
  } else {
    std::vector<char> isPlaced(owners.size(), 0);
    for (const std::int32_t b : placedBodies) {
      if (ownerOfBody[b] >= 0) isPlaced[ownerOfBody[b]] = 1;
    }
    for (std::int32_t o = 0; o < static_cast<std::int32_t>(owners.size()); ++o) {
      const Watch& watch = watched.emplace_back(watchOf(o, isPlaced[o] != 0));
      if (watch.way < 0.0) continue;
      sleepingGrains.find(watch.center, owners[o].reach + kGuard * smallestRadius + watch.way, near);
    }
  }
  std::sort(near.begin(), near.end());
  return near;
}

/// Whether something may soon touch sleepers that are not in the layout.
bool GranularSystem::Impl::leavesNear() const {
  if (layoutHasAll) return false;
  const detail::Layout& layout = evaluation.layout();
  const auto leaves = [&](std::int32_t o) {
    return (evaluation.center(o) - watched[o].center).norm() > 0.5 * watched[o].way;
  };
  for (std::int32_t o = 0; o < layout.movingCount(); ++o) {
    const bool moves =
        o < layout.dynamicCount() || isMoving(evaluation.surroundings().kinematic[o - layout.dynamicCount()]);
    if (moves && leaves(o)) return true;
  }
  return std::any_of(placedBodies.begin(), placedBodies.end(),
                     [&](std::int32_t b) { return ownerOfBody[b] >= 0 && leaves(ownerOfBody[b]); });
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
    if (guarded && !isPlane(owner) &&
        detail::wayBetween(here, *guarded, owner.reach) <= 0.5 * kGuard * layout.smallestRadius) {
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

}  // namespace granular
