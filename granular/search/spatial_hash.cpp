// SPDX-License-Identifier: MIT
#include "granular/search/spatial_hash.h"

#include <algorithm>
#include <cmath>

namespace granular {
namespace {

constexpr int kBits =
    20;  // an axis has a million voxels; what is beyond shares the last one: slow, not wrong
constexpr std::int32_t kLastCell = (1 << kBits) - 1;
constexpr std::uint64_t kMask = kLastCell;
constexpr std::int32_t kParticlesPerPiece = 4096;

// Level 0 holds particles of up to so many typical reaches, and its voxels are as wide as two of those:
// narrower ones fit better, wider ones are fewer (measured on the splash: 2.0 to 2.8 typical reaches cost the
// same within a tenth).
constexpr double kLevelBorder = 1.2;
constexpr double kEdge = 2.0 * kLevelBorder;
// What is typical may change by this factor before the hash is made for it anew.
constexpr double kTypicalChange = 1.25;
// A query reaches farther by this, relatively: far above rounding.
constexpr double kSlack = 1e-9;

double reachOf(const SpatialHash::Input& input, std::int32_t i) {
  return input.particles[i].radius + (input.margin.empty() ? 0.0 : input.margin[i]);
}

using Cell = std::array<std::int32_t, 3>;

std::uint64_t packKey(int level, const Cell& cell) {
  return static_cast<std::uint64_t>(level) << 3 * kBits | static_cast<std::uint64_t>(cell[2]) << 2 * kBits |
         static_cast<std::uint64_t>(cell[1]) << kBits | static_cast<std::uint64_t>(cell[0]);
}

Cell unpackKey(std::uint64_t key) {
  return {static_cast<std::int32_t>(key & kMask), static_cast<std::int32_t>(key >> kBits & kMask),
          static_cast<std::int32_t>(key >> 2 * kBits & kMask)};
}

}  // namespace

void SpatialHash::reset() {
  order_.clear();
  keys_.clear();
  voxels_.clear();
  levels_.fill({});
  moves_ = 0;
}

/// Voxels fit most of the particles. Where particles change what they reach, voxels do when it is much.
void SpatialHash::chooseEdges(const Input& input) {
  const auto count = static_cast<std::int32_t>(input.particles.size());
  double sum = 0.0;
  for (std::int32_t i = 0; i < count; ++i) sum += reachOf(input, i);
  const double typical = sum / count;
  const bool isNew = order_.empty() || !(typical < kTypicalChange * typicalReach_) ||
                     !(typical > typicalReach_ / kTypicalChange);
  if (!isNew) return;
  reset();
  typicalReach_ = typical;
  edge_ = kEdge * typical;
  for (int level = 0; level < kLevels; ++level) inverseEdge_[level] = 1.0 / std::ldexp(edge_, level);
  const ParticleRow& middle = input.particles[count / 2];
  origin_ = {middle.x, middle.y, middle.z};
}

int SpatialHash::levelOf(double reach) const {
  int level = 0;
  for (double border = kLevelBorder * typicalReach_; reach > border && level < kLevels - 1; ++level)
    border *= 2;
  return level;
}

inline std::int32_t SpatialHash::cellAt(int level, int axis, double at) const {
  const double cell = std::floor((at - origin_[axis]) * inverseEdge_[level]) + (1 << (kBits - 1));
  // In this order, what is not a number is in the last voxel too.
  return static_cast<std::int32_t>(std::max(0.0, std::min(double{kLastCell}, cell)));
}

SpatialHash::Key SpatialHash::keyOf(const ParticleRow& row, double reach) const {
  const int level = levelOf(reach);
  return packKey(level, {cellAt(level, 0, row.x), cellAt(level, 1, row.y), cellAt(level, 2, row.z)});
}

void SpatialHash::place(const Input& input, const Executor& executor) {
  if (input.particles.empty()) return reset();
  chooseEdges(input);
  findMoved(input, executor);
  mergeMoved();
  copyInOrder(input, executor);
  measureLevels();
}

void SpatialHash::findMoved(const Input& input, const Executor& executor) {
  const auto count = static_cast<std::int32_t>(input.particles.size());
  keys_.resize(count, ~Key{0});
  hasMoved_.resize(count);
  executor.forRanges(count, kParticlesPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::int32_t>(begin); i < end; ++i) {
      const Key key = keyOf(input.particles[i], reachOf(input, i));
      hasMoved_[i] = key != keys_[i];
      keys_[i] = key;
    }
  });
  moved_.clear();
  if (order_.empty()) moved_.reserve(count);
  for (std::int32_t i = 0; i < count; ++i) {
    if (hasMoved_[i]) moved_.push_back(i);
  }
}

bool SpatialHash::isBefore(std::int32_t i, std::int32_t j) const {
  return keys_[i] != keys_[j] ? keys_[i] < keys_[j] : i < j;
}

/// Takes those that moved out of the order and puts them where they belong.
void SpatialHash::mergeMoved() {
  if (moved_.empty()) return;
  std::sort(moved_.begin(), moved_.end(), [&](std::int32_t i, std::int32_t j) { return isBefore(i, j); });
  if (order_.empty()) return order_.swap(moved_);
  moves_ += static_cast<std::int64_t>(moved_.size());
  merged_.clear();
  merged_.reserve(order_.size());
  auto next = moved_.begin();
  for (const std::int32_t i : order_) {
    if (hasMoved_[i]) continue;
    while (next != moved_.end() && isBefore(*next, i)) merged_.push_back(*next++);
    merged_.push_back(i);
  }
  merged_.insert(merged_.end(), next, moved_.end());
  order_.swap(merged_);
}

void SpatialHash::copyInOrder(const Input& input, const Executor& executor) {
  for (auto* values : {&x_, &y_, &z_, &reach_}) values->resize(order_.size());
  tag_.resize(order_.size());
  executor.forRanges(size(), kParticlesPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t at = begin; at < end; ++at) {
      const std::int32_t i = order_[at];
      const ParticleRow& row = input.particles[i];
      x_[at] = row.x, y_[at] = row.y, z_[at] = row.z;
      reach_[at] = reachOf(input, i);
      tag_[at] =
          static_cast<std::uint64_t>(input.rank[i]) << 32 | static_cast<std::uint32_t>(input.firstSlot + i);
    }
  });
}

void SpatialHash::measureLevels() {
  voxels_.clear();
  voxelBegin_.clear();
  levels_.fill({});
  for (Level& level : levels_) level.lowest.fill(kLastCell);
  for (std::int32_t at = 0; at < size(); ++at) {
    const Key key = keys_[order_[at]];
    Level& level = levels_[key >> 3 * kBits];
    level.largestReach = std::max(level.largestReach, reach_[at]);
    if (!voxels_.empty() && voxels_.back() == key) continue;
    if (level.end == 0) level.begin = voxelCount();
    voxels_.push_back(key);
    voxelBegin_.push_back(at);
    level.end = voxelCount();
    const Cell cell = unpackKey(key);
    for (int axis = 0; axis < 3; ++axis) {
      level.lowest[axis] = std::min(level.lowest[axis], cell[axis]);
      level.highest[axis] = std::max(level.highest[axis], cell[axis]);
    }
  }
  voxelBegin_.push_back(size());
}

/// First voxel of the level that is not before this one.
std::int32_t SpatialHash::seek(const Level& level, Key key, Cursors& cursors) const {
  // Rows of a neighbourhood have places of their own.
  const Key row = key >> kBits;
  Cursors::Row& cursor = cursors.at_[(row & 7) | (row >> kBits & 7) << 3 | (row >> 2 * kBits & 3) << 6];
  std::int32_t at = cursor.at;
  if (cursor.key != row) {
    at = static_cast<std::int32_t>(
        std::lower_bound(voxels_.begin() + level.begin, voxels_.begin() + level.end, key) - voxels_.begin());
    cursor.key = row;
  } else {
    while (at < level.end && voxels_[at] < key) ++at;
    while (at > level.begin && voxels_[at - 1] >= key) --at;
  }
  cursor.at = at;
  return at;
}

void SpatialHash::findRuns(const Box& box, double reach, Cursors& cursors, std::vector<Run>& runs) const {
  for (int l = 0; l < kLevels; ++l) {
    const Level& level = levels_[l];
    if (level.begin == level.end) continue;
    const double way = (1.0 + kSlack) * (reach + level.largestReach);
    Cell low, high;
    bool isOutside = false;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(level.lowest[axis], cellAt(l, axis, box.lower[axis] - way));
      high[axis] = std::min(level.highest[axis], cellAt(l, axis, box.upper[axis] + way));
      isOutside |= low[axis] > high[axis];
    }
    if (isOutside) continue;
    // More rows than voxels: things that blew up, and share the last voxels, are far apart. All of the level.
    const std::int64_t rows = (std::int64_t{high[1]} - low[1] + 1) * (std::int64_t{high[2]} - low[2] + 1);
    if (rows > level.end - level.begin) {
      runs.push_back({voxelBegin_[level.begin], voxelBegin_[level.end]});
      continue;
    }
    const Key length = static_cast<Key>(high[0] - low[0]);
    for (Cell cell = low; cell[2] <= high[2]; ++cell[2]) {
      for (cell[1] = low[1]; cell[1] <= high[1]; ++cell[1]) {
        const Key first = packKey(l, cell);
        const std::int32_t begin = seek(level, first, cursors);
        std::int32_t end = begin;
        while (end < level.end && voxels_[end] <= first + length) ++end;
        if (begin < end) runs.push_back({voxelBegin_[begin], voxelBegin_[end]});
      }
    }
  }
}

}  // namespace granular
