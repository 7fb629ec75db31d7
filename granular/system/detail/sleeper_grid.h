// SPDX-License-Identifier: MIT
// Sleeping grains by place: a hash of cells, changed only where one falls asleep or wakes, so that who may be
// touched is found without looking at all that sleeps.
#pragma once

#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "granular/base/pose.h"

namespace granular::detail {

class SleeperGrid {
 public:
  struct Grain {
    std::int32_t index;  ///< GrainId::index
    Vector3 center;      ///< m
    double reach;        ///< m
  };

  std::int32_t size() const { return size_; }
  /// None of them is in it yet. Cells fit those that come first.
  void insert(std::span<const Grain> grains);
  void remove(std::int32_t index);
  /// Appends all with a point nearer than `reach` (m) to `center`, and others in the same cells; each once
  /// from one startSearch() to the next.
  void find(const Vector3& center, double reach, std::vector<std::int32_t>& found);
  void startSearch() { ++search_; }

 private:
  struct Cell {
    std::vector<std::int32_t> grains;
    std::int64_t foundBy = 0;  // the last search that did
  };
  std::int64_t coordinateOf(double x) const;
  static std::uint64_t keyOf(std::int64_t x, std::int64_t y, std::int64_t z);
  void take(Cell& cell, std::vector<std::int32_t>& found) const;

  std::unordered_map<std::uint64_t, Cell> cells_;
  std::vector<std::uint64_t> cellOf_;  // by GrainId::index
  std::int32_t size_ = 0;
  std::int64_t search_ = 0;
  double cellSize_ = 1.0, largestReach_ = 0.0;  // m
};

}  // namespace granular::detail
