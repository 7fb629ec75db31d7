// SPDX-License-Identifier: MIT
// Placing many grains in a region without initial overlap, to be settled by the simulation.
// Idea: the sites of a face-centred lattice, shaken; at each site random orientations (and ever smaller
// shifts) are tried until the grain's own particles are clear of those already placed. Time is linear in the
// number of sites.
//
//   auto shape = granular::tetrahedronShape(0.005);
//   auto grains = granular::fillRegion(granular::coneRegion({0, 0, 0}, {0, 1, 0}, 0.2, 0.15), shape, {.seed =
//   7}); for (const auto& g : grains) sand.addGrain({.shape = id, .material = m, .pose = g.pose, .scale =
//   g.scale});
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "granular/base/pose.h"
#include "granular/system/grain_shape.h"

namespace granular {

/// A part of space to be filled. Any other region is made by giving these two members.
struct FillRegion {
  Box bounds;  ///< encloses the region, m, world frame
  std::function<double(const Vector3&)>
      depth;  ///< distance to the region's border, m, > 0 inside: a particle
              ///< belongs to the region if depth(centre) >= its radius
};

FillRegion boxRegion(const Box& box);
FillRegion ballRegion(const Vector3& center, double radius);
/// Upright along `axis` (any length > 0) from the middle of its foot.
FillRegion cylinderRegion(const Vector3& foot, const Vector3& axis, double radius, double height);
/// A heap: foot radius `radius`, tip at `height` along `axis`.
FillRegion coneRegion(const Vector3& foot, const Vector3& axis, double radius, double height);
/// A cone cut off at `height`, where its radius is `topRadius`; one of the two radii may be 0.
FillRegion frustumRegion(const Vector3& foot, const Vector3& axis, double footRadius, double topRadius,
                         double height);

struct FillDef {
  std::uint64_t seed = 1;  ///< same seed, same grains, on every machine
  std::optional<std::int64_t> count =
      std::nullopt;  ///< grains wanted, > 0, placed from the bottom up; none: as many as fit
  /// Volume of particles over volume of region aimed at, in (0, 0.7]. Small regions get less (their border).
  /// Tetrahedra reach 0.353 at 0.38 and no more beyond 0.42; spheres reach 0.54. With `count`, denser
  /// lattices are tried when this one does not hold enough.
  double solidFraction = 0.38;
  double gap = 0.01;             ///< least distance between particles, in smallest particle radii, >= 0
  double minScale = 1.0;         ///< > 0; each grain's scale is uniform in [minScale, maxScale]
  double maxScale = 1.0;         ///< >= minScale
  Vector3 up = {0.0, 1.0, 0.0};  ///< the coordinate axis nearest to it is the order of filling with `count`
  std::vector<ShapeParticle> obstacles = {};  ///< particles already there (world frame), to be kept clear of
};

/// Goes into GrainDef as it is.
struct PlacedGrain {
  Pose pose;  ///< of the frame the shape was drawn in
  double scale = 1.0;
};

/// Grains of one shape in a region, none overlapping another or an obstacle, in random orientations.
/// Throws std::invalid_argument for a setting out of range, and std::runtime_error if no grain fits or if
/// `def.count` do not (saying how many do).
std::vector<PlacedGrain> fillRegion(const FillRegion& region, const GrainShapeDef& shape,
                                    const FillDef& def = {});

}  // namespace granular
