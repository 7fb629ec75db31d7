// SPDX-License-Identifier: MIT
// Rotation of a rigid thing that nothing turns: its angular momentum stays, its orientation moves on. Exact
// where all moments of inertia are equal. Else the kinetic energy is split into its three parts, each of
// which turns the thing about one of its own axes, in a symmetric order (Dullweber, Leimkuhler & McLachlan
// 1997), and three such steps are put together to one of fourth order (Yoshida 1990): symplectic, so that
// energy has no trend; the angular momentum is kept exactly.
#pragma once

#include "granular/base/pose.h"

namespace granular {

/// Turn about `angle`, rad, direction and size, world.
Quaternion turnBy(const Vector3& angle);

/// Orientation after t seconds, from `orientation` (principal frame, unit). angularMomentum: world, kg m^2/s;
/// inverseInertia: principal, 1/(kg m^2).
Quaternion freelyTurned(const Quaternion& orientation, const Vector3& angularMomentum,
                        const Vector3& inverseInertia, double t);

}  // namespace granular
