// SPDX-License-Identifier: MIT
// Ways to make a closed mesh from a few numbers: pushing a polygon along an axis, joining a row of sections,
// filling cells of a lattice.
#pragma once

#include <functional>
#include <vector>

#include "granular/geometry/triangle_mesh.h"

namespace granular_meshes {

using granular::TriangleMesh;
using granular::Vector3;

/// Joins closed polygons of equal length, one after the other, and closes both ends. Sections turn
/// counter-clockwise seen against the way from the first to the last; the ends may be concave.
TriangleMesh loft(const std::vector<std::vector<Vector3>>& sections);

/// The union of the cells (i, j, k) between neighbouring cuts for which `isFilled` holds; at least one cell.
/// Cells that meet must share a face, not an edge or a corner alone.
TriangleMesh latticeSolid(const std::vector<double>& x, const std::vector<double>& y,
                          const std::vector<double>& z, const std::function<bool(int, int, int)>& isFilled);

}  // namespace granular_meshes
