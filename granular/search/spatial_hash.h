// SPDX-License-Identifier: MIT
// The persistent spatial hash (Bell 2005, sec. 3.2): which particles are in which voxel. It changes only
// where a particle crosses a voxel border.
//
// The table is one array of all particles, sorted by the numbers z, y, x of their voxels (a hash by sorting:
// S. Green, Particle Simulation using CUDA, 2010). A row of voxels along x is one contiguous run in it, so
// that a query of a box reads a few runs and looks nothing up between. Large particles lie in voxels of their
// own level, twice as wide from level to level (Ogarko, Luding 2012): small ones do not pay for them.
//
// Differs from the paper: a particle is in one voxel instead of inserted into 27. Test:
// SpatialHash.FindsAllThatBruteForceFinds.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/base/pose.h"

namespace granular {

/// A particle as search and contact test read it: one row of 32 bytes.
struct alignas(32) ParticleRow {
  double x, y, z;  ///< m, world
  double radius;   ///< m
};
static_assert(sizeof(ParticleRow) == 32, "a row is half a cache line, two rows to a load of 64 bytes");

class SpatialHash {
 public:
  /// What is put into it, [particle]; the same number at every call until reset().
  struct Input {
    std::span<const ParticleRow> particles;
    std::span<const double> margin;  ///< m, how much farther than its radius it reaches; empty: no farther
    std::span<const std::int32_t> rank;
    std::int32_t firstSlot = 0;  ///< of particle 0
  };
  /// Particles [begin, end) in the order of the hash: of a row of voxels, or of a whole level.
  struct Run {
    std::int32_t begin, end;
  };

  /// Forgets everything.
  void reset();

  /// Puts all particles where they are now. One comparison for each that stayed in its voxel.
  void place(const Input& input, const Executor& executor);

  /// Voxels that hold something, in order; particles of voxel v are [voxelBegin(v), voxelBegin(v + 1)).
  std::int32_t voxelCount() const { return static_cast<std::int32_t>(voxels_.size()); }
  std::int32_t voxelBegin(std::int32_t voxel) const { return voxelBegin_[voxel]; }

  // In the order of the hash.
  std::int32_t size() const { return static_cast<std::int32_t>(order_.size()); }
  std::span<const double> x() const { return x_; }
  std::span<const double> y() const { return y_; }
  std::span<const double> z() const { return z_; }
  std::span<const double> reach() const { return reach_; }  ///< radius and margin, m
  /// Rank in the upper half, slot in the lower: tags are in the order of ranks.
  std::span<const std::uint64_t> tag() const { return tag_; }
  static std::int32_t slotOf(std::uint64_t tag) { return static_cast<std::int32_t>(tag & 0xffffffffu); }

  /// Where rows were found last: the next query is most often beside it. For one thread, until place().
  class Cursors {
   public:
    void clear() { at_.fill({}); }

   private:
    friend class SpatialHash;
    struct Row {
      std::uint64_t key = ~std::uint64_t{0};
      std::int32_t at = 0;
    };
    std::array<Row, 256> at_;
  };
  /// Adds runs in which all particles are whose reach and `reach` (m) together reach into the box, and
  /// others: no more runs than voxels, wherever things are.
  void findRuns(const Box& box, double reach, Cursors& cursors, std::vector<Run>& runs) const;

  /// Border crossings since reset.
  std::int64_t moveCount() const { return moves_; }

 private:
  using Key = std::uint64_t;  // level and z, y, x of the voxel
  using Cell = std::array<std::int32_t, 3>;
  static constexpr int kLevels = 16;
  struct Level {
    std::int32_t begin = 0, end = 0;  // voxels
    double largestReach = 0.0;        // m
    Cell lowest{}, highest{};
  };

  void chooseEdges(const Input& input);
  int levelOf(double reach) const;
  std::int32_t cellAt(int level, int axis, double at) const;
  Key keyOf(const ParticleRow& row, double reach) const;
  bool isBefore(std::int32_t i, std::int32_t j) const;
  void findMoved(const Input& input, const Executor& executor);
  void mergeMoved();
  void copyInOrder(const Input& input, const Executor& executor);
  void measureLevels();
  std::int32_t seek(const Level& level, Key key, Cursors& cursors) const;

  Vector3 origin_ = Vector3::Zero();
  double edge_ = 1.0;  // of voxels of level 0, m
  double typicalReach_ = 1.0;
  std::array<double, kLevels> inverseEdge_{};
  // By particle: its voxel, so that staying put is one comparison, and whether it has just left another.
  std::vector<Key> keys_;
  std::vector<std::uint8_t> hasMoved_;
  std::vector<std::int32_t> order_, moved_, merged_;  // particles by voxel, in a voxel by number
  std::vector<Key> voxels_;
  std::vector<std::int32_t> voxelBegin_;  // one entry more than voxels
  std::array<Level, kLevels> levels_;
  std::int64_t moves_ = 0;
  std::vector<double> x_, y_, z_, reach_;
  std::vector<std::uint64_t> tag_;
};

}  // namespace granular
