// SPDX-License-Identifier: MIT
// Pairs of particles that may touch before anything has moved farther than its margin (Verlet's neighbour
// list over the spatial hash of Bell 2005, sec. 3.2, but with a margin for each). Kept and reused until then.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/geometry/exact_surface.h"
#include "granular/search/spatial_hash.h"

namespace granular {

/// An exact surface where it stands now.
struct SurfaceRow {
  const ExactSurface* shape = nullptr;
  double boundingRadius = 0.0;             ///< about `point`, m; infinite for a plane
  Vector3 point = Vector3::Zero();         ///< origin of its own frame, m, world
  Matrix3 rotation = Matrix3::Identity();  ///< from its own frame to the world

  SurfaceDistance distance(const Vector3& p) const {
    if (std::holds_alternative<HalfSpace>(*shape)) {  // floors and walls: most of all contacts on surfaces
      const Vector3 normal = rotation.col(1);
      return {.distance = normal.dot(p - point), .normal = normal};
    }
    SurfaceDistance at = surfaceDistance(*shape, rotation.transpose() * (p - point));
    at.normal = rotation * at.normal;
    return at;
  }
  bool mayBeWithin(const Vector3& p, double reach) const {
    const double sphere = boundingRadius + reach;
    return (p - point).squaredNorm() < sphere * sphere &&
           granular::mayBeWithin(*shape, rotation.transpose() * (p - point), reach);
  }
};

/// Which owners meet at all. Owners are numbered: dynamic ones first, then kinematic, then static.
struct MeetingRules {
  std::vector<std::uint32_t> group, mask;    ///< by owner; empty: everything meets
  std::vector<std::uint64_t> excludedPairs;  ///< sorted, smaller owner in the high half

  /// How bodies meet where some have a surface for other bodies' particles; empty: none has.
  struct BodyRule {
    bool isBody, movesParticles, hasSurface;
  };
  std::vector<BodyRule> bodies;  ///< by owner

  /// Whether the particles of a meet the surface of b in place of b's particles.
  bool onSurface(std::int32_t a, std::int32_t b) const {
    return !bodies.empty() && bodies[a].movesParticles && bodies[b].hasSurface;
  }
  bool particlesMeet(std::int32_t a, std::int32_t b) const { return !onSurface(a, b) && !onSurface(b, a); }
  /// Whether particles of a meet the exact surface of b at all: grains leave one alone that is for bodies.
  bool surfaceMeets(std::int32_t a, std::int32_t b) const {
    return bodies.empty() || bodies[a].isBody || !bodies[b].hasSurface;
  }

  static std::uint64_t pairKey(std::int32_t a, std::int32_t b);
  bool mayMeet(std::int32_t a, std::int32_t b) const;
};

/// Tags of those in a run that are nearer than both reach, and have a higher tag than this one, go to hits;
/// returns the end of them. There must be room for kHitsBeyond more than there are.
using FindNear = std::uint64_t* (*)(const SpatialHash& hash, const SpatialHash::Run& run,
                                    const Vector3& center, double reach, std::uint64_t tag,
                                    std::uint64_t* hits);
inline constexpr int kHitsBeyond = 8;
std::uint64_t* findNear(const SpatialHash& hash, const SpatialHash::Run& run, const Vector3& center,
                        double reach, std::uint64_t tag, std::uint64_t* hits);

/// What the list is built from. Slots [0, dynamicCount) belong to dynamic owners; rank is a particle's place
/// in the stable order of owners and local indices, which no re-sorting changes.
struct SearchInput {
  std::span<const ParticleRow> particles;  ///< [slot]
  std::span<const SurfaceRow> surfaces = {};
  std::span<const std::int32_t> owner;  ///< [slot]
  std::span<const std::int32_t> rank;   ///< [slot]
  std::int32_t dynamicCount = 0;
  /// Slots from here on have not moved since the last list, unless fixedMoved(); by default there are none.
  std::int32_t movingCount = std::numeric_limits<std::int32_t>::max();
  const MeetingRules* rules = nullptr;
  std::span<const double> overhang = {};  ///< [owner] how far it reaches beyond its particles to surfaces, m
  /// How far a thing may move from where it is now before the list is old, m: [slot] of those that move, and
  /// [surface]. Empty: nowhere.
  std::span<const double> margin = {}, surfaceMargin = {};
  FindNear findNear = granular::findNear;  ///< the one for this processor
};

class CandidateList {
 public:
  /// Throws everything away: other particles, other slots.
  void reset();

  /// What stands still stands elsewhere than at the last list.
  void fixedMoved() { fixedIsPlaced_ = false; }

  /// Pairs closer than the sum of radii and margins, never two of one owner, never without a dynamic one.
  /// Particle 1 of a pair is the one of lower rank; a row's partners are ordered by rank.
  void rebuild(const SearchInput& input, const Executor& executor);

  std::int64_t size() const { return static_cast<std::int64_t>(partner_.size()); }
  /// Candidates of dynamic slot i: [rowStart()[i], rowStart()[i + 1]).
  std::span<const std::int32_t> rowStart() const { return rowStart_; }
  std::span<const std::int32_t> partner() const { return partner_; }  ///< slot of particle 2, by candidate
  /// Distances that the last rebuild worked out.
  std::int64_t testCount() const { return tests_; }

 private:
  using Run = SpatialHash::Run;
  struct Piece {  // what one part of the hash found, on any thread
    std::vector<std::int32_t> slots, counts, partners;
    std::vector<std::int32_t> surfaces, nearSurfaces;  // near the piece, near the group
    std::vector<Run> movingRuns, fixedRuns;
    std::vector<std::uint64_t> hits;
    std::int64_t tests = 0;

    void clear() {
      for (auto* numbers : {&slots, &counts, &partners, &surfaces, &nearSurfaces}) numbers->clear();
      tests = 0;
    }
  };
  struct Cursors {
    SpatialHash::Cursors moving, fixed;
  };
  /// Dynamic particles of a voxel, or of some.
  struct Group {
    std::int32_t begin, end;  // in the order of the hash, others among them
    std::int32_t count = 0;
    Box box;                                    // about their centres
    double largestReach = 0.0, overhang = 0.0;  // m
  };

  void place(const SearchInput& input, const Executor& executor);
  void searchPiece(std::int32_t begin, std::int32_t end, const SearchInput& input, Piece& piece) const;
  Group groupIn(std::int32_t begin, std::int32_t end, const SearchInput& input) const;
  static void findSurfaces(const Group& group, const SearchInput& input, std::span<const std::int32_t> from,
                           std::vector<std::int32_t>& near);
  void searchGroup(const Group& group, const SearchInput& input, Cursors& cursors, Piece& piece) const;
  void searchParticle(std::int32_t at, const SearchInput& input, Piece& piece) const;
  void joinRows(const SearchInput& input, const Executor& executor);

  SpatialHash moving_, fixed_;
  bool fixedIsPlaced_ = false;
  bool everythingMeets_ = false;
  std::vector<std::int32_t> allSurfaces_;
  std::vector<Piece> pieces_;
  std::int64_t tests_ = 0;
  std::vector<std::int32_t> rowStart_, partner_;
};

}  // namespace granular
