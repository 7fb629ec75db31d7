// SPDX-License-Identifier: MIT
// Several numbers at a time (SIMD). What is written once as a template over Real runs for a double and for a
// Pack of as many as the processor's registers hold; each lane gives the bits that another width gives, as
// adding, multiplying, dividing and roots are exact to the last bit in both.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <experimental/simd>

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

using Pack = std::experimental::native_simd<double>;
inline constexpr int kPackSize = static_cast<int>(Pack::size());

}  // namespace GRANULAR_ISA

/// Three of them: as Vector3, with packs for numbers.
template <class Real>
using Vector3Of = Eigen::Matrix<Real, 3, 1>;

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

/// Lets Eigen's small vectors hold packs.
template <>
struct Eigen::NumTraits<granular::Pack> : Eigen::GenericNumTraits<double> {
  using Real = granular::Pack;
  using NonInteger = granular::Pack;
  using Nested = granular::Pack;
  using Literal = granular::Pack;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
};
