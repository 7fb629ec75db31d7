// SPDX-License-Identifier: MIT
// Parts of space to be filled with grains, or to pour grains from.
#pragma once

#include <functional>

#include "granular/base/pose.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// A part of space to be filled. Any other region is made by giving these two members.
struct FillRegion {
  Box bounds;  ///< encloses the region, m, world frame
  std::function<double(const Vector3&)>
      depth;  ///< distance to the region's border, m, > 0 inside: a particle
              ///< belongs to the region if depth(centre) >= its radius
};

FillRegion boxRegion(const Box& box);
/// A box of the given size round a pose's position, turned by its orientation.
FillRegion boxRegion(const Pose& middle, const Vector3& size);
FillRegion ballRegion(const Vector3& center, double radius);
/// Upright along `axis` (any length > 0) from the middle of its foot.
FillRegion cylinderRegion(const Vector3& foot, const Vector3& axis, double radius, double height);
/// A heap: foot radius `radius`, tip at `height` along `axis`.
FillRegion coneRegion(const Vector3& foot, const Vector3& axis, double radius, double height);
/// A cone cut off at `height`, where its radius is `topRadius`; one of the two radii may be 0.
FillRegion frustumRegion(const Vector3& foot, const Vector3& axis, double footRadius, double topRadius,
                         double height);

/// A layer on an inclined plane.
struct SlopeDef {
  Vector3 foot = Vector3::Zero();  ///< middle of the layer's lower end, on the plane, m
  Vector3 uphill = {1, 0, 0};      ///< any length > 0; only its part across `up` counts
  Vector3 up = {0, 1, 0};          ///< any length > 0
  double angleDegrees = 0.0;       ///< of the plane to the horizontal, [0, 90)
  double length = 0.0;             ///< along the slope, m, > 0
  double width = 0.0;              ///< across, m, > 0
  double depth = 0.0;              ///< of the layer, along the plane's normal, m, > 0
};
FillRegion slopeRegion(const SlopeDef& def);

/// The inside of a closed mesh. Throws std::invalid_argument if the mesh is not the surface of a solid.
FillRegion meshRegion(const TriangleMesh& mesh);

}  // namespace granular
