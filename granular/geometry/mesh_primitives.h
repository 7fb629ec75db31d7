// SPDX-License-Identifier: MIT
// Meshes of simple solids, closed and outward (but for the plane patch), centred on the origin; lengths in m.
// Round ones are inscribed: their vertices lie on the solid, so they hold a little less than its volume.
#pragma once

#include <utility>
#include <vector>

#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// Box of edge lengths `size`, each edge cut into `divisions` parts.
TriangleMesh makeBox(const Vector3& size, int divisions = 1);

/// Sphere from an icosahedron, each face cut in four `subdivisions` times: 20 x 4^subdivisions triangles.
TriangleMesh makeIcosphere(double radius, int subdivisions);

/// Solid of revolution about z. `profile` lists (radius, z) from the lowest point to the highest; it begins
/// and ends on the axis with radius exactly 0 and every radius between is > 0. `segments` sides, at least 3.
TriangleMesh makeRevolution(const std::vector<std::pair<double, double>>& profile, int segments);

/// Cylinder along z, `height` from end to end.
TriangleMesh makeCylinder(double radius, double height, int segments);

/// Cone along z, apex up; the origin is halfway up.
TriangleMesh makeCone(double radius, double height, int segments);

/// Capsule along z: a cylinder of `cylinderHeight` with a half sphere at each end.
TriangleMesh makeCapsule(double radius, double cylinderHeight, int segments);

/// Torus about z: a tube of radius `tubeRadius` round a circle of radius `ringRadius`.
TriangleMesh makeTorus(double ringRadius, double tubeRadius, int ringSegments, int tubeSegments);

/// Rectangle in the plane z = 0, normal +z: an open mesh.
TriangleMesh makePlanePatch(double sizeX, double sizeY, int divisions = 1);

}  // namespace granular
