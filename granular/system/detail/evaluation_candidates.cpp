// SPDX-License-Identifier: MIT
// The stage that offers pairs: where exact surfaces are, when the candidate list is made anew, and in which
// order particles lie in memory.
#include <algorithm>
#include <cmath>

#include "granular/base/room.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

constexpr std::int32_t kPerPiece = 4096;  // particles or memories, handed to a thread at a time

// List rebuilds between two sortings of the places by cell: grains travel a few radii in that time.
constexpr std::int64_t kRebuildsPerSort = 200;

// Of the mean margin, what everything has at least.
constexpr double kShareAtRest = 0.25;
// Mean margin in smallest radii, and the factor by which it changes from list to list.
constexpr double kNarrowestMargin = 0.05, kWidestMargin = 0.6, kMarginStep = 1.1;
// Largest margin of a fast thing, in smallest radii: about it the list grows with the third power.
constexpr double kLargestMargin = 4.0;
// What a list costs, measured in the test of one candidate: placing and finding a particle, and each distance
// that is worked out for it.
constexpr double kParticleCost = 40.0, kTestCost = 0.6;

}  // namespace

void Evaluation::placeSurface(std::int32_t s) {
  const std::int32_t o = layout_.ownerOfSurface[s];
  const Owner& owner = layout_.owners[o];
  surfaces_[s].shape = owner.body->exact;
  surfaces_[s].boundingRadius = boundingRadius(*owner.body->exact);
  surfaces_[s].point = center(o) + rotationOf(o) * owner.body->exactPose.position;
  surfaces_[s].rotation = rotationOf(o) * owner.body->exactPose.orientation.toRotationMatrix();
}

/// How far any point of the surface near a particle has moved since the list was made, at most, m.
double Evaluation::surfaceMove(std::int32_t s) const {
  const SurfaceRow &now = surfaces_[s], &then = listedSurfaces_[s];
  if (std::isfinite(now.boundingRadius)) {
    return (now.point - then.point).norm() + (now.rotation - then.rotation).norm() * now.boundingRadius;
  }
  const Vector3 normal = now.rotation.col(1), before = then.rotation.col(1);
  return std::abs(normal.dot(now.point) - before.dot(then.point)) + (normal - before).norm() * listedExtent_;
}

void Evaluation::updateCandidates() {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::UpdateCandidates)]);
  if (listIsCurrent_ && !listIsOld_) return;
  adaptMargin();
  rebuildCandidates();
}

/// The cheapest mean margin m is where making lists costs as much as testing the candidates that are only
/// there for it: a list lasts in proportion to m, those candidates are in proportion to m too, and of a / m +
/// b m both parts are equal where the sum is least. Counts decide, not clocks. It changes the speed only,
/// never the result.
void Evaluation::adaptMargin() {
  const auto lasted = static_cast<double>(evaluations - evaluationsAtRebuild_);
  evaluationsAtRebuild_ = evaluations;
  if (!listIsCurrent_) return;  // something else than motion made it old
  const double listCost =
      kParticleCost * layout_.dynamicParticles + kTestCost * static_cast<double>(list_.testCount());
  const auto apart = static_cast<double>(list_.size() - summary_.contacts);
  if (listCost > apart * lasted) {
    margin_ = std::min(kWidestMargin, margin_ * kMarginStep);
  } else {
    margin_ = std::max(kNarrowestMargin, margin_ / kMarginStep);
  }
}

/// A part of the mean margin for everyone, as anything may be hit; the others by speed, so that few fast
/// things do not make the list of all others old.
void Evaluation::chooseMargins() {
  const std::int32_t moving = layout_.movingCount();
  double sum = 0.0;
  for (std::int32_t place = 0; place < moving; ++place) {
    if (const double speed = fastestPoint(place); std::isfinite(speed)) sum += speed;
  }
  const double mean = margin_ * layout_.smallestRadius, atRest = kShareAtRest * mean;
  const double largest = kLargestMargin * layout_.smallestRadius;
  const double time = sum > 0.0 ? (mean - atRest) * moving / sum : 0.0;
  const auto marginAt = [&](double speed) { return std::min(largest, atRest + time * speed); };
  resizeAnew(margins_, layout_.movingParticles);
  executor_.forRanges(moving, kPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (auto place = static_cast<std::int32_t>(begin); place < end; ++place) {
      std::fill(margins_.begin() + layout_.slotOfPlace[place],
                margins_.begin() + layout_.slotOfPlace[place + 1], marginAt(fastestPoint(place)));
    }
  });
  surfaceMargins_.assign(layout_.surfaceCount(), 0.0);
  for (std::int32_t s = 0; s < layout_.surfaceCount(); ++s) {
    const std::int32_t o = layout_.ownerOfSurface[s];
    if (o >= moving) continue;
    const double reach = (surfaces_[s].point - center(o)).norm() + surfaces_[s].boundingRadius;
    const double turning = std::isfinite(reach) ? rowOf(o).angularVelocity.norm() * reach : 0.0;
    surfaceMargins_[s] = marginAt(rowOf(o).velocity.norm() + turning);
  }
}

bool Evaluation::isSortDue() const {
  return rebuildsSinceSort_ > kRebuildsPerSort;
}

std::vector<std::int32_t> Evaluation::sortPlaces(const std::vector<double>& y) {
  rebuildsSinceSort_ = 0;
  listIsCurrent_ = false;
  const std::int32_t dynamic = layout_.dynamicCount();
  const std::vector<std::int32_t> placeBefore = layout_.placeOfOwner, slotBefore = layout_.slotOfPlace;
  layout_.sortPlaces([&](std::int32_t o) { return layout_.numbersOf(o, y.data()).position(); });
  std::vector<std::int32_t> from(dynamic);
  for (std::int32_t place = 0; place < dynamic; ++place) {
    from[place] = placeBefore[layout_.ownerOfPlace[place]];
  }
  const auto reorder = [&](auto& rows) {
    const std::vector before(rows.begin(), rows.begin() + dynamic);
    for (std::int32_t place = 0; place < dynamic; ++place) rows[place] = before[from[place]];
  };
  reorder(owners_);
  reorder(dampingRates_);
  if (!layout_.movesOnlySpheres) reorder(balls_);
  const std::vector before(particles_.begin(), particles_.begin() + layout_.dynamicParticles);
  for (std::int32_t place = 0; place < dynamic; ++place) {
    const std::int32_t slot = layout_.slotOfPlace[place], end = layout_.slotOfPlace[place + 1];
    std::copy_n(before.begin() + slotBefore[from[place]], end - slot, particles_.begin() + slot);
  }
  list_.reset();
  layBlocks();
  return from;
}

void Evaluation::rebuildCandidates() {
  ++listRebuilds;
  ++rebuildsSinceSort_;
  chooseMargins();
  const SearchInput input{.particles = particles_,
                          .surfaces = surfaces_,
                          .owner = layout_.ownerOfSlot,
                          .rank = layout_.rankOfSlot,
                          .dynamicCount = layout_.dynamicParticles,
                          .movingCount = layout_.movingParticles,
                          .rules = &layout_.rules,
                          .overhang = layout_.overhang,
                          .margin = margins_,
                          .surfaceMargin = surfaceMargins_,
                          .findNear = kernels_->findNear};
  list_.rebuild(input, executor_);
  blocks_.rebuild(list_,
                  {.rank = layout_.rankOfSlot,
                   .patchOfSlot = layout_.patchOfSlot,
                   .blockOfPatch = blockOfPatch_,
                   .firstSlot = firstSlotOfBlock_,
                   .wantsIndices = hasMemory_},
                  executor_);
  lawRowsAreCurrent_ = false;
  rememberList();
}

/// What the list was made for, and which of its candidates have a memory.
void Evaluation::rememberList() {
  resizeAnew(listedParticles_, layout_.movingParticles);
  executor_.forRanges(layout_.movingParticles, kPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t slot = begin; slot < end; ++slot) {
      const ParticleRow& row = particles_[slot];
      listedParticles_[slot] = {row.x, row.y, row.z, margins_[slot] * margins_[slot]};
    }
  });
  listedSurfaces_ = surfaces_;
  listIsCurrent_ = true;
  listedExtent_ = 0.0;
  const auto moves = [&](std::int32_t o) { return o < layout_.movingCount(); };
  if (std::any_of(layout_.ownerOfSurface.begin(), layout_.ownerOfSurface.end(), moves)) {
    for (const ListedRow& row : listedParticles_) {
      listedExtent_ = std::max(listedExtent_, Vector3(row.x, row.y, row.z).norm());
    }
  }
  if (!hasMemory_) return;
  resizeAnew(memoryOfCandidate_, list_.size());
  std::fill(memoryOfCandidate_.begin(), memoryOfCandidate_.end(), -1);
  executor_.forRanges(std::ssize(memory_), kPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (auto m = static_cast<std::int32_t>(begin); m < end; ++m) rememberEntry(m);
  });
}

/// Where entry m of the memory is found from now on. A contact that is no longer even near has ended;
/// settleMemory drops it.
void Evaluation::rememberEntry(std::int32_t m) {
  const std::int32_t slot = layout_.slotOfRank[memory_[m].rank1];
  const auto all = list_.partner().begin();
  const auto begin = all + list_.rowStart()[slot], end = all + list_.rowStart()[slot + 1];
  const auto found = std::lower_bound(
      begin, end, memory_[m].rank2,
      [&](std::int32_t partner, std::int32_t rank) { return layout_.rankOfSlot[partner] < rank; });
  if (found != end && layout_.rankOfSlot[*found] == memory_[m].rank2) memoryOfCandidate_[found - all] = m;
}

}  // namespace granular::detail
