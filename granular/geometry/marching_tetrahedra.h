// SPDX-License-Identifier: MIT
// An iso-surface of a distance band as a closed mesh, by marching tetrahedra (Treece et al. 1999, without
// their regularisation). Each voxel is cut into six tetrahedra around one diagonal, the same way everywhere,
// so that neighbours agree on every face; a crossed edge has one vertex, found by its key, so that nothing
// needs welding.
#pragma once

#include "granular/geometry/signed_distance_band.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// The surface where the distance equals `offset`, m: positive outside the solid, negative inside. Faces look
/// the way the distance grows. Watertight; empty if nothing lies that deep. Error of a vertex: that of the
/// trilinear distance, (spacing)^2 times curvature, plus 1/1000 spacing where the surface would pass through
/// a node. Throws std::invalid_argument if the offset is not within the band.
TriangleMesh marchingTetrahedra(const SignedDistanceBand& band, double offset);

}  // namespace granular
