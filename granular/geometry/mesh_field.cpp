// SPDX-License-Identifier: MIT
#include "granular/geometry/mesh_field.h"

#include <stdexcept>

#include "granular/base/require.h"

namespace granular {
namespace {

const TriangleMesh& checked(const TriangleMesh& mesh) {
  const MeshReport report = checkMesh(mesh);
  if (!report.isSolid()) {
    throw std::invalid_argument("MeshField needs the closed surface of a solid; the mesh has " +
                                report.text());
  }
  return mesh;
}

BandDef bandOf(const MeshFieldDef& def) {
  requirePositive(def.spacing, "MeshFieldDef.spacing", "m");
  requireNotNegative(def.reach, "MeshFieldDef.reach", "m");
  return {.spacing = def.spacing, .lower = -def.reach, .upper = def.reach, .threads = def.threads};
}

}  // namespace

MeshField::MeshField(const TriangleMesh& mesh, const MeshFieldDef& def)
    : exact_(checked(mesh)), band_(exact_, bandOf(def)) {
  for (const Vector3& v : mesh.vertices) boundingRadius_ = std::max(boundingRadius_, v.norm());
  for (const auto& t : mesh.triangles) shownArea_ += 0.5 * doubleAreaVector(mesh, t).cwiseAbs();
}

DistanceSample MeshField::at(const Vector3& p) const {
  if (const auto sample = band_.sample(p)) return *sample;
  const NearestPoint near = exact_.nearest(p);
  const Vector3 away = p - near.point;
  const bool clear = std::abs(near.signedDistance) > 0.0;
  return {near.signedDistance, clear ? Vector3(away / near.signedDistance) : near.normal};
}

bool MeshField::mayBeWithin(const Vector3& p, double reach) const {
  const Box& box = exact_.bounds();
  if ((p.cwiseMax(box.lower).cwiseMin(box.upper) - p).norm() >= reach) return false;
  // Interpolated values are off by less than a voxel.
  return exact_.nearestWithin(p, reach + band_.spacing()).has_value() ||
         exact_.nearest(p).signedDistance < 0.0;
}

}  // namespace granular
