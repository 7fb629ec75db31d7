// SPDX-License-Identifier: MIT
// Rows of numbers in memory, one for a lane, into packs and back: a few loads and transposes, which take half
// the time of gathering number by number. Local to the file that includes it, as all that the kernels are
// made of.
#pragma once

#include <cstring>
#ifdef __AVX__
#include <immintrin.h>
#endif

#include "granular/base/pack.h"

// All that a kernel calls becomes part of it, but where sanitizers would make that take minutes to compile.
#ifdef __SANITIZE_ADDRESS__
#define GRANULAR_KERNEL
#else
#define GRANULAR_KERNEL [[gnu::flatten]]
#endif

namespace granular::detail {
namespace {

// Rows are read as the rest of the library lays them out, whatever this processor would like.
static_assert(alignof(Quaternion) == 16 && alignof(Vector3) == 8);

/// Four numbers that lie side by side: a row, or half of one.
using Four = double __attribute__((vector_size(32)));
using FourFloats = float __attribute__((vector_size(16)));

Four loadFour(const double* from) {
  Four four;
  std::memcpy(&four, from, sizeof(four));
  return four;
}
void storeFour(const Four& four, double* to) {
  std::memcpy(to, &four, sizeof(four));
}
/// Four floats in doubles. One instruction; gcc 12 makes four of the compiler's own conversion.
[[maybe_unused]] Four widened(const FourFloats& four) {
#ifdef __AVX__
  return static_cast<Four>(_mm256_cvtps_pd(static_cast<__m128>(four)));
#else
  return __builtin_convertvector(four, Four);
#endif
}
/// The first three of one, the fourth of the other.
Four withFourth(const Four& four, const Four& other) {
  return __builtin_shufflevector(four, other, 0, 1, 2, 7);
}

/// Four packs; named one by one, as arrays would be kept in memory.
template <class P>
struct FourPacks {
  P first, second, third, fourth;
};

/// Four rows of four, or eight where a register holds as many, become their columns; and back.
template <class R>
FourPacks<R> transposed(const R& a, const R& b, const R& c, const R& d) {
  if constexpr (sizeof(R) == sizeof(FourFloats)) {
    const R ab01 = __builtin_shufflevector(a, b, 0, 4, 1, 5),
            ab23 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const R cd01 = __builtin_shufflevector(c, d, 0, 4, 1, 5),
            cd23 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    return {__builtin_shufflevector(ab01, cd01, 0, 1, 4, 5), __builtin_shufflevector(ab01, cd01, 2, 3, 6, 7),
            __builtin_shufflevector(ab23, cd23, 0, 1, 4, 5), __builtin_shufflevector(ab23, cd23, 2, 3, 6, 7)};
  } else if constexpr (sizeof(a[0]) == sizeof(double)) {
    const R ab02 = __builtin_shufflevector(a, b, 0, 4, 2, 6),
            ab13 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const R cd02 = __builtin_shufflevector(c, d, 0, 4, 2, 6),
            cd13 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {__builtin_shufflevector(ab02, cd02, 0, 1, 4, 5), __builtin_shufflevector(ab13, cd13, 0, 1, 4, 5),
            __builtin_shufflevector(ab02, cd02, 2, 3, 6, 7), __builtin_shufflevector(ab13, cd13, 2, 3, 6, 7)};
  } else {  // each half of the register for itself
    const R ab01 = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13),
            ab23 = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    const R cd01 = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13),
            cd23 = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
    return {__builtin_shufflevector(ab01, cd01, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab01, cd01, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(ab23, cd23, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab23, cd23, 2, 3, 10, 11, 6, 7, 14, 15)};
  }
}

/// Rows of four numbers, one a lane, into registers of first, second, third and fourth ones. rowOf(lane): a
/// Four.
template <class R, class Function>
FourPacks<R> registersOf(Function&& rowOf) {
  if constexpr (sizeof(R) / sizeof(R{}[0]) == 8) {
    const auto both = [&](int lane) {
      return __builtin_shufflevector(__builtin_convertvector(rowOf(lane), FourFloats),
                                     __builtin_convertvector(rowOf(lane + 4), FourFloats), 0, 1, 2, 3, 4, 5,
                                     6, 7);
    };
    return transposed<R>(both(0), both(1), both(2), both(3));
  } else if constexpr (sizeof(R) == sizeof(FourFloats) && sizeof(R{}[0]) == sizeof(float)) {
    const auto one = [&](int lane) { return __builtin_convertvector(rowOf(lane), FourFloats); };
    return transposed<R>(one(0), one(1), one(2), one(3));
  } else if constexpr (sizeof(R) == sizeof(Four)) {
    return transposed<R>(rowOf(0), rowOf(1), rowOf(2), rowOf(3));
  } else {
    const Four a = rowOf(0), b = rowOf(1);
    return {R{a[0], b[0]}, R{a[1], b[1]}, R{a[2], b[2]}, R{a[3], b[3]}};
  }
}
template <class P, class Function>
FourPacks<P> packsOf(Function&& rowOf) {
  using R = typename P::Half;
  const FourPacks<R> low = registersOf<R>(rowOf);
  const FourPacks<R> high = registersOf<R>([&](int lane) { return rowOf(P::kRegisterSize + lane); });
  return {
      {low.first, high.first}, {low.second, high.second}, {low.third, high.third}, {low.fourth, high.fourth}};
}

/// The way back: to(lane, row) for every lane.
template <class R, class Function>
void forRegisterRows(const FourPacks<R>& packs, Function&& to) {
  const auto& [first, second, third, fourth] = packs;
  if constexpr (sizeof(R) == 2 * sizeof(double) && sizeof(first[0]) == sizeof(double)) {
    to(0, Four{first[0], second[0], third[0], fourth[0]});
    to(1, Four{first[1], second[1], third[1], fourth[1]});
  } else {
    const FourPacks<R> rows = transposed<R>(first, second, third, fourth);
    if constexpr (sizeof(first[0]) == sizeof(double)) {
      to(0, rows.first), to(1, rows.second), to(2, rows.third), to(3, rows.fourth);
    } else if constexpr (sizeof(R) == sizeof(FourFloats)) {
      to(0, widened(rows.first)), to(1, widened(rows.second));
      to(2, widened(rows.third)), to(3, widened(rows.fourth));
    } else {
      const auto both = [&](int lane, const R& row) {
        to(lane, widened(__builtin_shufflevector(row, row, 0, 1, 2, 3)));
        to(lane + 4, widened(__builtin_shufflevector(row, row, 4, 5, 6, 7)));
      };
      both(0, rows.first), both(1, rows.second), both(2, rows.third), both(3, rows.fourth);
    }
  }
}
template <class P, class Function>
void forRows(const FourPacks<P>& packs, Function&& to) {
  forRegisterRows<typename P::Half>({packs.first.low, packs.second.low, packs.third.low, packs.fourth.low},
                                    to);
  forRegisterRows<typename P::Half>(
      {packs.first.high, packs.second.high, packs.third.high, packs.fourth.high},
      [&](int lane, const Four& row) { to(P::kRegisterSize + lane, row); });
}

/// Half of a pack of floats in doubles.
template <class P = Pack, class Half>
P wide(const Half& half) {
  if constexpr (sizeof(Half) == 8 * sizeof(float)) {
    return P{widened(__builtin_shufflevector(half, half, 0, 1, 2, 3)),
             widened(__builtin_shufflevector(half, half, 4, 5, 6, 7))};
  } else {
    return P([&](int lane) { return double{half[lane]}; });
  }
}

}  // namespace
}  // namespace granular::detail
