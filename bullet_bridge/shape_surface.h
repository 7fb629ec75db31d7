// SPDX-License-Identifier: MIT
// The surface of a Bullet collision shape as triangles, in the shape's own frame (the body's frame), m.
// The geometry is the one the shape means, after local scaling, read from the shape's own getters: a box or
// cylinder has its full size, a hull or cone is taken without the collision margin that Bullet puts around
// it, so a covered hull rests lower than in plain Bullet by up to that margin.
#pragma once

#include <string>
#include <vector>

#include "bullet_bridge/precision.h"
#include "granular/base/pose.h"
#include "granular/geometry/triangle_mesh.h"

class btCollisionShape;

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

/// The piece of an endless plane that is wanted: a square slab whose upper face lies in the plane.
struct PlanePatch {
  granular::Vector3 center =
      granular::Vector3::Zero();  ///< m, shape frame; put onto the plane along its normal
  double size = 0.0;              ///< edge length, m; > 0 where the shape is a plane
  double thickness = 0.0;         ///< m; 0: a fiftieth of `size`
};

struct SurfaceDef {
  int segments = 64;      ///< sides of a full circle, >= 8: 64 gives 0.2 % less than the volume of a cylinder
  PlanePatch plane = {};  ///< for btStaticPlaneShape
};

/// One mesh for each part that bounds a solid by itself: the children of compounds, nested ones too, else
/// one. All but open triangle meshes (terrain, and any mesh its maker left open) come out closed,
/// counter-clockwise from outside. Known: sphere, box, capsule, cylinder and cone on any axis, hull and other
/// polyhedra with vertices, multi-sphere (the hull of its spheres), uniform scaling, compound, triangle
/// meshes, heightfield, GImpact, plane. Throws std::invalid_argument with the shape's name for any other, and
/// for a plane without a patch.
std::vector<granular::TriangleMesh> shapeParts(const btCollisionShape& shape, const SurfaceDef& def = {});

/// The same parts in one mesh. Parts that reach into one another keep their inner faces.
granular::TriangleMesh shapeSurface(const btCollisionShape& shape, const SurfaceDef& def = {});

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
