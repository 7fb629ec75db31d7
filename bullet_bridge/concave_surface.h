// SPDX-License-Identifier: MIT
// Surfaces of Bullet's shapes that are no solid by nature: planes, heightfields, triangle meshes.
#pragma once

#include "bullet_bridge/shape_surface.h"

class btConcaveShape;
class btHeightfieldTerrainShape;
class btStaticPlaneShape;

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

/// Ground: the patch, solid below. Throws std::invalid_argument if the patch has no size.
ShapePart planePart(const btStaticPlaneShape& plane, const PlanePatch& patch);

/// Ground, solid on the lower side of the up axis: whatever the winding of its triangles, which Bullet turns
/// with the axis and with setFlipTriangleWinding. Heights are read by Bullet itself, with the type it was
/// told.
ShapePart heightfieldPart(const btHeightfieldTerrainShape& field);

/// Welded; Solid if it is closed, else Sheet. A mesh mirrored by its scaling is turned. Without the margin.
ShapePart triangleMeshPart(const btConcaveShape& shape);

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
