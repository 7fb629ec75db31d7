// SPDX-License-Identifier: MIT
// Shares the surface of a mesh out among the particles that cover it (Covering::pieces).
#pragma once

#include <vector>

#include "granular/base/parallel.h"
#include "granular/geometry/covering.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular::detail {

/// Particles of one radius, r, on a mesh.
struct CoveringLayer {
  const std::vector<Vector3>& positions;  ///< m, frame of the mesh
  const std::vector<double>& offsets;     ///< of each from the mesh, m, negative inside
  double radius;                          ///< m
  double farthest;                        ///< of r: surface that far from every particle's depth is nobody's
};

/// Every part of the mesh goes to the particle whose centre is nearest, and is raised to where the particle's
/// envelope is. Triangles are cut up and taken as they are, so that the pieces make up the mesh exactly; what
/// is too small for that is sampled, and the samples of about the same normal make up a rectangle.
std::vector<SurfacePiece> shareSurface(const TriangleMesh& mesh, const CoveringLayer& layer,
                                       const Executor& executor);

}  // namespace granular::detail
