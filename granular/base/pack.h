// SPDX-License-Identifier: MIT
// Several numbers at a time (SIMD). What is written once as a template over Real runs for a double and for a
// Pack of as many as the processor's registers hold; each lane gives the bits that another width gives, as
// adding, multiplying, dividing and roots are exact to the last bit in both.
#pragma once

#include <cmath>
#include <experimental/simd>

#include "granular/base/pose.h"

namespace granular {

using Pack = std::experimental::native_simd<double>;
inline constexpr int kPackSize = static_cast<int>(Pack::size());

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
inline Pack select(const Pack::mask_type& condition, const Pack& a, Pack b) {
  std::experimental::where(condition, b) = a;
  return b;
}

/// A pack of of(lane), lane = 0 ... kPackSize - 1.
template <class Function>
Pack packOf(Function&& of) {
  return Pack([&](auto lane) { return of(static_cast<int>(lane)); });
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
