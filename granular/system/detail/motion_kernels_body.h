// SPDX-License-Identifier: MIT
// Grains between the state and the contacts: states to rows, forces to rates; included once by the file for
// each processor.
#pragma once

#include <algorithm>
#include <cstdint>

#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/layout.h"
#include "granular/system/detail/pack_rows.h"

namespace granular::detail {
namespace {

/// The larger one of two in every lane; what is not a number counts as none.
Pack larger(const Pack& largest, const Pack& value) {
  return select(value > largest, value, largest);
}

double largestOf(const Pack& pack) {
  double largest = pack[0];
  for (int lane = 1; lane < Pack::kSize; ++lane) largest = std::max(largest, pack[lane]);
  return largest;
}

GRANULAR_KERNEL PlacedExtremes placeSpheres(const PlaceArrays& arrays, std::int32_t begin, std::int32_t end) {
  Pack beyond = 0.0, speed = 0.0;
  for (std::int32_t place = begin; place < end; place += Pack::kSize) {
    // Lanes to spare do the last owner again.
    const auto at = [&](int lane) { return std::min(place + lane, end - 1); };
    const auto momentaOf = [&](int from) {
      return packsOf<Pack>([&](int lane) {
        return loadFour(arrays.momenta + std::int64_t{at(lane)} * state::kMomentaSize + from);
      });
    };
    const auto particleOf = [&](int lane) {
      return withFourth(loadFour(arrays.poses + std::int64_t{at(lane)} * state::kPoseSize),
                        loadFour(&arrays.particles[at(lane)].x));
    };
    // Rows of four, of which a velocity takes the first three and an angular momentum the last three.
    const FourPacks<Pack> linear = momentaOf(0), angular = momentaOf(2), particle = packsOf<Pack>(particleOf);
    const Pack inverseInertia = Pack([&](int lane) { return arrays.inverseInertia[at(lane)]; });
    const Vector3Of<Pack> v{linear.first, linear.second, linear.third};
    const Vector3Of<Pack> w = inverseInertia * Vector3Of<Pack>{angular.second, angular.third, angular.fourth};
    speed = larger(speed, sqrt(v.squaredNorm()) + sqrt(w.squaredNorm()) * particle.fourth);
    if (arrays.listed != nullptr) {
      const FourPacks<Pack> then =
          packsOf<Pack>([&](int lane) { return loadFour(&arrays.listed[at(lane)].x); });
      const Vector3Of<Pack> way{particle.first - then.first, particle.second - then.second,
                                particle.third - then.third};
      beyond = larger(beyond, way.squaredNorm() - then.fourth);
    }
    forRows<Pack>({w.x(), w.y(), w.z(), w.z()}, [&](int lane, const Four& row) {
      OwnerRow& owner = arrays.owners[at(lane)];
      double* spin = owner.angularVelocity.data();  // what lies behind it stays
      storeFour(withFourth(row, loadFour(spin)), spin);
      const Four velocity = loadFour(arrays.momenta + std::int64_t{at(lane)} * state::kMomentaSize);
      storeFour(withFourth(velocity, loadFour(owner.velocity.data())), owner.velocity.data());
      storeFour(particleOf(lane), &arrays.particles[at(lane)].x);
    });
  }
  return {largestOf(beyond), largestOf(speed)};
}

GRANULAR_KERNEL void accelerateGrains(const OwnerRow* owners, const PatchWrench* wrench,
                                      const Vector3& gravity, std::int32_t begin, std::int32_t end,
                                      double* rates, double* damping) {
  const Four pull = {gravity.x(), gravity.y(), gravity.z(), 0.0};
  for (std::int32_t place = begin; place < end; ++place, ++wrench) {
    double* rate = rates + std::int64_t{place} * state::kMomentaSize;
    const Four torque = loadFour(wrench->torque.data());
    const Four acceleration = owners[place].inverseMass * loadFour(wrench->force.data()) + pull;
    damping[place] = owners[place].inverseMass * wrench->damping;
    storeFour(acceleration, rate);
    storeFour(__builtin_shufflevector(acceleration, torque, 2, 4, 5, 6), rate + 2);
  }
}

GRANULAR_KERNEL void errorsOfSpheres(const double* errors, const double* inverseInertia,
                                     const ParticleRow* particles, double seconds, std::int32_t begin,
                                     std::int32_t end, double* ways) {
  for (std::int32_t place = begin; place < end; place += Pack::kSize) {
    // Lanes to spare do the last one again.
    const auto at = [&](int lane) { return std::min(place + lane, end - 1); };
    const auto errorsOf = [&](int from) {
      return packsOf<Pack>(
          [&](int lane) { return loadFour(errors + std::int64_t{at(lane)} * state::kMomentaSize + from); });
    };
    // Rows of four, of which a velocity takes the first three and an angular momentum the last three.
    const FourPacks<Pack> linear = errorsOf(0), angular = errorsOf(2);
    const Vector3Of<Pack> v{linear.first, linear.second, linear.third};
    const Vector3Of<Pack> L{angular.second, angular.third, angular.fourth};
    const Pack reach = Pack([&](int lane) { return particles[at(lane)].radius; });
    const Pack spin = Pack([&](int lane) { return inverseInertia[at(lane)]; }) * sqrt(L.squaredNorm());
    const Pack way = seconds * (sqrt(v.squaredNorm()) + spin * reach);
    for (int lane = 0; lane < Pack::kSize; ++lane) ways[at(lane) - begin] = way[lane];
  }
}

}  // namespace
}  // namespace granular::detail
