// SPDX-License-Identifier: MIT
// Points spread evenly over a mesh.
#pragma once

#include <vector>

#include "granular/geometry/triangle_mesh.h"

namespace granular::detail {

struct SurfacePoint {
  Vector3 point, normal;
};

/// One point for every `areaEach` of the surface, triangles in their order; within triangles the points
/// follow the additive recurrence of Roberts (2018), which spreads them far more evenly than random ones.
std::vector<SurfacePoint> sampleSurface(const TriangleMesh& mesh, double areaEach);

}  // namespace granular::detail
