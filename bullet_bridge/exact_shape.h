// SPDX-License-Identifier: MIT
// Bullet shapes that the core meets as they are, without particles.
#pragma once

#include "bullet_bridge/layer_door.h"
#include "granular/geometry/exact_surface.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

struct ExactShape {
  granular::ExactSurface surface;
  granular::Pose frame = {};    ///< of the surface as the core has it, in Bullet's body frame
  double boundingRadius = 0.0;  ///< about the body's origin, m; 0 for a plane
};

/// Box, sphere, capsule, cylinder and plane by formula, any other shape of one closed part by the distance to
/// its triangles, sampled `spacing`, m, apart. Throws std::invalid_argument with the shape's name for what
/// has no inside or several parts, and for a plane that is dynamic.
ExactShape exactShape(const btRigidBody& body, const CoverBodyDef& def, double spacing, int threads);

/// Whether particles of other bodies meet the exact surface of a body that has particles.
bool meetsBodiesExactly(const btRigidBody& body, const CoverBodyDef& def);

/// Throws std::invalid_argument for a setting that speaks of particles where there are none.
void checkExactDef(const CoverBodyDef& def);

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
