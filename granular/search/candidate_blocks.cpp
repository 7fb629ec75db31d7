// SPDX-License-Identifier: MIT
#include "granular/search/candidate_blocks.h"

#include <algorithm>

#include "granular/base/room.h"

namespace granular {

/// Candidates of the list that another block than that of particle 1 has too, by that block.
void CandidateBlocks::findShared(const CandidateList& list, const BlockInput& input,
                                 const Executor& executor) {
  const std::int32_t blocks = input.blockCount();
  sharedOf_.resize(blocks);
  executor.forPieces(blocks, [&](std::int32_t block) {
    std::vector<Shared>& shared = sharedOf_[block];
    shared.clear();
    for (std::int32_t row = input.firstSlot[block]; row < input.firstSlot[block + 1]; ++row) {
      for (std::int32_t c = list.rowStart()[row]; c < list.rowStart()[row + 1]; ++c) {
        const std::int32_t patch = input.patchOfSlot[list.partner()[c]];
        if (patch < 0 || input.blockOfPatch[patch] == block) continue;
        shared.push_back({input.blockOfPatch[patch], c, row});
      }
    }
  });
  // Two places ahead are the counts, one ahead where the next entry goes.
  foreignStart_.assign(blocks + 2, 0);
  for (std::int32_t block = 0; block < blocks; ++block) {
    for (const Shared& shared : sharedOf_[block]) ++foreignStart_[shared.block + 2];
  }
  for (std::int32_t block = 0; block < blocks; ++block) foreignStart_[block + 2] += foreignStart_[block + 1];
  resizeAnew(foreign_, foreignStart_.back());
  for (std::int32_t block = 0; block < blocks; ++block) {
    for (const Shared& shared : sharedOf_[block]) {
      foreign_[foreignStart_[shared.block + 1]++] = {shared.candidate, shared.row};
    }
  }
  foreignStart_.pop_back();
}

void CandidateBlocks::rebuild(const CandidateList& list, const BlockInput& input, const Executor& executor) {
  findShared(list, input, executor);
  const std::int32_t blocks = input.blockCount();
  start_.assign(blocks + 1, 0);
  for (std::int32_t block = 0; block < blocks; ++block) {
    const std::int32_t own =
        list.rowStart()[input.firstSlot[block + 1]] - list.rowStart()[input.firstSlot[block]];
    start_[block + 1] = start_[block] + own + foreignStart_[block + 1] - foreignStart_[block];
  }
  resizeAnew(row_, start_.back());
  resizeAnew(partner_, start_.back());
  resizeAnew(index_, input.wantsIndices ? start_.back() : 0);
  executor.forPieces(blocks, [&](std::int32_t block) { fill(list, input, block); });
}

void CandidateBlocks::fill(const CandidateList& list, const BlockInput& input, std::int32_t block) {
  thread_local std::vector<Row> rows;
  rows.clear();
  for (std::int32_t row = input.firstSlot[block]; row < input.firstSlot[block + 1]; ++row) {
    const std::int32_t begin = list.rowStart()[row], end = list.rowStart()[row + 1];
    if (begin < end) rows.push_back({input.rank[row], row, begin, end, false});
  }
  for (std::int32_t k = foreignStart_[block]; k < foreignStart_[block + 1];) {
    const std::int32_t row = foreign_[k].second, begin = k;
    while (k < foreignStart_[block + 1] && foreign_[k].second == row) ++k;
    rows.push_back({input.rank[row], row, begin, k, true});
  }
  std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.rank < b.rank; });
  std::int32_t to = start_[block];
  for (const Row& row : rows) {
    for (std::int32_t k = row.begin; k < row.end; ++k, ++to) {
      const std::int32_t candidate = row.isForeign ? foreign_[k].first : k;
      row_[to] = row.row;
      partner_[to] = list.partner()[candidate];
      if (input.wantsIndices) index_[to] = candidate;
    }
  }
}

}  // namespace granular
