// SPDX-License-Identifier: MIT
// Rows of numbers in memory, one for a lane, into packs and back: a few loads and transposes, which take half
// the time of gathering number by number. Local to the file that includes it, as all that the kernels are
// made of.
#pragma once

#include <cstring>

#include "granular/base/pack.h"

namespace granular::detail {
namespace {

// Rows are read as the rest of the library lays them out, whatever this processor would like.
static_assert(alignof(Quaternion) == 16 && alignof(Vector3) == 8);

/// Four numbers that lie side by side: a row, or half of one.
using Four = double __attribute__((vector_size(32)));

Four loadFour(const double* from) {
  Four four;
  std::memcpy(&four, from, sizeof(four));
  return four;
}
void storeFour(const Four& four, double* to) {
  std::memcpy(to, &four, sizeof(four));
}

/// Four packs; named one by one, as arrays would be kept in memory.
template <class P>
struct FourPacks {
  P first, second, third, fourth;
};

/// Rows of four numbers, one a lane, into registers of first, second, third and fourth ones. of(lane): where.
template <class R = Pack::Half, class Function>
FourPacks<R> registersOf(Function&& of) {
  if constexpr (sizeof(R) == sizeof(Four)) {
    const Four a = loadFour(of(0)), b = loadFour(of(1)), c = loadFour(of(2)), d = loadFour(of(3));
    const Four ab02 = __builtin_shufflevector(a, b, 0, 4, 2, 6),
               ab13 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Four cd02 = __builtin_shufflevector(c, d, 0, 4, 2, 6),
               cd13 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {__builtin_shufflevector(ab02, cd02, 0, 1, 4, 5), __builtin_shufflevector(ab13, cd13, 0, 1, 4, 5),
            __builtin_shufflevector(ab02, cd02, 2, 3, 6, 7), __builtin_shufflevector(ab13, cd13, 2, 3, 6, 7)};
  } else {
    FourPacks<R> packs;
    for (int lane = 0; lane < kRegisterSize; ++lane) {
      const double* from = of(lane);
      packs.first[lane] = from[0], packs.second[lane] = from[1];
      packs.third[lane] = from[2], packs.fourth[lane] = from[3];
    }
    return packs;
  }
}
template <class Function>
FourPacks<Pack> packsOf(Function&& of) {
  const FourPacks<Pack::Half> low = registersOf(of);
  const FourPacks<Pack::Half> high = registersOf([&](int lane) { return of(kRegisterSize + lane); });
  return {
      {low.first, high.first}, {low.second, high.second}, {low.third, high.third}, {low.fourth, high.fourth}};
}

/// The way back.
template <class R, class Function>
void storeRegisters(const FourPacks<R>& packs, Function&& of) {
  if constexpr (sizeof(R) == sizeof(Four)) {
    const auto& [a, b, c, d] = packs;
    const Four ab02 = __builtin_shufflevector(a, b, 0, 4, 2, 6),
               ab13 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Four cd02 = __builtin_shufflevector(c, d, 0, 4, 2, 6),
               cd13 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    storeFour(__builtin_shufflevector(ab02, cd02, 0, 1, 4, 5), of(0));
    storeFour(__builtin_shufflevector(ab13, cd13, 0, 1, 4, 5), of(1));
    storeFour(__builtin_shufflevector(ab02, cd02, 2, 3, 6, 7), of(2));
    storeFour(__builtin_shufflevector(ab13, cd13, 2, 3, 6, 7), of(3));
  } else {
    for (int lane = 0; lane < kRegisterSize; ++lane) {
      double* to = of(lane);
      to[0] = packs.first[lane], to[1] = packs.second[lane];
      to[2] = packs.third[lane], to[3] = packs.fourth[lane];
    }
  }
}
template <class Function>
void storeRows(const FourPacks<Pack>& packs, Function&& of) {
  storeRegisters<Pack::Half>({packs.first.low, packs.second.low, packs.third.low, packs.fourth.low}, of);
  storeRegisters<Pack::Half>({packs.first.high, packs.second.high, packs.third.high, packs.fourth.high},
                             [&](int lane) { return of(kRegisterSize + lane); });
}

}  // namespace
}  // namespace granular::detail
