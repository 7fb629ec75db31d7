// SPDX-License-Identifier: MIT
// Poses that move on by themselves, in packs of owners; included once by the file for each processor.
#pragma once

#include <algorithm>
#include <cstdint>

#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/layout.h"
#include "granular/system/detail/pack_rows.h"

namespace granular::detail {
namespace {

/// cos(a) and sin(a)/a by the square of a half angle of at most kLargestHalfTurn: the series, of which what
/// is left out is below 1e-20.
struct PackHalfTurn {
  static constexpr double kLargestSquare = 0.01;
  Pack cosine, sineOverAngle;

  explicit PackHalfTurn(const Pack& x) {
    constexpr auto over = [](double n) { return 1.0 / n; };
    cosine = 1.0 - x * (over(2) - x * (over(24) - x * (over(720) - x * (over(40320) - x * over(3628800)))));
    sineOverAngle =
        1.0 - x * (over(6) - x * (over(120) - x * (over(5040) - x * (over(362880) - x * over(39916800)))));
  }
};

/// Squares of lengths of quaternions from which one step of Newton's leads back to 1 within rounding.
constexpr double kNearUnit = 1.0 - 1e-8;

/// Poses that move on and do not turn.
void driftPositions(const DriftArrays& arrays, std::int32_t begin, std::int32_t end) {
  const double time = arrays.drift.time, kick = arrays.drift.poseKick;
  const double *pose = arrays.poses, *momenta = arrays.momenta, *rates = arrays.rates;
  double* to = arrays.posesTo;
  for (std::int64_t place = begin; place < end; ++place) {
    const double* from = pose + place * state::kPoseSize;
    const Four position = loadFour(from), orientation = loadFour(from + 3);
    const Four velocity = loadFour(momenta + place * state::kMomentaSize) +
                          kick * loadFour(rates + place * state::kMomentaSize);
    storeFour(position + time * velocity, to + place * state::kPoseSize);
    storeFour(orientation, to + place * state::kPoseSize + 3);
  }
}

GRANULAR_KERNEL std::int32_t driftOwners(const DriftArrays& arrays, std::int32_t begin, std::int32_t end,
                                         std::int32_t* left) {
  std::int32_t leftCount = 0;
  const auto rowAt = [](auto* numbers, std::int32_t place, int size) {
    return numbers + std::int64_t{place} * size;
  };
  const auto step = [](const Vector3Of<Pack>& v, double t, const FourPacks<Pack>& rate) -> Vector3Of<Pack> {
    return {v.first + t * rate.first, v.second + t * rate.second, v.third + t * rate.third};
  };
  for (std::int64_t i = std::int64_t{begin} * state::kMomentaSize;
       i < std::int64_t{end} * state::kMomentaSize; ++i) {
    arrays.momentaTo[i] = arrays.momenta[i] + arrays.drift.kick * arrays.rates[i];
  }
  if (!arrays.turns) {
    driftPositions(arrays, begin, end);
    return 0;
  }
  for (std::int32_t place = begin; place < end; place += Pack::kSize) {
    // Lanes to spare do the last owner again.
    const auto at = [&](int lane) { return std::min(place + lane, end - 1); };
    const auto posesOf = [&](int from) {
      return packsOf<Pack>(
          [&](int lane) { return loadFour(rowAt(arrays.poses, at(lane), state::kPoseSize) + from); });
    };
    const auto momentaOf = [&](const double* numbers, int from) {
      return packsOf<Pack>(
          [&](int lane) { return loadFour(rowAt(numbers, at(lane), state::kMomentaSize) + from); });
    };
    // Rows of four, of which a velocity takes the first three and an angular momentum the last three.
    const FourPacks<Pack> position = posesOf(0), q = posesOf(3);
    const FourPacks<Pack> linear = momentaOf(arrays.momenta, 0), angular = momentaOf(arrays.momenta, 2);
    const FourPacks<Pack> pull = momentaOf(arrays.rates, 0), twist = momentaOf(arrays.rates, 2);
    const Pack inverseInertia = Pack([&](int lane) { return arrays.inverseInertia[at(lane)]; });
    const Vector3Of<Pack> v{linear.first, linear.second, linear.third};
    const Vector3Of<Pack> L{angular.second, angular.third, angular.fourth};
    const FourPacks<Pack> torque{twist.second, twist.third, twist.fourth, twist.first};

    const Vector3Of<Pack> way = arrays.drift.time * step(v, arrays.drift.poseKick, pull);
    const Vector3Of<Pack> half =
        Pack(0.5 * arrays.drift.time * inverseInertia) * step(L, arrays.drift.poseKick, torque);
    const Pack square = half.squaredNorm();
    const PackHalfTurn turn(square);
    const Vector3Of<Pack> u = turn.sineOverAngle * half, p{q.second, q.third, q.fourth};
    const Pack w = turn.cosine * q.first - u.dot(p);
    const Vector3Of<Pack> turned = turn.cosine * p + (q.first * u + u.cross(p));
    // A unit quaternion turned by another is one but for rounding: Newton's step to one over its length.
    const Pack lengthSquared = w * w + turned.squaredNorm(), toUnit = 1.5 - 0.5 * lengthSquared;

    const auto poseTo = [&](int from) {
      return [&arrays, &at, rowAt, from](int lane, const Four& row) {
        storeFour(row, rowAt(arrays.posesTo, at(lane), state::kPoseSize) + from);
      };
    };
    const Pack wNext = toUnit * w;
    forRows<Pack>({position.first + way.x(), position.second + way.y(), position.third + way.z(), wNext},
                  poseTo(0));
    forRows<Pack>({wNext, toUnit * turned.x(), toUnit * turned.y(), toUnit * turned.z()}, poseTo(3));

    const Pack::Mask isDone = square < Pack(PackHalfTurn::kLargestSquare) && inverseInertia > 0.0 &&
                              lengthSquared > kNearUnit && lengthSquared < 1.0 / kNearUnit;
    for (int lane = 0; lane < std::min(Pack::kSize, end - place); ++lane) {
      left[leftCount] = place + lane;
      leftCount += !isDone[lane];
    }
  }
  return leftCount;
}

GRANULAR_KERNEL void carryPositions(const CarryArrays& arrays, std::int32_t begin, std::int32_t end) {
  const auto weightOf = [&](int k) { return Four{} + arrays.weights[k]; };
  const Four w0 = weightOf(0), w1 = weightOf(1), w2 = weightOf(2);
  for (std::int64_t place = begin; place < end; ++place) {
    const auto rateOf = [&](int k) { return loadFour(arrays.rates[k] + place * state::kMomentaSize); };
    double* pose = arrays.poses + place * state::kPoseSize;
    const Four before = loadFour(pose);  // the fourth is of the orientation
    storeFour(withFourth(before + (w0 * rateOf(0) + w1 * rateOf(1) + w2 * rateOf(2)), before), pose);
  }
}

}  // namespace
}  // namespace granular::detail
