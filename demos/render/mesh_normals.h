// SPDX-License-Identifier: MIT
// Normals for shading a triangle mesh: smooth over gentle bends, sharp at edges beyond a crease angle.
#pragma once

#include <array>
#include <vector>

#include "granular/geometry/triangle_mesh.h"

namespace granular_demo {

/// One unit normal for each corner of each triangle.
///
/// A corner averages the triangles that meet at its vertex (vertices at the same place count as one), weighed
/// by their angle there, but only those whose face bends less than `creaseAngleDegrees` from its own.
std::vector<std::array<Eigen::Vector3f, 3>> cornerNormals(const granular::TriangleMesh& mesh,
                                                          double creaseAngleDegrees = 40.0);

}  // namespace granular_demo
