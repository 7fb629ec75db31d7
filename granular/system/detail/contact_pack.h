// SPDX-License-Identifier: MIT
// Several contacts between round particles at a time: from the rows that they lie in to packs of numbers, and
// the geometry of eqs. 1-3. Laws without memory then run on packs as they run on single numbers.
#pragma once

#include <array>

#include "granular/base/pack.h"
#include "granular/contact/pair_law.h"
#include "granular/search/candidate_list.h"
#include "granular/system/detail/owner_row.h"

namespace granular::detail {

/// Where the numbers of each lane's contact are.
struct ContactRows {
  std::array<const ParticleRow*, kPackSize> particle1, particle2;
  std::array<const OwnerRow*, kPackSize> owner1, owner2;
  std::array<const PairLaw*, kPackSize> law;
};

/// As ContactGeometry; xi is 0 where particles do not touch after all.
struct ContactGeometryPack {
  Pack xi, smallerRadius;
  Vector3Of<Pack> N, point, V;
};

/// Three numbers a lane, from where of(lane) points to.
template <class Function>
Vector3Of<Pack> vectorsOf(Function&& of) {
  return {packOf([&](int lane) { return of(lane)[0]; }), packOf([&](int lane) { return of(lane)[1]; }),
          packOf([&](int lane) { return of(lane)[2]; })};
}

inline ContactGeometryPack geometryOf(const ContactRows& rows) {
  const Pack radius1 = packOf([&](int lane) { return rows.particle1[lane]->radius; });
  const Pack radius2 = packOf([&](int lane) { return rows.particle2[lane]->radius; });
  const Vector3Of<Pack> x1 = vectorsOf([&](int lane) { return &rows.particle1[lane]->x; });
  const Vector3Of<Pack> apart = vectorsOf([&](int lane) { return &rows.particle2[lane]->x; }) - x1;
  const Pack distance = sqrt(apart.squaredNorm());
  const auto isClear = distance > 0.0;  // else any direction does, as long as it is always the same
  ContactGeometryPack g;
  g.xi = max(Pack(0.0), radius1 + radius2 - distance);  // eq. 1
  g.smallerRadius = min(radius1, radius2);
  g.N = {select(isClear, apart.x() / distance, 0.0), select(isClear, apart.y() / distance, 1.0),
         select(isClear, apart.z() / distance, 0.0)};  // eq. 2
  g.point = x1 + (radius1 - 0.5 * g.xi) * g.N;
  const auto velocityOf = [&](const std::array<const OwnerRow*, kPackSize>& owner) {
    const Vector3Of<Pack> arm = g.point - vectorsOf([&](int lane) { return owner[lane]->center.data(); });
    const Vector3Of<Pack> spin = vectorsOf([&](int lane) { return owner[lane]->angularVelocity.data(); });
    return Vector3Of<Pack>(vectorsOf([&](int lane) { return owner[lane]->velocity.data(); }) +
                           spin.cross(arm));
  };
  g.V = velocityOf(rows.owner1) - velocityOf(rows.owner2);  // eq. 3
  return g;
}

/// What laws without memory read.
inline NormalConstantsOf<Pack> normalConstantsOf(const ContactRows& rows) {
  const auto of = [&](double NormalConstants::*constant) {
    return packOf([&](int lane) { return rows.law[lane]->normal.*constant; });
  };
  return {of(&NormalConstants::kr), of(&NormalConstants::kd), of(&NormalConstants::smallestForce),
          of(&NormalConstants::stiffnessPerMass), of(&NormalConstants::fixedUrgency)};
}
inline ShearConstantsOf<Pack> shearConstantsOf(const ContactRows& rows) {
  const auto of = [&](double ShearConstants::*constant) {
    return packOf([&](int lane) { return rows.law[lane]->shear.*constant; });
  };
  return {.mu = of(&ShearConstants::mu), .viscosity = of(&ShearConstants::viscosity)};
}

}  // namespace granular::detail
