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
#include <optional>
#include <vector>

#include "granular/base/pose.h"
#include "granular/system/fill_region.h"
#include "granular/system/grain_shape.h"
#include "granular/system/size_spread.h"

namespace granular {

struct FillDef {
  std::uint64_t seed = 1;  ///< same seed, same grains, on every machine
  std::optional<std::int64_t> count =
      std::nullopt;  ///< grains wanted, > 0, placed from the bottom up; none: as many as fit
  /// Volume of particles over volume of region aimed at, in (0, 0.7]. Small regions get less (their border).
  /// Tetrahedra reach 0.353 at 0.38 and no more beyond 0.42; spheres reach 0.54. With `count`, denser
  /// lattices are tried when this one does not hold enough.
  double solidFraction = 0.38;
  double gap = 0.01;      ///< least distance between particles, in smallest particle radii, >= 0
  double minScale = 1.0;  ///< > 0; each grain's scale lies in [minScale, maxScale],
  double maxScale = 1.0;  ///< >= minScale,
  SizeSpread sizes =
      SizeSpread::Uniform;       ///< spread like this; where it is dense, large ones find room less often
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
