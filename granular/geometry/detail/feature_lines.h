// SPDX-License-Identifier: MIT
// Where an offset surface has creases: beside the sharp edges of its mesh. Inside a solid it follows the
// convex ones, outside the concave ones. Particles placed along these lines keep edges and corners as sharp
// as particles of their size can.
#pragma once

#include <vector>

#include "granular/geometry/mesh_distance.h"

namespace granular::detail {

struct FeatureDef {
  double offset = 0.0;       ///< of the offset surface, m, negative inside
  double spacing = 0.0;      ///< between points, m, > 0
  double sharpDegrees = 40;  ///< an edge is sharp where the normals of its two faces differ by more
};

/// Points evenly along the creases, with one at each of their ends, at the offset to 1/1000 of the spacing.
std::vector<Vector3> creasePoints(const TriangleMesh& mesh, const MeshDistance& distance,
                                  const FeatureDef& def);

/// Points on all sharp convex edges themselves, about `spacing` apart.
std::vector<Vector3> sharpEdgePoints(const TriangleMesh& mesh, const FeatureDef& def);

}  // namespace granular::detail
