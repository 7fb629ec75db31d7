// SPDX-License-Identifier: MIT
// Several numbers at a time (SIMD). What is written once as a template over Real runs for a double, for a
// Pack of as many as two of the processor's registers hold, and for a FloatPack of twice as many; each lane
// gives the bits that another width gives, as adding, multiplying, dividing and roots are exact to the last
// bit in both.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <experimental/simd>
#include <type_traits>

#include "granular/base/pose.h"

#if defined(__AVX512F__)
#define GRANULAR_ISA avx512
#elif defined(__AVX2__)
#define GRANULAR_ISA avx2
#else
#define GRANULAR_ISA baseline
#endif

namespace granular {

// Files that are compiled for several processors must not share names whose meaning depends on which.
inline namespace GRANULAR_ISA {

/// The whole number as wide as a floating-point one.
template <class Scalar>
using IntegerOf = std::conditional_t<sizeof(Scalar) == sizeof(std::int64_t), std::int64_t, std::int32_t>;

/// What compares two packs: a bool for each lane. Halves are the compiler's own vectors, all bits or none, as
/// it would not keep structures of structures in registers.
template <class Scalar>
struct PackMaskOf {
  using Register = std::experimental::native_simd<Scalar>;
  using Half [[gnu::vector_size(sizeof(Register))]] = IntegerOf<Scalar>;
  static constexpr int kRegisterSize = static_cast<int>(Register::size());
  Half low, high;

  PackMaskOf() = default;
  PackMaskOf(const PackMaskOf& other)
      : low(other.low), high(other.high) {}  // a copy of bytes would go through memory
  PackMaskOf& operator=(const PackMaskOf& other) {
    low = other.low, high = other.high;
    return *this;
  }
  PackMaskOf(const Half& a, const Half& b) : low(a), high(b) {}
  PackMaskOf(bool all) : low(Half{} - IntegerOf<Scalar>{all}), high(low) {}
  bool operator[](int lane) const {
    return (lane < kRegisterSize ? low[lane] : high[lane - kRegisterSize]) != 0;
  }
  void set(int lane, bool value) {
    Half& half = lane < kRegisterSize ? low : high;
    half[lane % kRegisterSize] = -IntegerOf<Scalar>{value};
  }
  friend PackMaskOf operator&&(const PackMaskOf& a, const PackMaskOf& b) {
    return {a.low & b.low, a.high & b.high};
  }
  friend PackMaskOf operator||(const PackMaskOf& a, const PackMaskOf& b) {
    return {a.low | b.low, a.high | b.high};
  }
};

/// Two registers side by side: what waits on a long chain of roots and quotients in one is filled with the
/// other's.
template <class Scalar>
struct PackOf {
  using Register = std::experimental::native_simd<Scalar>;
  using Half [[gnu::vector_size(sizeof(Register))]] = Scalar;
  using Bits [[gnu::vector_size(sizeof(Register))]] = IntegerOf<Scalar>;
  using Mask = PackMaskOf<Scalar>;
  static constexpr int kRegisterSize = static_cast<int>(Register::size()), kSize = 2 * kRegisterSize;
  Half low, high;

  PackOf() = default;
  PackOf(const PackOf& other)
      : low(other.low), high(other.high) {}  // a copy of bytes would go through memory
  PackOf& operator=(const PackOf& other) {
    low = other.low, high = other.high;
    return *this;
  }
  PackOf(const Half& a, const Half& b) : low(a), high(b) {}
  PackOf(double all) : low(static_cast<Scalar>(all) - Half{}), high(low) {}
  /// of(lane) in every lane, lane = 0 ... kSize - 1.
  template <class Function>
  requires std::is_invocable_r_v<double, Function, int>
  explicit PackOf(Function&& of) {
    for (int lane = 0; lane < kRegisterSize; ++lane) low[lane] = static_cast<Scalar>(of(lane));
    for (int lane = 0; lane < kRegisterSize; ++lane) {
      high[lane] = static_cast<Scalar>(of(kRegisterSize + lane));
    }
  }
  double operator[](int lane) const { return lane < kRegisterSize ? low[lane] : high[lane - kRegisterSize]; }

  friend PackOf operator+(const PackOf& a, const PackOf& b) { return {a.low + b.low, a.high + b.high}; }
  friend PackOf operator-(const PackOf& a, const PackOf& b) { return {a.low - b.low, a.high - b.high}; }
  friend PackOf operator*(const PackOf& a, const PackOf& b) { return {a.low * b.low, a.high * b.high}; }
  friend PackOf operator/(const PackOf& a, const PackOf& b) { return {a.low / b.low, a.high / b.high}; }
  friend PackOf operator-(const PackOf& a) { return {-a.low, -a.high}; }
  friend Mask operator<(const PackOf& a, const PackOf& b) { return {a.low < b.low, a.high < b.high}; }
  friend Mask operator>(const PackOf& a, const PackOf& b) { return {a.low > b.low, a.high > b.high}; }
  friend Mask operator>=(const PackOf& a, const PackOf& b) { return {a.low >= b.low, a.high >= b.high}; }
  friend Mask operator!=(const PackOf& a, const PackOf& b) { return {a.low != b.low, a.high != b.high}; }
  friend PackOf select(const Mask& condition, const PackOf& a, const PackOf& b) {
    return {condition.low ? a.low : b.low, condition.high ? a.high : b.high};
  }
  friend PackOf sqrt(const PackOf& a) {
    const auto root = [](const Half& half) { return static_cast<Half>(sqrt(Register(half))); };
    return {root(a.low), root(a.high)};
  }
  friend PackOf min(const PackOf& a, const PackOf& b) {
    const auto least = [](const Half& x, const Half& y) {
      return static_cast<Half>(min(Register(x), Register(y)));
    };
    return {least(a.low, b.low), least(a.high, b.high)};
  }
  friend PackOf max(const PackOf& a, const PackOf& b) {
    const auto most = [](const Half& x, const Half& y) {
      return static_cast<Half>(max(Register(x), Register(y)));
    };
    return {most(a.low, b.low), most(a.high, b.high)};
  }
};

using Pack = PackOf<double>;
using FloatPack = PackOf<float>;  ///< twice as many lanes

}  // namespace GRANULAR_ISA

/// Three packs, with what the laws need of Vector3. Eigen's own vectors hold an array, which compilers keep
/// in memory where these stay in registers.
template <class Real>
struct PackVector3 {
  Real first = 0.0, second = 0.0, third = 0.0;

  static PackVector3 Zero() { return {}; }
  const Real& x() const { return first; }
  const Real& y() const { return second; }
  const Real& z() const { return third; }
  Real dot(const PackVector3& v) const { return first * v.first + second * v.second + third * v.third; }
  Real squaredNorm() const { return dot(*this); }
  PackVector3 cross(const PackVector3& v) const {
    return {second * v.third - third * v.second, third * v.first - first * v.third,
            first * v.second - second * v.first};
  }

  friend PackVector3 operator+(const PackVector3& a, const PackVector3& b) {
    return {a.first + b.first, a.second + b.second, a.third + b.third};
  }
  friend PackVector3 operator-(const PackVector3& a, const PackVector3& b) {
    return {a.first - b.first, a.second - b.second, a.third - b.third};
  }
  friend PackVector3 operator*(const Real& s, const PackVector3& v) {
    return {s * v.first, s * v.second, s * v.third};
  }
  friend PackVector3 operator/(const PackVector3& v, const Real& s) { return Real(1.0 / s) * v; }
};

/// Three numbers, or three packs.
template <class Real>
using Vector3Of = std::conditional_t<std::is_same_v<Real, double>, Vector3, PackVector3<Real>>;

// For templates over Real; for packs argument-dependent look-up finds the library's.
using std::max;
using std::min;
using std::sqrt;

/// a where the condition holds, else b. Both are worked out.
inline double select(bool condition, double a, double b) {
  return condition ? a : b;
}
/// What comparing two of them gives: a bool, or one for each lane.
template <class Real>
using MaskOf = decltype(Real() < Real());
namespace detail {

/// x^(-1/5) to 3 %: the upper half of a double's bits, as a number, is a straight line for its logarithm. Of
/// a double and of a register's vector; Bits of the same size.
template <class Bits, class Real>
Real inverseFifthRootGuess(const Real& x) {
  // 6/5 of the upper half of 1.0, less what makes the largest error least.
  constexpr double kOffset = 0x3ff00000 * 1.2 - 0x10000;
  // A whole number below 2^52 stands in the lowest bits of itself + 2^52.
  constexpr double kShift = 0x1p52;
  constexpr auto kShiftBits = std::bit_cast<std::int64_t>(kShift);
  const Bits high = __builtin_bit_cast(Bits, x) >> 32 | kShiftBits;
  const Real logarithm = __builtin_bit_cast(Real, high) - kShift;
  return __builtin_bit_cast(Real, __builtin_bit_cast(Bits, (kShift + kOffset) - 0.2 * logarithm) << 32);
}

/// The same for a register of floats, by all of their bits.
template <class Bits, class Half>
Half inverseFifthRootGuessOfFloats(const Half& x) {
  constexpr float kOffset = 0x3f800000 * 1.2f - 0x80000;
  const Half logarithm = __builtin_convertvector(__builtin_bit_cast(Bits, x), Half);
  return __builtin_bit_cast(Half, __builtin_convertvector(kOffset - 0.2f * logarithm, Bits));
}

}  // namespace detail

/// x^(-1/5), x > 0 and no denormal: Newton's iteration, which costs neither divisions nor a library's pow,
/// whose bits differ between libraries. To 4e-16 or so, of floats to 3e-7.
template <class Real>
Real inverseFifthRoot(const Real& x) {
  Real y;
  int iterations = 4;
  if constexpr (std::is_same_v<Real, double>) {
    y = detail::inverseFifthRootGuess<std::int64_t>(x);
  } else if constexpr (std::is_same_v<Real, Pack>) {
    y = {detail::inverseFifthRootGuess<Pack::Bits>(x.low), detail::inverseFifthRootGuess<Pack::Bits>(x.high)};
  } else {
    y = {detail::inverseFifthRootGuessOfFloats<FloatPack::Bits>(x.low),
         detail::inverseFifthRootGuessOfFloats<FloatPack::Bits>(x.high)};
    iterations = 3;
  }
  for (int i = 0; i < iterations; ++i) {
    const Real y2 = y * y;
    y = y * (1.2 - 0.2 * x * (y2 * y2 * y));
  }
  return y;
}

template <class Real>
Vector3Of<Real> select(const MaskOf<Real>& condition, const Vector3Of<Real>& a, const Vector3Of<Real>& b) {
  return {select(condition, a.x(), b.x()), select(condition, a.y(), b.y()), select(condition, a.z(), b.z())};
}

}  // namespace granular
