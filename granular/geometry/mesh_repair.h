// SPDX-License-Identifier: MIT
// Makes the surface of a solid out of a mesh that nearly is one: faces that look the wrong way are turned,
// gaps are closed, repeated faces dropped. What was done is counted. A mesh that cannot mean a solid is
// refused; a sheet can be given a thickness instead.
#pragma once

#include <cstdint>
#include <string>

#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// What repairMesh did.
struct MeshRepair {
  std::int64_t droppedTriangles = 0;  ///< without area, or repeating another
  std::int64_t turnedTriangles = 0;   ///< they looked the other way than their neighbours
  std::int64_t turnedParts = 0;       ///< whole connected parts that were inside out
  std::int64_t closedGaps = 0;        ///< loops of open edges
  std::int64_t closingTriangles = 0;  ///< put into them
  double closingArea = 0.0;           ///< of those, m^2
  MeshFault buriedTriangles = {};     ///< inside the solid: parts overlap. They stay, and count for nothing

  bool isNothing() const {
    return droppedTriangles == 0 && turnedTriangles == 0 && turnedParts == 0 && closedGaps == 0 &&
           buriedTriangles.count == 0;
  }
  /// One line a kind of repair; empty if there was none.
  std::string text() const;
};

/// Gaps may be closed by triangles of at most this part of the area of the mesh: more of it would be guessed
/// than was given.
inline constexpr double kMostClosing = 0.25;

/// The surface of a solid: a mesh that is one comes back as it is. Connected parts that lie inside others
/// keep their side (cavities); all others look outwards. Throws std::invalid_argument with the report of
/// checkMesh if the mesh cannot be used at all, is open by more than kMostClosing, or holds no volume.
TriangleMesh repairMesh(const TriangleMesh& mesh, MeshRepair* repair = nullptr);

/// A shell of the given thickness, m, half of it on either side of the mesh, closed along its open edges.
/// Vertices move along the mean normal of their faces, so that sharp folds come out thinner. Neighbours
/// should look the same way. Throws std::invalid_argument if the thickness is not finite and > 0 or the mesh
/// cannot be used at all.
TriangleMesh makeSheet(const TriangleMesh& mesh, double thickness);

}  // namespace granular
