// SPDX-License-Identifier: MIT
#include "granular/search/candidate_list.h"

#include <algorithm>

namespace granular {
namespace {

constexpr std::int32_t kVoxelsPerPiece = 256;  // large enough that handing out pieces costs nothing

}  // namespace

std::uint64_t MeetingRules::pairKey(std::int32_t a, std::int32_t b) {
  return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
}

bool MeetingRules::mayMeet(std::int32_t a, std::int32_t b) const {
  if (!group.empty() && ((group[a] & mask[b]) == 0 || (group[b] & mask[a]) == 0)) return false;
  return excludedPairs.empty() ||
         !std::binary_search(excludedPairs.begin(), excludedPairs.end(), pairKey(a, b));
}

void CandidateList::reset(std::int32_t particleCount, double largestRadius, double skin) {
  largestRadius_ = largestRadius;
  skin_ = skin;
  hash_.reset(2.0 * largestRadius + skin, particleCount);
  fixedIsPlaced_ = false;
  rowStart_.clear();
  partner_.clear();
}

void CandidateList::rebuild(const SearchInput& input, const Executor& executor) {
  placeInHash(input);
  findActiveVoxels(input);
  const auto active = static_cast<std::int32_t>(activeVoxels_.size());
  const std::int32_t pieces = Executor::pieceCount(active, kVoxelsPerPiece);
  if (static_cast<std::int32_t>(pieces_.size()) < pieces) pieces_.resize(pieces);
  for (Piece& piece : pieces_) {
    piece.slots.clear();
    piece.counts.clear();
    piece.partners.clear();
  }
  executor.forPieces(pieces, [&](std::int32_t p) {
    const std::int32_t end = std::min(active, (p + 1) * kVoxelsPerPiece);
    for (std::int32_t v = p * kVoxelsPerPiece; v < end; ++v) searchVoxel(activeVoxels_[v], input, pieces_[p]);
  });
  joinRows(input, executor);
}

void CandidateList::placeInHash(const SearchInput& input) {
  const auto count = static_cast<std::int32_t>(input.particles.size());
  // Voxels that grains have left for good would be visited for ever.
  if (hash_.emptyVoxelCount() > 3 * (hash_.voxelCount() - hash_.emptyVoxelCount()) + 1000) {
    hash_.reset(hash_.voxelEdge(), count);
    fixedIsPlaced_ = false;
  }
  const std::int32_t places = fixedIsPlaced_ ? std::min(count, input.movingCount) : count;
  for (std::int32_t slot = 0; slot < places; ++slot) {
    const ParticleRow& row = input.particles[slot];
    hash_.place(slot, {row.x, row.y, row.z});
  }
  fixedIsPlaced_ = true;
}

/// Ground far from anything dynamic is not visited.
void CandidateList::findActiveVoxels(const SearchInput& input) {
  activeVoxels_.clear();
  ++rebuilds_;
  seenInRebuild_.resize(hash_.voxelCount(), 0);
  for (std::int32_t slot = 0; slot < input.dynamicCount; ++slot) {
    const std::int32_t voxel = hash_.voxelOf(slot);
    if (seenInRebuild_[voxel] == rebuilds_) continue;
    seenInRebuild_[voxel] = rebuilds_;
    activeVoxels_.push_back(voxel);
  }
}

void CandidateList::searchVoxel(std::int32_t voxel, const SearchInput& input, Piece& piece) const {
  // The neighbourhood once, side by side in memory; then every particle of the voxel reads it in one go.
  piece.nearRows.clear();
  piece.nearSlots.clear();
  piece.nearRanks.clear();
  for (const std::int32_t near : hash_.neighbours(voxel)) {
    if (near < 0) continue;
    for (std::int32_t j = hash_.first(near); j >= 0; j = hash_.next(j)) {
      piece.nearRows.push_back(input.particles[j]);
      piece.nearSlots.push_back(j);
      piece.nearRanks.push_back(input.rank[j]);
    }
  }
  piece.hits.resize(piece.nearRows.size());

  for (std::int32_t i = hash_.first(voxel); i >= 0; i = hash_.next(i)) {
    if (i >= input.dynamicCount) continue;
    const ParticleRow a = input.particles[i];
    const std::int32_t owner = input.owner[i];
    const std::int32_t rank = input.rank[i];
    const std::size_t begin = piece.partners.size();
    // No branch: which of some fifty are near, no processor guesses.
    std::size_t hits = 0;
    for (std::size_t k = 0; k < piece.nearRows.size(); ++k) {
      const ParticleRow& b = piece.nearRows[k];
      const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z;
      const double reach = a.radius + b.radius + skin_;
      const bool isNear = dx * dx + dy * dy + dz * dz < reach * reach;
      piece.hits[hits] = piece.nearSlots[k];
      hits += isNear & (piece.nearRanks[k] > rank);
    }
    for (const std::int32_t j : std::span(piece.hits).first(hits)) {
      if (input.owner[j] == owner || !input.rules->mayMeet(owner, input.owner[j])) continue;
      if (input.rules->particlesMeet(owner, input.owner[j])) piece.partners.push_back(j);
    }
    std::sort(piece.partners.begin() + begin, piece.partners.end(),
              [&](std::int32_t p, std::int32_t q) { return input.rank[p] < input.rank[q]; });
    searchSurfaces(i, input, piece);
    piece.slots.push_back(i);
    piece.counts.push_back(static_cast<std::int32_t>(piece.partners.size() - begin));
  }
}

void CandidateList::searchSurfaces(std::int32_t slot, const SearchInput& input, Piece& piece) const {
  if (input.surfaces.empty()) return;
  const ParticleRow& row = input.particles[slot];
  const auto first = static_cast<std::int32_t>(input.particles.size());
  const double reach =
      row.radius + skin_ + (input.overhang.empty() ? 0.0 : input.overhang[input.owner[slot]]);
  for (std::int32_t s = 0; s < static_cast<std::int32_t>(input.surfaces.size()); ++s) {
    if (!input.surfaces[s].mayBeWithin({row.x, row.y, row.z}, reach)) continue;
    const std::int32_t owner = input.owner[slot], other = input.owner[first + s];
    if (owner != other && input.rules->mayMeet(owner, other) && input.rules->surfaceMeets(owner, other))
      piece.partners.push_back(first + s);
  }
}

void CandidateList::joinRows(const SearchInput& input, const Executor& executor) {
  rowStart_.assign(input.dynamicCount + 1, 0);
  for (const Piece& piece : pieces_) {
    for (std::size_t r = 0; r < piece.slots.size(); ++r) rowStart_[piece.slots[r] + 1] = piece.counts[r];
  }
  for (std::int32_t i = 0; i < input.dynamicCount; ++i) rowStart_[i + 1] += rowStart_[i];
  partner_.resize(rowStart_.back());
  executor.forPieces(static_cast<std::int32_t>(pieces_.size()), [&](std::int32_t p) {
    const Piece& piece = pieces_[p];
    auto from = piece.partners.begin();
    for (std::size_t r = 0; r < piece.slots.size(); ++r) {
      std::copy_n(from, piece.counts[r], partner_.begin() + rowStart_[piece.slots[r]]);
      from += piece.counts[r];
    }
  });
}

void CandidateIncidence::rebuild(const CandidateList& list, const SearchInput& input,
                                 std::span<const std::int32_t> patchOfSlot, std::int32_t patchCount) {
  const auto rowStart = list.rowStart();
  const auto partner = list.partner();
  start_.assign(patchCount + 1, 0);
  for (const std::int32_t slot : partner) {
    const std::int32_t patch = patchOfSlot[slot];
    if (patch >= 0) ++start_[patch + 1];
  }
  for (std::int32_t p = 0; p < patchCount; ++p) start_[p + 1] += start_[p];
  entries_.resize(start_.back());
  cursor_.assign(start_.begin(), start_.end() - 1);
  for (std::int32_t rank = 0; rank < input.dynamicCount; ++rank) {
    const std::int32_t i = input.slotOfRank[rank];
    for (std::int32_t c = rowStart[i]; c < rowStart[i + 1]; ++c) {
      const std::int32_t patch = patchOfSlot[partner[c]];
      if (patch >= 0) entries_[cursor_[patch]++] = c;
    }
  }
}

}  // namespace granular
