// SPDX-License-Identifier: MIT
#include "granular/geometry/detail/feature_lines.h"

#include <cmath>
#include <map>
#include <numbers>

#include "granular/geometry/detail/mesh_sides.h"
#include "granular/geometry/detail/point_grid.h"

namespace granular::detail {
namespace {

constexpr double kLook = 0.1;        // of the spacing: how finely a line is looked at
constexpr double kOnSurface = 1e-3;  // of the spacing
constexpr double kNear = 0.45;       // of the spacing: points this near to an earlier one are left out

struct SharpEdge {
  std::int32_t from, to;
  Vector3 shift;  // of the crease, for an offset of one metre
  bool isConvex;
};

std::vector<SharpEdge> findSharpEdges(const TriangleMesh& mesh, double sharpDegrees) {
  std::vector<SharpEdge> edges;
  const double most = std::cos(sharpDegrees * std::numbers::pi / 180.0);
  const std::vector<MeshSide> sides = sortedSides(mesh.triangles);
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    const auto& one = mesh.triangles[sides[first].triangle];
    const auto& other = mesh.triangles[sides[first + 1].triangle];
    const Vector3 n1 = doubleAreaVector(mesh, one).normalized(),
                  n2 = doubleAreaVector(mesh, other).normalized();
    const double cosine = n1.dot(n2);
    // Faces that turn right back have no crease at a finite distance.
    if (!(cosine < most) || cosine < -0.98) return;
    const Vector3& opposite = mesh.vertices[other[(sides[first + 1].corner + 2) % 3]];
    const bool isConvex = (opposite - mesh.vertices[sides[first].low]).dot(n1) < 0.0;
    edges.push_back({sides[first].low, sides[first].high, (n1 + n2) / (1.0 + cosine), isConvex});
  });
  return edges;
}

/// The same edges in chains: each starts where another ends, as far as no third meets them there.
std::vector<std::vector<SharpEdge>> chained(const std::vector<SharpEdge>& edges) {
  std::multimap<std::int32_t, std::size_t> atVertex;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    atVertex.insert({edges[e].from, e});
    atVertex.insert({edges[e].to, e});
  }
  std::vector<char> isUsed(edges.size(), 0);
  std::vector<std::vector<SharpEdge>> chains;
  const auto walk = [&](std::size_t e, std::int32_t from) {
    chains.emplace_back();
    while (!isUsed[e]) {
      isUsed[e] = 1;
      SharpEdge edge = edges[e];
      if (edge.from != from) std::swap(edge.from, edge.to);
      chains.back().push_back(edge);
      from = edge.to;
      if (atVertex.count(from) != 2) return;
      const auto [first, last] = atVertex.equal_range(from);
      for (auto other = first; other != last; ++other) {
        if (other->second != e && !isUsed[other->second]) {
          e = other->second;
          break;
        }
      }
    }
  };
  for (const auto& [vertex, e] : atVertex) {
    if (!isUsed[e] && atVertex.count(vertex) != 2) walk(e, vertex);
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {  // closed loops are left
    if (!isUsed[e]) walk(e, edges[e].from);
  }
  return chains;
}

/// Evenly along a line, its ends included.
void addEvenly(const std::vector<Vector3>& line, double spacing, std::vector<Vector3>& points) {
  std::vector<double> way = {0.0};
  for (std::size_t i = 1; i < line.size(); ++i) way.push_back(way.back() + (line[i] - line[i - 1]).norm());
  const auto pieces = static_cast<int>(std::ceil(way.back() / spacing - 0.2));
  std::size_t at = 0;
  for (int k = 0; k <= std::max(pieces, 0); ++k) {
    const double wanted = pieces > 0 ? way.back() * k / pieces : 0.0;
    while (at + 1 < way.size() && way[at + 1] < wanted) ++at;
    const std::size_t next = std::min(at + 1, line.size() - 1);
    const double length = way[next] - way[at];
    const double part = length > 0.0 ? std::min(1.0, (wanted - way[at]) / length) : 0.0;
    points.push_back(line[at] + part * (line[next] - line[at]));
  }
}

std::vector<Vector3> withoutNear(const std::vector<Vector3>& points, double nearest) {
  const PointGrid grid(points, nearest);
  std::vector<char> isDropped(points.size(), 0);
  std::vector<Vector3> kept;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (isDropped[i]) continue;
    kept.push_back(points[i]);
    grid.forEachNear(points[i], nearest, [&](std::int32_t j, const Vector3& q) {
      if ((q - points[i]).norm() < nearest) isDropped[j] = 1;
    });
  }
  return kept;
}

}  // namespace

std::vector<Vector3> creasePoints(const TriangleMesh& mesh, const MeshDistance& distance,
                                  const FeatureDef& def) {
  std::vector<SharpEdge> edges = findSharpEdges(mesh, def.sharpDegrees);
  std::erase_if(edges, [&](const SharpEdge& e) {
    return (def.offset < 0.0 && !e.isConvex) || (def.offset > 0.0 && e.isConvex);
  });
  std::vector<Vector3> points;
  for (const std::vector<SharpEdge>& chain : chained(edges)) {
    std::vector<Vector3> line;  // the run of places that are on the offset surface
    const auto finish = [&] {
      if (!line.empty()) addEvenly(line, def.spacing, points);
      line.clear();
    };
    std::int32_t hint = -1;
    for (const SharpEdge& e : chain) {
      const Vector3 from = mesh.vertices[e.from], along = mesh.vertices[e.to] - from;
      const int steps = std::max(1, static_cast<int>(std::ceil(along.norm() / (kLook * def.spacing))));
      for (int s = 0; s <= steps; ++s) {
        const Vector3 p = from + along * s / steps + def.offset * e.shift;
        const NearestPoint near = distance.nearest(p, hint);
        hint = near.triangle;
        if (std::abs(near.signedDistance - def.offset) > kOnSurface * def.spacing) {
          finish();
        } else {
          line.push_back(p);
        }
      }
    }
    finish();
  }
  return withoutNear(points, kNear * def.spacing);
}

std::vector<Vector3> sharpEdgePoints(const TriangleMesh& mesh, const FeatureDef& def) {
  std::vector<Vector3> points;
  for (const SharpEdge& e : findSharpEdges(mesh, def.sharpDegrees)) {
    if (e.isConvex) addEvenly({mesh.vertices[e.from], mesh.vertices[e.to]}, def.spacing, points);
  }
  return points;
}

}  // namespace granular::detail
