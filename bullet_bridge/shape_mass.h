// SPDX-License-Identifier: MIT
// Volume, centre of mass and inertia of the solid that a collision shape means. Bullet's own
// calculateLocalInertia takes the bounding box for many shapes, with the margin, and never moves the centre:
// bullet_bridge/README.md has the two side by side.
#pragma once

#include "bullet_bridge/shape_surface.h"
#include "granular/geometry/mass_properties.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

/// In closed form for box, sphere, capsule, cylinder and cone; exactly for hulls and closed triangle meshes;
/// of a mesh of 256 sides for multi-spheres and other convex shapes; children of compounds by volume, each in
/// full, also where two reach into one another. Shape frame.
/// @param mass  kg, finite and > 0, spread evenly
/// Throws std::invalid_argument if the shape encloses no volume, or is unknown.
granular::MassProperties shapeMass(const btCollisionShape& shape, double mass);

/// The same for a closed mesh.
granular::MassProperties surfaceMass(const granular::TriangleMesh& mesh, double mass);

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
