// SPDX-License-Identifier: MIT
// Pours grains at a rate: at each call as many as are due find free places in a region, in random
// orientations, without overlap. Grains that find none wait and are poured as soon as there is room; how many
// wait is told, so that a region too small for its rate shows.
//
//   granular::Emitter spout(granular::cylinderRegion({0, 1, 0}, {0, 1, 0}, 0.1, 0.05), shape, {.rate = 200});
//   for (;;) {
//     sand.readParticles(particles);
//     for (const auto& g : spout.pour(dt, particles)) sand.addGrain({.shape = id, .material = m, ...});
//     sand.step(dt);
//   }
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "granular/base/random.h"
#include "granular/system/fill.h"
#include "granular/system/granular_system.h"

namespace granular {

struct EmitterDef {
  double rate = 0.0;                                 ///< grains a second, > 0
  std::optional<std::int64_t> count = std::nullopt;  ///< grains in all, > 0; none: without end
  double gap = 0.01;                       ///< least distance to what is there, in smallest radii, >= 0
  double minScale = 1.0;                   ///< > 0; each grain's scale lies in [minScale, maxScale],
  double maxScale = 1.0;                   ///< >= minScale,
  SizeSpread sizes = SizeSpread::Uniform;  ///< spread like this
  std::uint64_t seed = 1;                  ///< same seed and same surroundings, same grains
};

namespace detail {
class PlacedParticles;
}

class Emitter {
 public:
  /// Throws std::invalid_argument for a setting out of range.
  Emitter(FillRegion region, GrainShapeDef shape, const EmitterDef& def);

  /// The grains of the next dt seconds, clear of each other and of `present`, all particles there are (those
  /// outside the region's neighbourhood cost a comparison each). dt >= 0, finite.
  std::vector<PlacedGrain> pour(double dt, std::span<const ParticleView> present);

  std::int64_t poured() const { return poured_; }
  /// Grains that were due at the last call and found no place.
  std::int64_t waiting() const { return waiting_; }
  bool isDone() const { return def_.count && poured_ >= *def_.count; }
  /// Goes on from what another emitter of the same def had reached.
  void resume(double secondsPoured, std::int64_t poured);
  double secondsPoured() const { return seconds_; }

 private:
  std::int64_t dueNow() const;
  std::optional<PlacedGrain> place(Random random, const detail::PlacedParticles& placed,
                                   std::vector<ShapeParticle>& trial) const;

  FillRegion region_;
  GrainShapeDef shape_;
  EmitterDef def_;
  Vector3 middle_;
  double largestRadius_ = 0.0;  // of any particle, m
  double leastRadius_ = 0.0;    // of a particle at scale 1, m
  double seconds_ = 0.0;
  std::int64_t poured_ = 0, waiting_ = 0;
};

}  // namespace granular
