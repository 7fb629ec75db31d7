// SPDX-License-Identifier: MIT
// The surface of a Bullet collision shape as triangles, in the shape's own frame (the body's frame), m.
// The geometry is the one the shape means, after local scaling, read from the shape's own getters: a box or
// cylinder has its full size, a hull or cone is taken without the collision margin that Bullet puts around
// it, so a covered hull rests lower than in plain Bullet by up to that margin.
#pragma once

#include <cstdint>
#include <vector>

#include "bullet_bridge/precision.h"
#include "granular/base/pose.h"
#include "granular/geometry/triangle_mesh.h"

class btCollisionShape;

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

/// The piece of an endless plane that is wanted: a square in it.
struct PlanePatch {
  granular::Vector3 center =
      granular::Vector3::Zero();  ///< m, shape frame; put onto the plane along its normal
  double size = 0.0;              ///< edge length, m; > 0 where the shape is a plane
};

struct SurfaceDef {
  int segments = 64;      ///< sides of a full circle, >= 8: 64 gives 0.2 % less than the volume of a cylinder
  PlanePatch plane = {};  ///< for btStaticPlaneShape
};

/// What a part of a surface bounds.
enum class PartKind : std::uint8_t {
  Solid,   ///< closed, counter-clockwise from outside
  Ground,  ///< open, the solid lies below: every face looks to the side of ShapePart::up
  Sheet,   ///< open, with two sides and no inside
};

struct ShapePart {
  granular::TriangleMesh mesh = {};
  PartKind kind = PartKind::Solid;
  granular::Vector3 up =
      granular::Vector3::UnitY();  ///< unit, for Ground: the heightfield's axis, the plane's normal
};

/// The kind of a mesh that comes without one: Solid if it is closed (and turned, should it look inwards),
/// else Sheet. A mesh that cannot be read is left to whoever uses it.
ShapePart partOf(granular::TriangleMesh mesh);

/// One part for each solid or sheet: the children of compounds, nested ones too, else one. Known: sphere,
/// box, capsule, cylinder and cone on any axis, hull and other polyhedra with vertices, multi-sphere (the
/// hull of its spheres), any other convex shape by its support function, uniform scaling, compound, triangle
/// meshes of all kinds, GImpact mesh and compound, heightfield, plane. Throws std::invalid_argument with the
/// shape's name for any other, for a plane without a patch, and for a shape without a triangle or child.
std::vector<ShapePart> shapeParts(const btCollisionShape& shape, const SurfaceDef& def = {});

/// The same parts in one mesh. Parts that reach into one another keep their inner faces.
granular::TriangleMesh shapeSurface(const btCollisionShape& shape, const SurfaceDef& def = {});

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
