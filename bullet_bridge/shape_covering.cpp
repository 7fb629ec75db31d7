// SPDX-License-Identifier: MIT
#include "bullet_bridge/shape_covering.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "granular/geometry/mesh_distance.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace {

using granular::CoverDef;
using granular::Covering;
using granular::CoverReport;
using granular::MeshDistance;
using granular::TriangleMesh;
using granular::Vector3;

double offsetOf(const CoverDef& def) {
  return def.offset.value_or(-def.particleRadius);
}

/// Ground made a solid: walls from its border down to a flat floor `depth` below its lowest point.
TriangleMesh withFloor(const ShapePart& ground, double depth) {
  TriangleMesh solid = ground.mesh;
  const auto count = static_cast<std::int32_t>(ground.mesh.vertices.size());
  double floor = ground.mesh.vertices.front().dot(ground.up);
  for (const Vector3& v : ground.mesh.vertices) floor = std::min(floor, v.dot(ground.up));
  floor -= depth;
  for (const Vector3& v : ground.mesh.vertices)
    solid.vertices.push_back(v - (v.dot(ground.up) - floor) * ground.up);
  std::map<std::pair<std::int32_t, std::int32_t>, int> edges;  // directed
  for (const auto& t : ground.mesh.triangles) {
    solid.triangles.push_back({t[0] + count, t[2] + count, t[1] + count});
    for (int i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, uses] : edges) {
    const auto [a, b] = edge;
    if (edges.contains({b, a})) continue;
    solid.triangles.push_back({b, a, a + count});
    solid.triangles.push_back({b, a + count, b + count});
  }
  return solid;
}

/// The floor is so deep that its particles, and those low on the walls, are told by their distance from the
/// ground.
Covering coverGround(const ShapePart& ground, const CoverDef& def, CoverReport& report) {
  const double reach = std::abs(offsetOf(def)) + 0.5 * def.particleRadius;
  Covering covering =
      granular::coverMesh(withFloor(ground, 6.0 * def.particleRadius + 2.0 * reach), def, &report);
  const MeshDistance distance(ground.mesh);
  granular::keepOnly(covering,
                     [&](const Vector3& p, double) { return distance.nearestWithin(p, reach).has_value(); });
  return covering;
}

}  // namespace

Covering coverParts(const std::vector<ShapePart>& parts, const CoverDef& def,
                    std::vector<CoverReport>* reports) {
  std::vector<std::pair<std::size_t, MeshDistance>> solids;
  if (parts.size() > 1) {
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (parts[i].kind == PartKind::Solid) solids.emplace_back(i, MeshDistance(parts[i].mesh));
    }
  }
  const double deepest = std::min(0.0, offsetOf(def)) - 0.5 * def.particleRadius;
  Covering all;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    CoverReport report;
    CoverDef own = def;
    if (parts[i].kind != PartKind::Sheet) own.sheetThickness.reset();
    Covering covering = parts[i].kind == PartKind::Ground ? coverGround(parts[i], own, report)
                                                          : granular::coverMesh(parts[i].mesh, own, &report);
    granular::keepOnly(covering, [&](const Vector3& p, double) {
      return std::none_of(solids.begin(), solids.end(), [&](const auto& solid) {
        return solid.first != i && solid.second.nearest(p).signedDistance < deepest;
      });
    });
    report.particleCount = static_cast<std::int64_t>(covering.positions.size());
    if (reports) reports->push_back(report);
    granular::append(all, covering);
  }
  return all;
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
