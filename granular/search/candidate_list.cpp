// SPDX-License-Identifier: MIT
#include "granular/search/candidate_list.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "granular/base/room.h"

namespace granular {
namespace {

// Large enough that handing out pieces costs nothing.
constexpr std::int32_t kVoxelsPerPiece = 256;

std::int64_t sizeOf(const std::vector<SpatialHash::Run>& runs) {
  std::int64_t size = 0;
  for (const SpatialHash::Run& run : runs) size += run.end - run.begin;
  return size;
}

/// Whether surface s, wherever it moves, may come nearer than `reach` to p.
bool isNear(const SearchInput& input, std::int32_t s, const Vector3& p, double reach) {
  const double margin = input.surfaceMargin.empty() ? 0.0 : input.surfaceMargin[s];
  return input.surfaces[s].mayBeWithin(p, reach + margin);
}

}  // namespace

/// No branch: which of some fifty are near, no processor guesses.
std::uint64_t* findNear(const SpatialHash& hash, const SpatialHash::Run& run, const Vector3& center,
                        double reach, std::uint64_t tag, std::uint64_t* hits) {
  const double *x = hash.x().data(), *y = hash.y().data(), *z = hash.z().data(), *r = hash.reach().data();
  const std::uint64_t* tags = hash.tag().data();
  for (std::int32_t k = run.begin; k < run.end; ++k) {
    const double dx = x[k] - center.x(), dy = y[k] - center.y(), dz = z[k] - center.z(), sum = reach + r[k];
    *hits = tags[k];
    hits += (dx * dx + dy * dy + dz * dz < sum * sum) & (tags[k] > tag);
  }
  return hits;
}

std::uint64_t MeetingRules::pairKey(std::int32_t a, std::int32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
}

bool MeetingRules::mayMeet(std::int32_t a, std::int32_t b) const {
  if (!group.empty() && ((group[a] & mask[b]) == 0 || (group[b] & mask[a]) == 0)) return false;
  return excludedPairs.empty() ||
         !std::binary_search(excludedPairs.begin(), excludedPairs.end(), pairKey(a, b));
}

void CandidateList::reset() {
  moving_.reset();
  fixed_.reset();
  fixedIsPlaced_ = false;
  rowStart_.clear();
  partner_.clear();
}

void CandidateList::rebuild(const SearchInput& input, const Executor& executor) {
  place(input, executor);
  const MeetingRules& rules = *input.rules;
  allSurfaces_.resize(input.surfaces.size());
  std::iota(allSurfaces_.begin(), allSurfaces_.end(), 0);
  everythingMeets_ = rules.group.empty() && rules.excludedPairs.empty() && rules.bodies.empty();
  const std::int32_t pieces = Executor::pieceCount(moving_.voxelCount(), kVoxelsPerPiece);
  if (static_cast<std::int32_t>(pieces_.size()) < pieces) pieces_.resize(pieces);
  for (Piece& piece : pieces_) piece.clear();
  executor.forPieces(pieces, [&](std::int32_t p) {
    searchPiece(p * kVoxelsPerPiece, std::min(moving_.voxelCount(), (p + 1) * kVoxelsPerPiece), input,
                pieces_[p]);
  });
  joinRows(input, executor);
}

/// What stands still is placed once; far from anything that moves it is not visited again.
void CandidateList::place(const SearchInput& input, const Executor& executor) {
  const std::size_t moving = std::min(input.particles.size(), static_cast<std::size_t>(input.movingCount));
  moving_.place({.particles = input.particles.first(moving),
                 .margin = input.margin,
                 .rank = input.rank.first(moving),
                 .firstSlot = 0},
                executor);
  if (fixedIsPlaced_) return;
  fixed_.place({.particles = input.particles.subspan(moving),
                .margin = {},
                .rank = input.rank.subspan(moving),
                .firstSlot = static_cast<std::int32_t>(moving)},
               executor);
  fixedIsPlaced_ = true;
}

/// Voxels [begin, end) of the hash.
void CandidateList::searchPiece(std::int32_t begin, std::int32_t end, const SearchInput& input,
                                Piece& piece) const {
  Cursors cursors;
  const std::int32_t particles = moving_.voxelBegin(end) - moving_.voxelBegin(begin);
  makeRoom(piece.slots, particles);
  makeRoom(piece.counts, particles);
  if (!input.surfaces.empty()) {
    findSurfaces(groupIn(begin, end, input), input, allSurfaces_, piece.surfaces);
  }
  for (std::int32_t voxel = begin; voxel < end; ++voxel) {
    const Group group = groupIn(voxel, voxel + 1, input);
    if (group.count > 0) searchGroup(group, input, cursors, piece);
  }
}

/// Those in voxels [begin, end).
CandidateList::Group CandidateList::groupIn(std::int32_t begin, std::int32_t end,
                                            const SearchInput& input) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Group group{.begin = moving_.voxelBegin(begin),
              .end = moving_.voxelBegin(end),
              .box = {Vector3::Constant(kInfinity), Vector3::Constant(-kInfinity)}};
  for (std::int32_t at = group.begin; at < group.end; ++at) {
    if (SpatialHash::slotOf(moving_.tag()[at]) >= input.dynamicCount) continue;
    ++group.count;
    const Vector3 center(moving_.x()[at], moving_.y()[at], moving_.z()[at]);
    group.box.lower = group.box.lower.cwiseMin(center);
    group.box.upper = group.box.upper.cwiseMax(center);
    const std::int32_t owner = input.owner[SpatialHash::slotOf(moving_.tag()[at])];
    group.largestReach = std::max(group.largestReach, moving_.reach()[at]);
    if (!input.overhang.empty()) group.overhang = std::max(group.overhang, input.overhang[owner]);
  }
  return group;
}

/// Of the surfaces `from` those that a particle of the group may be near to.
void CandidateList::findSurfaces(const Group& group, const SearchInput& input,
                                 std::span<const std::int32_t> from, std::vector<std::int32_t>& near) {
  near.clear();
  if (group.count == 0) return;
  const double reach = 0.5 * group.box.size().norm() + group.largestReach + group.overhang;
  for (const std::int32_t s : from) {
    if (isNear(input, s, group.box.center(), reach)) near.push_back(s);
  }
}

void CandidateList::searchGroup(const Group& group, const SearchInput& input, Cursors& cursors,
                                Piece& piece) const {
  piece.movingRuns.clear();
  moving_.findRuns(group.box, group.largestReach, cursors.moving, piece.movingRuns);
  piece.fixedRuns.clear();
  fixed_.findRuns(group.box, group.largestReach, cursors.fixed, piece.fixedRuns);
  if (!input.surfaces.empty()) findSurfaces(group, input, piece.surfaces, piece.nearSurfaces);
  const std::int64_t tests = sizeOf(piece.movingRuns) + sizeOf(piece.fixedRuns);
  piece.tests += tests * group.count;
  piece.hits.resize(tests + kHitsBeyond);
  for (std::int32_t at = group.begin; at < group.end; ++at) {
    if (SpatialHash::slotOf(moving_.tag()[at]) < input.dynamicCount) searchParticle(at, input, piece);
  }
}

void CandidateList::searchParticle(std::int32_t at, const SearchInput& input, Piece& piece) const {
  const Vector3 center(moving_.x()[at], moving_.y()[at], moving_.z()[at]);
  const double reach = moving_.reach()[at];
  const std::uint64_t tag = moving_.tag()[at];
  const std::int32_t slot = SpatialHash::slotOf(tag), owner = input.owner[slot];
  std::uint64_t *const first = piece.hits.data(), *last = first;
  for (const Run& run : piece.movingRuns) last = input.findNear(moving_, run, center, reach, tag, last);
  for (const Run& run : piece.fixedRuns) last = input.findNear(fixed_, run, center, reach, tag, last);
  last = std::remove_if(first, last, [&](std::uint64_t hit) {
    const std::int32_t other = input.owner[SpatialHash::slotOf(hit)];
    return other == owner || !(everythingMeets_ || (input.rules->mayMeet(owner, other) &&
                                                    input.rules->particlesMeet(owner, other)));
  });
  std::sort(first, last);
  const std::size_t before = piece.partners.size();
  makeRoom(piece.partners, before + (last - first) + piece.nearSurfaces.size());
  std::transform(first, last, std::back_inserter(piece.partners), SpatialHash::slotOf);
  for (const std::int32_t s : piece.nearSurfaces) {
    const std::int32_t surfaceSlot = static_cast<std::int32_t>(input.particles.size()) + s;
    const std::int32_t other = input.owner[surfaceSlot];
    if (owner == other || !input.rules->mayMeet(owner, other) || !input.rules->surfaceMeets(owner, other))
      continue;
    const double overhang = input.overhang.empty() ? 0.0 : input.overhang[owner];
    if (isNear(input, s, center, reach + overhang)) piece.partners.push_back(surfaceSlot);
  }
  piece.slots.push_back(slot);
  piece.counts.push_back(static_cast<std::int32_t>(piece.partners.size() - before));
}

void CandidateList::joinRows(const SearchInput& input, const Executor& executor) {
  rowStart_.assign(input.dynamicCount + 1, 0);
  tests_ = 0;
  for (const Piece& piece : pieces_) {
    tests_ += piece.tests;
    for (std::size_t r = 0; r < piece.slots.size(); ++r) rowStart_[piece.slots[r] + 1] = piece.counts[r];
  }
  for (std::int32_t i = 0; i < input.dynamicCount; ++i) rowStart_[i + 1] += rowStart_[i];
  resizeAnew(partner_, rowStart_.back());
  executor.forPieces(static_cast<std::int32_t>(pieces_.size()), [&](std::int32_t p) {
    const Piece& piece = pieces_[p];
    auto from = piece.partners.begin();
    for (std::size_t r = 0; r < piece.slots.size(); ++r) {
      std::copy_n(from, piece.counts[r], partner_.begin() + rowStart_[piece.slots[r]]);
      from += piece.counts[r];
    }
  });
}

}  // namespace granular
