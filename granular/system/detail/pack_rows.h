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

/// Lanes of a register.
template <class R>
constexpr int kLanesOf = sizeof(R) / sizeof(R{}[0]);
template <class R>
constexpr bool kIsOfDoubles = sizeof(R{}[0]) == sizeof(double);

/// Rows of four, as many as a register holds side by side in each of the four, become their columns; and
/// back.
template <class R>
FourPacks<R> transposed(const R& a, const R& b, const R& c, const R& d) {
  // Of two registers the first half of each row of both, or the second; then those of two such.
  R ab0, ab1, cd0, cd1;
  if constexpr (kIsOfDoubles<R> && kLanesOf<R> == 4) {
    ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {__builtin_shufflevector(ab0, cd0, 0, 1, 4, 5), __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5),
            __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7), __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7)};
  } else if constexpr (kIsOfDoubles<R>) {
    ab0 = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    ab1 = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
    cd0 = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
    cd1 = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
    return {__builtin_shufflevector(ab0, cd0, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab1, cd1, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab0, cd0, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(ab1, cd1, 2, 3, 10, 11, 6, 7, 14, 15)};
  } else if constexpr (kLanesOf<R> == 4) {
    ab0 = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab1 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    cd0 = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd1 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    return {__builtin_shufflevector(ab0, cd0, 0, 1, 4, 5), __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7),
            __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5), __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7)};
  } else if constexpr (kLanesOf<R> == 8) {
    ab0 = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
    ab1 = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
    cd0 = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
    cd1 = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
    return {__builtin_shufflevector(ab0, cd0, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab0, cd0, 2, 3, 10, 11, 6, 7, 14, 15),
            __builtin_shufflevector(ab1, cd1, 0, 1, 8, 9, 4, 5, 12, 13),
            __builtin_shufflevector(ab1, cd1, 2, 3, 10, 11, 6, 7, 14, 15)};
  } else {
    ab0 = __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    ab1 = __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    cd0 = __builtin_shufflevector(c, d, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
    cd1 = __builtin_shufflevector(c, d, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
    return {__builtin_shufflevector(ab0, cd0, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
            __builtin_shufflevector(ab0, cd0, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31),
            __builtin_shufflevector(ab1, cd1, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29),
            __builtin_shufflevector(ab1, cd1, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31)};
  }
}

/// Rows lane, lane + 4, lane + 8, ... side by side, as many as a register holds.
template <class R, class Function>
R rowsFrom(int lane, Function&& rowOf) {
  if constexpr (kIsOfDoubles<R>) {
    if constexpr (kLanesOf<R> == 4) {
      return rowOf(lane);
    } else {
      return __builtin_shufflevector(rowOf(lane), rowOf(lane + 4), 0, 1, 2, 3, 4, 5, 6, 7);
    }
  } else {
    const auto one = [&](int k) { return __builtin_convertvector(rowOf(k), FourFloats); };
    if constexpr (kLanesOf<R> == 4) {
      return one(lane);
    } else {
      const auto two = [&](int k) {
        return __builtin_shufflevector(one(k), one(k + 4), 0, 1, 2, 3, 4, 5, 6, 7);
      };
      if constexpr (kLanesOf<R> == 8) {
        return two(lane);
      } else {
        return __builtin_shufflevector(two(lane), two(lane + 8), 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13,
                                       14, 15);
      }
    }
  }
}

/// Rows of four numbers, one a lane, into registers of first, second, third and fourth ones. rowOf(lane): a
/// Four, or four floats where R is of floats.
template <class R, class Function>
FourPacks<R> registersOf(Function&& rowOf) {
  if constexpr (kLanesOf<R> == 2) {
    const Four a = rowOf(0), b = rowOf(1);
    return {R{a[0], b[0]}, R{a[1], b[1]}, R{a[2], b[2]}, R{a[3], b[3]}};
  } else {
    return transposed<R>(rowsFrom<R>(0, rowOf), rowsFrom<R>(1, rowOf), rowsFrom<R>(2, rowOf),
                         rowsFrom<R>(3, rowOf));
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

/// The way back of rowsFrom: to(lane, row) for each of them.
template <class R, class Function>
void toRowsFrom(int lane, const R& rows, Function&& to) {
  if constexpr (kLanesOf<R> == 4) {
    if constexpr (kIsOfDoubles<R>) {
      to(lane, rows);
    } else {
      to(lane, widened(rows));
    }
  } else if constexpr (kLanesOf<R> == 8) {
    toRowsFrom(lane, __builtin_shufflevector(rows, rows, 0, 1, 2, 3), to);
    toRowsFrom(lane + 4, __builtin_shufflevector(rows, rows, 4, 5, 6, 7), to);
  } else {
    toRowsFrom(lane, __builtin_shufflevector(rows, rows, 0, 1, 2, 3, 4, 5, 6, 7), to);
    toRowsFrom(lane + 8, __builtin_shufflevector(rows, rows, 8, 9, 10, 11, 12, 13, 14, 15), to);
  }
}

/// The way back of registersOf: to(lane, row) for every lane.
template <class R, class Function>
void forRegisterRows(const FourPacks<R>& packs, Function&& to) {
  const auto& [first, second, third, fourth] = packs;
  if constexpr (kLanesOf<R> == 2) {
    to(0, Four{first[0], second[0], third[0], fourth[0]});
    to(1, Four{first[1], second[1], third[1], fourth[1]});
  } else {
    const FourPacks<R> rows = transposed<R>(first, second, third, fourth);
    toRowsFrom(0, rows.first, to), toRowsFrom(1, rows.second, to);
    toRowsFrom(2, rows.third, to), toRowsFrom(3, rows.fourth, to);
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

/// Two packs of doubles as one of floats.
template <class Doubles>
FloatPack narrowed(const Doubles& low, const Doubles& high) {
  const auto half = [](const Doubles& pack) {
    using Half = FloatPack::Half;
#ifdef __AVX512F__
    const auto floats = [](const auto& eight) { return _mm512_cvtpd_ps(static_cast<__m512d>(eight)); };
    return static_cast<Half>(
        _mm512_insertf32x8(_mm512_castps256_ps512(floats(pack.low)), floats(pack.high), 1));
#else
    if constexpr (kLanesOf<Half> == 8) {
      return __builtin_shufflevector(__builtin_convertvector(pack.low, FourFloats),
                                     __builtin_convertvector(pack.high, FourFloats), 0, 1, 2, 3, 4, 5, 6, 7);
    } else {
      const auto at = [&](int lane) { return static_cast<float>(pack[lane]); };
      return Half{at(0), at(1), at(2), at(3)};
    }
#endif
  };
  return {half(low), half(high)};
}

/// Half of a pack of floats in doubles.
template <class P = Pack, class Half>
P wide(const Half& half) {
  if constexpr (kLanesOf<Half> == 8) {
    return P{widened(__builtin_shufflevector(half, half, 0, 1, 2, 3)),
             widened(__builtin_shufflevector(half, half, 4, 5, 6, 7))};
#ifdef __AVX512F__
  } else if constexpr (kLanesOf<Half> == 16) {
    const auto widened = [](const auto& eight) {
      return static_cast<typename P::Half>(_mm512_cvtps_pd(static_cast<__m256>(eight)));
    };
    return P{widened(__builtin_shufflevector(half, half, 0, 1, 2, 3, 4, 5, 6, 7)),
             widened(__builtin_shufflevector(half, half, 8, 9, 10, 11, 12, 13, 14, 15))};
#endif
  } else {
    return P([&](int lane) { return double{half[lane]}; });
  }
}

}  // namespace
}  // namespace granular::detail
