// SPDX-License-Identifier: MIT
// Signed distance on a voxel grid, kept only near a surface, in a hash of small blocks of nodes (Bell 2005,
// sec. 3.3): memory and time grow with the area of the surface, not with the volume around it. Between nodes
// the value is trilinear. Blocks are found by halving a cube that holds everything: a cube is dropped when
// the distance at its centre shows that the band cannot reach it, which is sound because a distance changes
// no faster than one metre a metre.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/geometry/detail/lattice_hash.h"
#include "granular/geometry/mesh_distance.h"

namespace granular {

struct BandDef {
  double spacing = 0.0;  ///< between nodes, m, > 0; about the particle radius
  double lower =
      0.0;  ///< the band holds every point whose distance is between lower and upper, m, negative inside
  double upper = 0.0;                    ///< m, >= lower
  int threads = 1;                       ///< any number gives the same bits
  std::int64_t maxVoxels = 200'000'000;  ///< some 8 bytes each; more are refused before any is sampled
};

/// Value and gradient of the distance at a point.
struct DistanceSample {
  double value = 0.0;                  ///< m, negative inside
  Vector3 gradient = Vector3::Zero();  ///< of the interpolated value; about a unit vector, pointing outwards
};

class SignedDistanceBand {
 public:
  /// A distance function, m, negative inside, that changes by at most the distance between two points (a true
  /// distance, or a smooth minimum of such). Called from several threads at once if BandDef::threads > 1.
  using DistanceFunction = std::function<double(const Vector3&)>;

  /// Throws std::invalid_argument for a bad def, or if the grid would need more than 2^19 blocks along an
  /// axis, or more than maxVoxels.
  SignedDistanceBand(const MeshDistance& mesh, const BandDef& def);
  /// `bounds` holds the part of the band that is wanted.
  SignedDistanceBand(const DistanceFunction& distance, const Box& bounds, const BandDef& def);

  /// What the last sample needed, so that the next one in the same voxel looks nothing up. One a thread, or
  /// one a point that is asked for again and again.
  struct Cursor {
    int i = 0, j = 0, k = 0;  // voxel
    bool isSet = false;
    std::array<double, 8> values = {};
  };

  /// Trilinear value and gradient, or nothing outside the band.
  std::optional<DistanceSample> sample(const Vector3& p) const;
  std::optional<DistanceSample> sample(const Vector3& p, Cursor& cursor) const;

  double spacing() const { return def_.spacing; }
  double lower() const { return def_.lower; }
  double upper() const { return def_.upper; }
  std::size_t nodeCount() const { return blocks_.size() * kBlockNodes; }
  std::size_t bytes() const;

  /// Node (i, j, k) of the whole grid, m.
  Vector3 nodePosition(int i, int j, int k) const { return origin_ + def_.spacing * Vector3(i, j, k); }
  /// Distance at a node, or nothing where it is not kept: out of reach of the band.
  std::optional<double> nodeValue(int i, int j, int k) const;

  /// visit(i, j, k, values) for every voxel all of whose nodes are kept, in an order that depends on the band
  /// alone. values[c] belongs to node (i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1)).
  void forEachVoxel(const std::function<void(int, int, int, const std::array<double, 8>&)>& visit) const;

 private:
  static constexpr int kBlockEdge =
      4;  // nodes; larger blocks keep more nodes outside the band, smaller ones hash more
  static constexpr int kBlockNodes = kBlockEdge * kBlockEdge * kBlockEdge;
  struct Block {
    int i, j, k;                             // of its first node, in blocks
    std::array<double, kBlockNodes> values;  // x fastest, m; not a number out of reach of the band
  };

  void findBlocks(const DistanceFunction& distance, int i, int j, int k, int edge);
  void chooseBlocks(const DistanceFunction& distance, const Box& bounds);
  template <class MakeSampler>
  void sampleBlocks(MakeSampler makeSampler);
  const double* node(int i, int j, int k) const;
  bool voxelValues(int i, int j, int k, std::array<double, 8>& values) const;
  std::array<const Block*, 8> blocksFrom(const Block& block) const;

  BandDef def_;
  Vector3 origin_ = Vector3::Zero();
  std::vector<Block> blocks_;
  detail::LatticeHash index_;
};

}  // namespace granular
