// SPDX-License-Identifier: MIT
// The persistent spatial hash (Bell 2005, sec. 3.2): which particles are in which voxel. It changes only
// where a particle crosses a voxel border.
//
// Differs from the paper: instead of inserting a particle into its 27 neighbouring voxels, every voxel
// remembers where its 27 neighbours are. A query then follows 27 links instead of doing one look-up, with no
// hashing in either, and a particle that crosses a border costs one move instead of 27 insertions. Test:
// SpatialHash.FindsExactlyTheParticlesBruteForceFinds.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "granular/base/pose.h"

namespace granular {

class SpatialHash {
 public:
  /// Forgets everything. voxelEdge, m, > 0: at least the largest distance at which a query must find
  /// something.
  void reset(double voxelEdge, std::int32_t particleCount);

  double voxelEdge() const { return edge_; }

  /// Puts particle i where it is now; cheap when it stayed in its voxel. Position finite.
  void place(std::int32_t particle, const Vector3& position);

  std::int32_t voxelCount() const { return static_cast<std::int32_t>(voxels_.size()); }
  /// First particle in a voxel, or -1; then next(particle). Order within a voxel depends on history.
  std::int32_t first(std::int32_t voxel) const { return voxels_[voxel].first; }
  std::int32_t next(std::int32_t particle) const { return links_[particle].next; }
  /// Where a particle was put; -1: nowhere yet.
  std::int32_t voxelOf(std::int32_t particle) const { return links_[particle].voxel; }
  /// The voxel itself and its 26 neighbours; -1 where no particle has ever been.
  const std::array<std::int32_t, 27>& neighbours(std::int32_t voxel) const {
    return voxels_[voxel].neighbours;
  }

  /// Voxels that hold nothing; many of them make a reset worth while.
  std::int32_t emptyVoxelCount() const { return emptyVoxels_; }
  /// Border crossings since reset.
  std::int64_t moveCount() const { return moves_; }

 private:
  using Key = std::uint64_t;  // three times 21 bits: 2 million voxels each way, then space repeats
  struct Voxel {
    std::int32_t first = -1;
    std::array<std::int32_t, 27> neighbours{};
  };
  struct Link {
    std::int32_t voxel = -1, next = -1, previous = -1;
  };

  Key keyAt(const Vector3& position) const;
  std::int32_t voxelAt(const Vector3& position);
  void unlink(std::int32_t particle);

  double edge_ = 1.0;
  std::vector<Voxel> voxels_;
  std::vector<Key> keys_;     // of voxel v
  std::vector<Key> lastKey_;  // of particle i, so that staying put is one comparison
  std::vector<Link> links_;
  std::unordered_map<Key, std::int32_t> voxelOfKey_;
  std::int32_t emptyVoxels_ = 0;
  std::int64_t moves_ = 0;
};

}  // namespace granular
