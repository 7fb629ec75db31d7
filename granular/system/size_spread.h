// SPDX-License-Identifier: MIT
// How the sizes of many grains of one shape are spread between a smallest and a largest scale.
#pragma once

#include <cmath>
#include <cstdint>

#include "granular/base/random.h"

namespace granular {

enum class SizeSpread : std::uint8_t {
  Uniform,      ///< every scale equally often
  LogUniform,   ///< every ratio equally often: as many between 1 and 2 as between 2 and 4
  EqualVolume,  ///< every scale brings the same volume of grains: number falls as scale^-3, as in sieved sand
};

/// A scale in [smallest, largest]; 0 < smallest <= largest. Draws one random number.
inline double drawScale(SizeSpread spread, double smallest, double largest, Random& random) {
  const double u = random.uniform();
  switch (spread) {
    case SizeSpread::LogUniform:
      return smallest * std::pow(largest / smallest, u);
    case SizeSpread::EqualVolume: {  // inverse of the distribution function of a density ~ s^-3
      const double a = 1.0 / (smallest * smallest), b = 1.0 / (largest * largest);
      return 1.0 / std::sqrt(a + (b - a) * u);
    }
    case SizeSpread::Uniform:
      break;
  }
  return smallest + (largest - smallest) * u;
}

/// Expectation of scale^3: mean volume of a grain over that at scale 1.
inline double meanCubeOf(SizeSpread spread, double smallest, double largest) {
  const double a = smallest, b = largest;
  if (a == b) return a * a * a;
  switch (spread) {
    case SizeSpread::LogUniform:
      return (b * b * b - a * a * a) / (3.0 * std::log(b / a));
    case SizeSpread::EqualVolume:
      return 2.0 * a * a * b * b / (a + b);
    case SizeSpread::Uniform:
      break;
  }
  return 0.25 * (a * a * a + a * a * b + a * b * b + b * b * b);
}

}  // namespace granular
