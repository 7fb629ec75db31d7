// SPDX-License-Identifier: MIT
#include "granular/search/spatial_hash.h"

#include <algorithm>
#include <cmath>

namespace granular {
namespace {

constexpr int kBits = 21;
constexpr std::uint64_t kMask = (std::uint64_t{1} << kBits) - 1;
constexpr std::uint64_t kNoKey = ~std::uint64_t{0};

std::uint64_t packKey(const std::array<std::int64_t, 3>& cell) {
  return (static_cast<std::uint64_t>(cell[0]) & kMask) |
         (static_cast<std::uint64_t>(cell[1]) & kMask) << kBits |
         (static_cast<std::uint64_t>(cell[2]) & kMask) << 2 * kBits;
}

std::array<std::int64_t, 3> unpackKey(std::uint64_t key) {
  return {static_cast<std::int64_t>(key & kMask), static_cast<std::int64_t>(key >> kBits & kMask),
          static_cast<std::int64_t>(key >> 2 * kBits & kMask)};
}

}  // namespace

void SpatialHash::reset(double voxelEdge, std::int32_t particleCount) {
  edge_ = voxelEdge;
  voxels_.clear();
  keys_.clear();
  voxelOfKey_.clear();
  lastKey_.assign(particleCount, kNoKey);
  links_.assign(particleCount, Link{});
  emptyVoxels_ = 0;
  moves_ = 0;
}

SpatialHash::Key SpatialHash::keyAt(const Vector3& position) const {
  std::array<std::int64_t, 3> cell;
  for (int axis = 0; axis < 3; ++axis) {
    // A particle that has left the world by more than 1e15 voxels shares the last one: slow, never undefined.
    const double at = std::clamp(std::floor(position[axis] / edge_), -1e15, 1e15);
    cell[axis] = static_cast<std::int64_t>(at);
  }
  return packKey(cell);
}

std::int32_t SpatialHash::voxelAt(const Vector3& position) {
  const Key key = keyAt(position);
  const auto [found, isNew] = voxelOfKey_.try_emplace(key, voxelCount());
  if (!isNew) return found->second;

  const std::int32_t voxel = voxelCount();
  voxels_.emplace_back();
  keys_.push_back(key);
  ++emptyVoxels_;
  const std::array<std::int64_t, 3> cell = unpackKey(key);
  for (int n = 0; n < 27;
       ++n) {  // make acquaintance both ways: my neighbour n has me as its neighbour 26 - n
    const Key nextKey = packKey({cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1});
    const auto neighbour = voxelOfKey_.find(nextKey);
    voxels_[voxel].neighbours[n] = neighbour == voxelOfKey_.end() ? -1 : neighbour->second;
    if (neighbour != voxelOfKey_.end()) voxels_[neighbour->second].neighbours[26 - n] = voxel;
  }
  return voxel;
}

void SpatialHash::unlink(std::int32_t particle) {
  Link& link = links_[particle];
  if (link.voxel < 0) return;
  (link.previous < 0 ? voxels_[link.voxel].first : links_[link.previous].next) = link.next;
  if (link.next >= 0) links_[link.next].previous = link.previous;
  if (voxels_[link.voxel].first < 0) ++emptyVoxels_;
  ++moves_;
}

void SpatialHash::place(std::int32_t particle, const Vector3& position) {
  const Key key = keyAt(position);
  if (key == lastKey_[particle]) return;
  lastKey_[particle] = key;
  unlink(particle);
  const std::int32_t voxel = voxelAt(position);
  Voxel& home = voxels_[voxel];
  if (home.first < 0) --emptyVoxels_;
  links_[particle] = {.voxel = voxel, .next = home.first, .previous = -1};
  if (home.first >= 0) links_[home.first].previous = particle;
  home.first = particle;
}

}  // namespace granular
