// SPDX-License-Identifier: MIT
// Sample points that are even within a pixel and over its neighbours, the same for any thread count.
//
// All pixels share one Owen-scrambled Sobol sequence, taken in Morton order of the pixels, so that every
// block of 2^k x 2^k pixels is itself evenly sampled and the noise has no low frequencies (Ahmed & Wonka
// 2020). Pairs of dimensions are shuffled apart by hashing (Burley 2020, "Practical hash-based Owen
// scrambling").
#pragma once

#include <cstdint>

#include "demos/render/color.h"

namespace granular_demo {

struct Sample2 {
  float x, y;  // [0, 1)
};

namespace detail {

inline std::uint32_t reverseBits(std::uint32_t v) {
  v = ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  return __builtin_bswap32(v);
}

/// Owen scrambling of a number whose bits are reversed: each bit is flipped by a hash of the bits below it.
inline std::uint32_t scrambleReversed(std::uint32_t v, std::uint32_t seed) {
  v += seed;
  v ^= v * 0x6c50b47cu;
  v ^= v * 0xb82f1e52u;
  v ^= v * 0xc7afe638u;
  v ^= v * 0x8d22f6e6u;
  return v;
}

inline std::uint32_t hash(std::uint32_t v) {  // "lowbias32" (Wellons 2018)
  v = (v ^ (v >> 16)) * 0x7feb352du;
  v = (v ^ (v >> 15)) * 0x846ca68bu;
  return v ^ (v >> 16);
}

/// Second Sobol dimension of point `index`, bits reversed: Pascal's triangle mod 2, applied by halves.
inline std::uint32_t sobolSecondReversed(std::uint32_t index) {
  index ^= index >> 16;
  index ^= (index & 0xff00ff00u) >> 8;
  index ^= (index & 0xf0f0f0f0u) >> 4;
  index ^= (index & 0xccccccccu) >> 2;
  index ^= (index & 0xaaaaaaaau) >> 1;
  return index;
}

inline float unitFloat(std::uint32_t v) {
  return static_cast<float>(v >> 8) * 0x1p-24f;
}

inline std::uint32_t spreadBits(std::uint32_t v) {
  v &= 0xffffu;
  v = (v | (v << 8)) & 0x00ff00ffu;
  v = (v | (v << 4)) & 0x0f0f0f0fu;
  v = (v | (v << 2)) & 0x33333333u;
  return (v | (v << 1)) & 0x55555555u;
}

}  // namespace detail

/// Rank of a pixel along the Morton curve.
inline std::uint32_t mortonIndex(int x, int y) {
  return detail::spreadBits(static_cast<std::uint32_t>(x)) |
         (detail::spreadBits(static_cast<std::uint32_t>(y)) << 1);
}

/// Point `index` of the shuffled, scrambled (0,2)-sequence that belongs to `dimension`.
inline Sample2 samplePair(std::uint32_t index, std::uint32_t dimension) {
  const std::uint32_t seed = detail::hash(dimension + 0x9e3779b9u);
  const std::uint32_t shuffled =
      detail::reverseBits(detail::scrambleReversed(detail::reverseBits(index), seed));
  const std::uint32_t x =
      detail::reverseBits(detail::scrambleReversed(shuffled, detail::hash(seed ^ 0x68bc21ebu)));
  const std::uint32_t second = detail::sobolSecondReversed(shuffled);
  const std::uint32_t y =
      detail::reverseBits(detail::scrambleReversed(second, detail::hash(seed ^ 0x02e5be93u)));
  return {detail::unitFloat(x), detail::unitFloat(y)};
}

}  // namespace granular_demo
