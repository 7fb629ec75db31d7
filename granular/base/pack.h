// SPDX-License-Identifier: MIT
// Several numbers at a time (SIMD). What is written once as a template over Real runs for a double and for a
// Pack of as many as the processor's registers hold; each lane gives the bits that another width gives, as
// adding, multiplying, dividing and roots are exact to the last bit in both.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <experimental/simd>
#include <type_traits>

#include "granular/base/pose.h"

#if defined(__AVX2__)
#define GRANULAR_ISA avx2
#else
#define GRANULAR_ISA baseline
#endif

namespace granular {

// Files that are compiled for several processors must not share names whose meaning depends on which.
inline namespace GRANULAR_ISA {

using Pack = std::experimental::native_simd<double>;
inline constexpr int kPackSize = static_cast<int>(Pack::size());

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
  friend PackVector3 operator/(const PackVector3& v, const Real& s) {
    return {v.first / s, v.second / s, v.third / s};
  }
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

template <class Real>
struct BitsOf {
  using Type = std::experimental::rebind_simd_t<std::uint64_t, Real>;
};
template <>
struct BitsOf<double> {
  using Type = std::uint64_t;
};

// The upper half of a double's bits is a straight line for its logarithm: minus a fifth of it, and 6/5 of
// that of 1 less what makes the largest error least, 3 %.
constexpr std::uint64_t kInverseFifthRootBits = 0x3ff00000u / 5 * 6 - 0x10000u;
template <class Real>
Real inverseFifthRootGuess(const Real& x) {
  using Bits = typename BitsOf<Real>::Type;
  static_assert(sizeof(Bits) == sizeof(Real));
  const Bits high = std::bit_cast<Bits>(x) >> 32;
  return std::bit_cast<Real>(Bits((kInverseFifthRootBits - (high * std::uint64_t{0xcccccccd} >> 34)) << 32));
}

}  // namespace detail

/// x^(-1/5), x > 0 and no denormal: Newton's iteration, which costs neither divisions nor a library's pow,
/// whose bits differ between libraries. To 4e-16 or so.
template <class Real>
Real inverseFifthRoot(const Real& x) {
  Real y = detail::inverseFifthRootGuess(x);
  for (int i = 0; i < 4; ++i) {
    const Real y2 = y * y;
    y = y * (1.2 - 0.2 * x * (y2 * y2 * y));
  }
  return y;
}

inline namespace GRANULAR_ISA {

inline Pack select(const Pack::mask_type& condition, const Pack& a, Pack b) {
  std::experimental::where(condition, b) = a;
  return b;
}

/// A pack of of(lane), lane = 0 ... kPackSize - 1.
template <class Function>
Pack packOf(Function&& of) {
  return Pack([&](auto lane) { return of(static_cast<int>(lane)); });
}

}  // namespace GRANULAR_ISA

template <class Real>
Vector3Of<Real> select(const MaskOf<Real>& condition, const Vector3Of<Real>& a, const Vector3Of<Real>& b) {
  return {select(condition, a.x(), b.x()), select(condition, a.y(), b.y()), select(condition, a.z(), b.z())};
}

}  // namespace granular
