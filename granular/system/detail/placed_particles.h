// SPDX-License-Identifier: MIT
// Round particles that stand still, and whether a new one would come too near: for placing grains.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "granular/system/grain_shape.h"

namespace granular::detail {

/// The particles placed so far, found by place: a hash of cells as wide as the largest particle, so that
/// whatever comes nearer than the gap lies in the 27 cells around. Cells that share a bucket only cost a
/// distance test.
class PlacedParticles {
 public:
  PlacedParticles(double cellSize, double gap) : cellSize_(cellSize), gap_(gap), heads_(1024, -1) {}

  void add(const ShapeParticle& particle) {
    if (particles_.size() == heads_.size()) grow();
    particles_.push_back(particle);
    next_.push_back(-1);
    link(static_cast<std::int32_t>(particles_.size() - 1));
  }

  bool isClear(const ShapeParticle& particle) const {
    const std::array<std::int64_t, 3> cell = cellOf(particle.position);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        for (std::int64_t dz = -1; dz <= 1; ++dz) {
          if (!isClearIn(bucketOf({cell[0] + dx, cell[1] + dy, cell[2] + dz}), particle)) return false;
        }
      }
    }
    return true;
  }

 private:
  bool isClearIn(std::size_t bucket, const ShapeParticle& particle) const {
    for (std::int32_t i = heads_[bucket]; i >= 0; i = next_[i]) {
      const double least = particles_[i].radius + particle.radius + gap_;
      if ((particles_[i].position - particle.position).squaredNorm() < least * least) return false;
    }
    return true;
  }

  std::array<std::int64_t, 3> cellOf(const Vector3& p) const {
    return {static_cast<std::int64_t>(std::floor(p.x() / cellSize_)),
            static_cast<std::int64_t>(std::floor(p.y() / cellSize_)),
            static_cast<std::int64_t>(std::floor(p.z() / cellSize_))};
  }

  std::size_t bucketOf(const std::array<std::int64_t, 3>& cell) const {
    std::uint64_t h = static_cast<std::uint64_t>(cell[0]) * 0x9e3779b97f4a7c15ull;
    h = (h ^ (h >> 29)) + static_cast<std::uint64_t>(cell[1]) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 31)) + static_cast<std::uint64_t>(cell[2]) * 0x94d049bb133111ebull;
    h ^= h >> 30;
    return static_cast<std::size_t>(h) & (heads_.size() - 1);
  }

  void link(std::int32_t i) {
    const std::size_t bucket = bucketOf(cellOf(particles_[i].position));
    next_[i] = heads_[bucket];
    heads_[bucket] = i;
  }

  void grow() {
    heads_.assign(2 * heads_.size(), -1);
    for (std::size_t i = 0; i < particles_.size(); ++i) link(static_cast<std::int32_t>(i));
  }

  double cellSize_;  // m
  double gap_;       // m
  std::vector<ShapeParticle> particles_;
  std::vector<std::int32_t> heads_;  // first particle of each bucket; a power of two of them
  std::vector<std::int32_t> next_;   // next particle of the same bucket, -1 at the end
};

/// Middle of a shape, by volume of particles.
inline Vector3 middleOf(const GrainShapeDef& shape) {
  Vector3 sum = Vector3::Zero();
  double weight = 0.0;
  for (const ShapeParticle& p : shape.particles) {
    const double w = p.radius * p.radius * p.radius;
    sum += w * p.position;
    weight += w;
  }
  return sum / weight;
}

}  // namespace granular::detail
