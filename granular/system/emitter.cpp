// SPDX-License-Identifier: MIT
#include "granular/system/emitter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "granular/base/require.h"
#include "granular/system/detail/placed_particles.h"

namespace granular {
namespace {

// Places tried for one grain before it waits. A region half full of grains takes one in a few tens of tries.
constexpr int kTriesPerGrain = 300;

void check(const FillRegion& region, const EmitterDef& def) {
  if (!region.depth) throw std::invalid_argument("FillRegion.depth is empty; it must be a function");
  requirePositive(def.rate, "EmitterDef.rate", "grains/s");
  if (def.count) require(*def.count > 0, "EmitterDef.count", *def.count, "grains", "> 0");
  requireNotNegative(def.gap, "EmitterDef.gap", "smallest particle radii");
  requirePositive(def.minScale, "EmitterDef.minScale", "");
  require(std::isfinite(def.maxScale) && def.maxScale >= def.minScale, "EmitterDef.maxScale", def.maxScale,
          "", "finite and >= minScale");
}

}  // namespace

Emitter::Emitter(FillRegion region, GrainShapeDef shape, const EmitterDef& def)
    : region_(std::move(region)), shape_(std::move(shape)), def_(def) {
  makeGrainShape(shape_);  // throws what is wrong with the shape
  check(region_, def_);
  middle_ = detail::middleOf(shape_);
  leastRadius_ = std::numeric_limits<double>::infinity();
  for (const ShapeParticle& p : shape_.particles) {
    largestRadius_ = std::max(largestRadius_, def_.maxScale * p.radius);
    leastRadius_ = std::min(leastRadius_, p.radius);
  }
}

void Emitter::resume(double secondsPoured, std::int64_t poured) {
  requireNotNegative(secondsPoured, "Emitter secondsPoured", "s");
  require(poured >= 0, "Emitter poured", poured, "grains", ">= 0");
  seconds_ = secondsPoured;
  poured_ = poured;
}

std::int64_t Emitter::dueNow() const {
  // A rate times a time is not one short by rounding.
  const auto due = static_cast<std::int64_t>(std::floor(def_.rate * seconds_ + 1e-9));
  return (def_.count ? std::min(due, *def_.count) : due) - poured_;
}

std::vector<PlacedGrain> Emitter::pour(double dt, std::span<const ParticleView> present) {
  requireNotNegative(dt, "Emitter dt", "s");
  std::vector<PlacedGrain> grains;
  waiting_ = 0;
  if (isDone()) return grains;
  seconds_ += dt;
  const std::int64_t due = dueNow();
  if (due <= 0) return grains;

  double largest = largestRadius_;
  for (const ParticleView& p : present) largest = std::max(largest, p.radius);
  const double gap = def_.gap * def_.minScale * leastRadius_;
  detail::PlacedParticles placed(2.0 * largest + gap, gap);
  for (const ParticleView& p : present) {
    const Vector3 nearest = p.position.cwiseMax(region_.bounds.lower).cwiseMin(region_.bounds.upper);
    if ((nearest - p.position).norm() <= p.radius + largestRadius_ + gap) placed.add({p.position, p.radius});
  }
  std::vector<ShapeParticle> trial;
  for (std::int64_t i = 0; i < due; ++i) {
    const Random random = Random(def_.seed).forItem(static_cast<std::uint64_t>(poured_));
    const std::optional<PlacedGrain> grain = place(random, placed, trial);
    if (!grain) break;  // the next one would have the same chances
    for (const ShapeParticle& p : trial) placed.add(p);
    grains.push_back(*grain);
    ++poured_;
  }
  waiting_ = due - static_cast<std::int64_t>(grains.size());
  return grains;
}

/// Leaves the grain's particles in `trial`.
std::optional<PlacedGrain> Emitter::place(Random random, const detail::PlacedParticles& placed,
                                          std::vector<ShapeParticle>& trial) const {
  PlacedGrain grain;
  grain.scale = drawScale(def_.sizes, def_.minScale, def_.maxScale, random);
  // The middle of a grain is no nearer to the border than its smallest particle may be.
  const Box& box = region_.bounds;
  const Vector3 inset = (grain.scale * leastRadius_ * Vector3::Ones()).cwiseMin(0.5 * box.size());
  const Vector3 low = box.lower + inset, high = box.upper - inset;
  for (int tried = 0; tried < kTriesPerGrain; ++tried) {
    grain.pose.orientation = random.rotation();
    const Vector3 middle = {random.uniform(low.x(), high.x()), random.uniform(low.y(), high.y()),
                            random.uniform(low.z(), high.z())};
    grain.pose.position = middle - grain.pose.orientation * (grain.scale * middle_);
    trial.clear();
    for (const ShapeParticle& p : shape_.particles)
      trial.push_back({grain.pose.toWorld(grain.scale * p.position), grain.scale * p.radius});
    const bool fits = std::all_of(trial.begin(), trial.end(), [&](const ShapeParticle& p) {
      return region_.depth(p.position) >= p.radius && placed.isClear(p);
    });
    if (fits) return grain;
  }
  return std::nullopt;
}

}  // namespace granular
