// SPDX-License-Identifier: MIT
// Exact signed distance from a point to a mesh: the nearest point of the nearest triangle, found in a tree of
// boxes, with the sign of the angle-weighted pseudo-normal there (Baerentzen & Aanaes 2002), which is right
// on faces, edges and corners alike, or of the winding number, which is right for surfaces that cross
// themselves. The distance band samples it; the covering uses it where a sample grid is not exact enough.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "granular/geometry/triangle_mesh.h"
#include "granular/geometry/winding_number.h"

namespace granular {

/// The point of a surface nearest to a query point.
struct NearestPoint {
  double signedDistance = 0.0;       ///< m, negative inside
  Vector3 point = Vector3::Zero();   ///< on the surface, m
  Vector3 normal = Vector3::Zero();  ///< unit pseudo-normal of the face, edge or corner there, outward
  std::int32_t triangle = -1;
};

/// How inside is told from outside.
enum class MeshSign {
  PseudoNormal,   ///< right for closed surfaces that do not cross themselves; costs nothing
  WindingNumber,  ///< right where parts overlap, and as right as can be near gaps; several times the time
};

class MeshDistance {
 public:
  /// Copies what it needs. The mesh must be readable (MeshReport::isReadable), or std::invalid_argument is
  /// thrown; signs mean something only if it is closed as well. Zero-area triangles count by their edges.
  explicit MeshDistance(const TriangleMesh& mesh, MeshSign sign = MeshSign::PseudoNormal);

  /// Nearest point. The answer's bits depend on p alone: `hint`, a triangle thought to be near (say that of
  /// the last query), only saves time.
  NearestPoint nearest(const Vector3& p, std::int32_t hint = -1) const;

  /// The same, but nothing if the surface is not nearer than `distance` (m): much cheaper if it is not.
  std::optional<NearestPoint> nearestWithin(const Vector3& p, double distance, std::int32_t hint = -1) const;

  const Box& bounds() const { return bounds_; }

 private:
  // Where on a triangle: its face, one of its edges (edge k runs from corner k to corner k + 1), one of its
  // corners.
  enum Feature : std::int8_t { kFace, kEdge0, kEdge1, kEdge2, kCorner0, kCorner1, kCorner2 };
  struct Triangle {
    std::array<Vector3, 3> corner;
    std::int32_t index;  // in the mesh
    bool flat;           // has no area: met by its edges only
  };
  struct TreeNode {
    Vector3 lower, upper;
    std::int32_t first = 0;  // leaf: first triangle; else: second child, the first one follows this node
    std::int32_t count = 0;  // leaf: triangles; else 0
  };
  struct Candidate {
    double squaredDistance;
    Vector3 point;
    std::int32_t slot = -1;  // in triangles_
    Feature feature = kFace;
  };

  static Candidate nearestOnTriangle(const Triangle& t, const Vector3& p);
  static double squaredDistanceToBox(const TreeNode& node, const Vector3& p);
  void computeNormals(const TriangleMesh& mesh);
  std::int32_t buildTree(std::int32_t first, std::int32_t last);
  void consider(std::int32_t slot, const Vector3& p, Candidate& best) const;
  NearestPoint finish(const Candidate& best, const Vector3& p) const;

  std::vector<Triangle> triangles_;              // in the order of the leaves
  std::vector<std::int32_t> slotOfTriangle_;     // mesh index -> place in triangles_
  std::vector<std::array<Vector3, 7>> normals_;  // of mesh triangle t, one a Feature
  std::vector<TreeNode> nodes_;
  std::optional<WindingNumber> winding_;
  Box bounds_;
};

}  // namespace granular
