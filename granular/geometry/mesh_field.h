// SPDX-License-Identifier: MIT
// The signed distance of a closed mesh as particles meet it: samples near the surface, trilinear between them
// (SignedDistanceBand: memory by area, not by volume), and beyond them the exact distance. Edges and corners
// are as sharp as the samples show them: rounded by about half the spacing. Faces that lie along the samples
// are exact.
#pragma once

#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/signed_distance_band.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular {

struct MeshFieldDef {
  double spacing = 0.0;  ///< between samples, m, > 0; about half the radius of the particles that meet it
  /// How far from the surface there are samples, on both sides, m, >= 0: the largest radius of those
  /// particles. Beyond, a look at it costs some 20 times as much.
  double reach = 0.0;
  int threads = 1;  ///< while it is made; any number gives the same bits
};

class MeshField {
 public:
  /// Throws std::invalid_argument if the mesh is not the closed surface of a solid, or for a bad def.
  MeshField(const TriangleMesh& mesh, const MeshFieldDef& def);

  /// Value and its slope; the slope of what is interpolated is not quite 1.
  DistanceSample at(const Vector3& p) const;
  /// False only if p is not nearer to the surface than `reach`, m, nor inside.
  bool mayBeWithin(const Vector3& p, double reach) const;

  double boundingRadius() const { return boundingRadius_; }  ///< about the origin, m
  const Vector3& shownArea() const { return shownArea_; }    ///< along each axis, both sides together, m^2
  std::size_t bytes() const { return band_.bytes(); }        ///< of the samples

 private:
  MeshDistance exact_;
  SignedDistanceBand band_;
  double boundingRadius_ = 0.0;
  Vector3 shownArea_ = Vector3::Zero();
};

}  // namespace granular
