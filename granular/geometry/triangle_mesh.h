// SPDX-License-Identifier: MIT
// Triangle meshes as two plain arrays, and what can be wrong with them.
// A covering needs the surface of a solid: closed, every face counter-clockwise seen from outside. checkMesh
// finds what is missing before a distance field is built from it, with the first example of each fault.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "granular/base/pose.h"

namespace granular {

struct TriangleMesh {
  std::vector<Vector3> vertices;                       ///< corner i, m
  std::vector<std::array<std::int32_t, 3>> triangles;  ///< corners of face i, counter-clockwise from outside
};

/// One kind of fault: how often, and where first.
struct MeshFault {
  std::int64_t count = 0;
  std::string firstExample;  ///< e.g. "edge 3-7 of triangle 12"; empty when count is 0
};

/// What checkMesh found. The later faults are looked for only if every vertex is finite and every index in
/// range.
struct MeshReport {
  std::int64_t vertexCount = 0;
  std::int64_t triangleCount = 0;
  MeshFault nonFiniteVertices;    ///< a coordinate is infinite or not a number
  MeshFault indicesOutOfRange;    ///< triangles that name a vertex which does not exist
  MeshFault degenerateTriangles;  ///< area below 1e-14 of the longest edge squared, or a repeated corner
  MeshFault slivers;              ///< other triangles whose height is below 1/1000 of their longest edge
  MeshFault duplicateTriangles;   ///< same three corners as an earlier triangle, in any order
  MeshFault openEdges;            ///< edges with one triangle
  MeshFault flippedEdges;         ///< edges whose triangles disagree about which side is outside
  MeshFault crowdedEdges;  ///< edges where more than two triangles meet; allowed if they are consistent
  double area = 0.0;       ///< m^2
  double volume = 0.0;     ///< m^3, negative if the faces look inwards

  /// The arrays can be used at all: something there, finite, in range.
  bool isReadable() const {
    return triangleCount > 0 && nonFiniteVertices.count == 0 && indicesOutOfRange.count == 0;
  }
  /// No edge is open or flipped: there is an inside and an outside.
  bool isClosed() const { return isReadable() && openEdges.count == 0 && flippedEdges.count == 0; }
  /// Closed, but every face looks inwards: turnInsideOut mends it.
  bool isInsideOut() const { return isClosed() && volume < 0.0; }
  /// Closed, and the inside has a volume: what coverMesh needs.
  bool isSolid() const { return isClosed() && volume > 0.0; }
  /// One line a fault; one line in all if there is none.
  std::string text() const;
};

MeshReport checkMesh(const TriangleMesh& mesh);

/// Makes vertices with equal coordinates one, drops triangles that lose a corner by that and vertices that no
/// triangle uses. Keeps the order of what stays. All indices must be in range. Returns the number of vertices
/// removed.
std::int64_t weldVertices(TriangleMesh& mesh);

/// Turns every face round, so that outside becomes inside.
void turnInsideOut(TriangleMesh& mesh);

/// The same mesh seen from `frame`: a vertex p becomes frame.toOwn(p). With MassProperties::principalFrame
/// the mesh comes out centred on its centre of mass, along its principal axes.
TriangleMesh seenFrom(const Pose& frame, TriangleMesh mesh);

/// Adds `more` to `mesh`; nothing is welded.
void append(TriangleMesh& mesh, const TriangleMesh& more);

/// Smallest axis-aligned box around all vertices; an empty mesh gives a box of no size at the origin.
Box boundingBox(const TriangleMesh& mesh);

/// Cross product of two edges of a triangle: outward, its length twice the area, m^2.
inline Vector3 doubleAreaVector(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& t) {
  const Vector3& a = mesh.vertices[t[0]];
  return (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
}

double surfaceArea(const TriangleMesh& mesh);

/// Volume by the divergence theorem, m^3; negative if the faces look inwards. The mesh must be closed.
double signedVolume(const TriangleMesh& mesh);

}  // namespace granular
