// SPDX-License-Identifier: MIT
#include "granular/system/detail/sleeper_grid.h"

#include <algorithm>
#include <cmath>

namespace granular::detail {
namespace {

// In reaches of the largest grain: of spheres some five lie in a cell, and a ball about a grain that its
// nearest neighbours lie in meets two or three cells along each axis.
constexpr double kCellSize = 4.0;

// Cells along an axis, on either side; what is beyond shares the last one.
constexpr std::int64_t kLastCell = (1 << 20) - 1;

}  // namespace

std::int64_t SleeperGrid::coordinateOf(double x) const {
  // In this order, what is not a number is in the last cell too.
  const double cell = std::max(-double{kLastCell}, std::min(double{kLastCell}, std::floor(x / cellSize_)));
  return static_cast<std::int64_t>(cell) + kLastCell;
}

std::uint64_t SleeperGrid::keyOf(std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::uint64_t>(x) | static_cast<std::uint64_t>(y) << 21 |
         static_cast<std::uint64_t>(z) << 42;
}

void SleeperGrid::insert(std::span<const Grain> grains) {
  if (size_ == 0) {
    cells_.clear();
    largestReach_ = 0.0;
  }
  for (const Grain& grain : grains) largestReach_ = std::max(largestReach_, grain.reach);
  if (size_ == 0 && largestReach_ > 0.0) cellSize_ = kCellSize * largestReach_;
  for (const Grain& grain : grains) {
    const std::uint64_t key =
        keyOf(coordinateOf(grain.center.x()), coordinateOf(grain.center.y()), coordinateOf(grain.center.z()));
    cells_[key].grains.push_back(grain.index);
    if (grain.index >= std::ssize(cellOf_)) cellOf_.resize(grain.index + 1);
    cellOf_[grain.index] = key;
    ++size_;
  }
}

void SleeperGrid::remove(std::int32_t index) {
  const auto cell = cells_.find(cellOf_[index]);
  std::erase(cell->second.grains, index);
  if (cell->second.grains.empty()) cells_.erase(cell);
  --size_;
}

void SleeperGrid::take(Cell& cell, std::vector<std::int32_t>& found) const {
  if (cell.foundBy == search_) return;
  cell.foundBy = search_;
  found.insert(found.end(), cell.grains.begin(), cell.grains.end());
}

void SleeperGrid::find(const Vector3& center, double reach, std::vector<std::int32_t>& found) {
  const double way = reach + largestReach_;
  std::int64_t low[3], high[3];
  double boxes = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = coordinateOf(center[axis] - way);
    high[axis] = coordinateOf(center[axis] + way);
    boxes *= static_cast<double>(high[axis] - low[axis] + 1);
  }
  if (!(boxes < static_cast<double>(cells_.size()))) {  // most are empty
    for (auto& entry : cells_) {
      const auto isIn = [&](int axis) {
        const auto at = static_cast<std::int64_t>(entry.first >> 21 * axis & 0x1fffff);
        return low[axis] <= at && at <= high[axis];
      };
      if (isIn(0) && isIn(1) && isIn(2)) take(entry.second, found);
    }
    return;
  }
  for (std::int64_t z = low[2]; z <= high[2]; ++z) {
    for (std::int64_t y = low[1]; y <= high[1]; ++y) {
      for (std::int64_t x = low[0]; x <= high[0]; ++x) {
        const auto cell = cells_.find(keyOf(x, y, z));
        if (cell != cells_.end()) take(cell->second, found);
      }
    }
  }
}

}  // namespace granular::detail
