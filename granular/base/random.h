// SPDX-License-Identifier: MIT
// Our own random numbers: the distributions of <random> differ between standard libraries, and a seed must
// give the same scene everywhere. Generator: SplitMix64 (Steele, Lea & Flood 2014), 64 bits of state.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "granular/base/pose.h"

namespace granular {

class Random {
 public:
  explicit Random(std::uint64_t seed = 1) : state_(seed) {}

  /// Next 64 random bits.
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }

  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }

  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniformly distributed rotation (Shoemake 1992).
  Quaternion rotation() {
    const double u = uniform();
    const double a = 2.0 * std::numbers::pi * uniform();
    const double b = 2.0 * std::numbers::pi * uniform();
    const double s = std::sqrt(1.0 - u);
    const double t = std::sqrt(u);
    return Quaternion(t * std::cos(b), s * std::sin(a), s * std::cos(a), t * std::sin(b));
  }

  /// An independent generator for item `index` of a set: the same for any order or thread count of use.
  Random forItem(std::uint64_t index) const {
    Random r(state_ ^ (index * 0xd1342543de82ef95ull + 0x2545f4914f6cdd1dull));
    r.bits();
    return r;
  }

 private:
  std::uint64_t state_;
};

}  // namespace granular
