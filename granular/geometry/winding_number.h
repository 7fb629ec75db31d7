// SPDX-License-Identifier: MIT
// How often a surface winds round a point (Jacobson, Kavan & Sorkine-Hornung 2013): 1 inside a closed
// surface, 0 outside, 2 where two solids overlap, in between near holes. It tells inside from outside where
// pseudo-normals cannot: in surfaces that cross themselves or have gaps. Far parts count as one dipole each
// (Barill et al. 2018), so that a query costs the logarithm of the number of triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "granular/geometry/triangle_mesh.h"

namespace granular {

class WindingNumber {
 public:
  /// Copies what it needs. All indices must be in range and all vertices finite.
  explicit WindingNumber(const TriangleMesh& mesh);

  /// Within 0.05 of the exact sum of the solid angles; exact near the surface but for far parts.
  double at(const Vector3& p) const;

  /// At least half a turn.
  bool isInside(const Vector3& p) const { return at(p) > 0.5; }

 private:
  struct Triangle {
    Vector3 a, b, c;
  };
  struct Node {
    Vector3 center = Vector3::Zero();      // of area
    Vector3 areaVector = Vector3::Zero();  // sum over the triangles, outward
    double radius = 0.0;                   // of the ball round the centre that holds them
    std::int32_t first = 0;  // leaf: first triangle; else: second child, the first one follows this node
    std::int32_t count = 0;  // leaf: triangles; else 0
  };
  std::int32_t build(std::int32_t first, std::int32_t last);

  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
};

/// Solid angle of triangle a, b, c seen from p over 4 pi; positive if p sees its back (Van Oosterom &
/// Strackee 1983).
double windingOfTriangle(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p);

/// Triangles whose outer side lies inside the solid somewhere: parts overlap, or a surface crosses itself.
/// Faces must look outwards. Looked for at some 4000 places, evenly over the area, and once a triangle; of
/// more than 20,000 triangles only every so many are looked at.
MeshFault findBuriedTriangles(const TriangleMesh& mesh, const WindingNumber& winding);

}  // namespace granular
