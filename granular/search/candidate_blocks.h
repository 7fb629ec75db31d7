// SPDX-License-Identifier: MIT
// Candidates by blocks: of things that lie side by side, all pairs that one of them is part of. So a block's
// forces are worked out and summed up in the nearest caches, by one thread, and what it bears is written
// nowhere else; a pair between two blocks is worked out in both.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/search/candidate_list.h"

namespace granular {

/// Which block a slot belongs to. Blocks are numbered along the slots.
struct BlockInput {
  std::span<const std::int32_t> rank;         ///< [slot]
  std::span<const std::int32_t> patchOfSlot;  ///< -1: of no block
  std::span<const std::int32_t> blockOfPatch;
  /// Slots of dynamic owners in block b: [firstSlot[b], firstSlot[b + 1]).
  std::span<const std::int32_t> firstSlot;
  bool wantsIndices = false;  ///< whether index() is asked for

  std::int32_t blockCount() const { return static_cast<std::int32_t>(firstSlot.size()) - 1; }
};

class CandidateBlocks {
 public:
  /// Within a block candidates are in the order of the ranks of particle 1, then of particle 2, so that sums
  /// along them are the same whatever else is in the block.
  void rebuild(const CandidateList& list, const BlockInput& input, const Executor& executor);

  /// Candidates of block b: [starts()[b], starts()[b + 1]).
  std::span<const std::int32_t> starts() const { return start_; }
  std::span<const std::int32_t> row() const { return row_; }          ///< slot of particle 1
  std::span<const std::int32_t> partner() const { return partner_; }  ///< slot of particle 2
  std::span<const std::int32_t> index() const { return index_; }      ///< in the list

 private:
  struct Shared {
    std::int32_t block, candidate, row;
  };
  struct Row {
    std::int32_t rank, row;
    std::int32_t begin, end;  ///< candidates of the list; of foreign_ where isForeign
    bool isForeign;
  };
  void findShared(const CandidateList& list, const BlockInput& input, const Executor& executor);
  void fill(const CandidateList& list, const BlockInput& input, std::int32_t block);

  std::vector<std::vector<Shared>> sharedOf_;  // by block of particle 1: pairs that another block has too
  std::vector<std::int32_t> foreignStart_;     // by block
  std::vector<std::pair<std::int32_t, std::int32_t>> foreign_;  // candidate and row
  std::vector<std::int32_t> start_, row_, partner_, index_;
};

}  // namespace granular
