// SPDX-License-Identifier: MIT
#include "granular/geometry/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "granular/geometry/detail/mesh_sides.h"

namespace granular {
namespace {

constexpr double kSliver = 1e-3;  // height over longest edge
constexpr double kDegenerateArea =
    1e-14;  // of the longest edge squared: an angle below 1e-14 rad has no normal in doubles

void note(MeshFault& fault, const std::string& example) {
  if (fault.count++ == 0) fault.firstExample = example;
}

std::string triangleName(std::size_t t) {
  return "triangle " + std::to_string(t);
}

void checkEdges(const TriangleMesh& mesh, MeshReport& report) {
  const std::vector<detail::MeshSide> sides = detail::sortedSides(mesh.triangles);
  detail::forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    const auto count = static_cast<std::int64_t>(last - first);
    const auto forward = std::count_if(sides.begin() + first, sides.begin() + last,
                                       [](const detail::MeshSide& s) { return s.isForward; });
    if (count == 2 && forward == 1) return;
    std::string name = "edge " + std::to_string(sides[first].low) + '-' + std::to_string(sides[first].high) +
                       " of triangle " + std::to_string(sides[first].triangle);
    if (count == 1) {
      note(report.openEdges, name);
    } else if (2 * forward != count) {
      name += " and " + std::to_string(sides[first + 1].triangle);
      note(report.flippedEdges, name);
    }
    if (count > 2) note(report.crowdedEdges, name);
  });
}

void checkDuplicates(const TriangleMesh& mesh, MeshReport& report) {
  std::vector<std::array<std::int32_t, 4>> sorted(
      mesh.triangles.size());  // three corners in rising order, index
  for (std::size_t t = 0; t < sorted.size(); ++t) {
    const auto& c = mesh.triangles[t];
    sorted[t] = {c[0], c[1], c[2], static_cast<std::int32_t>(t)};
    std::sort(sorted[t].begin(), sorted[t].begin() + 3);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (std::equal(sorted[i].begin(), sorted[i].begin() + 3, sorted[i - 1].begin())) {
      note(report.duplicateTriangles,
           triangleName(sorted[i][3]) + " repeats triangle " + std::to_string(sorted[i - 1][3]));
    }
  }
}

void checkAreas(const TriangleMesh& mesh, MeshReport& report) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& c = mesh.triangles[t];
    double longest = 0.0;
    for (int k = 0; k < 3; ++k) {
      longest = std::max(longest, (mesh.vertices[c[k]] - mesh.vertices[c[(k + 1) % 3]]).squaredNorm());
    }
    const double doubleArea = doubleAreaVector(mesh, c).norm();
    if (!(doubleArea > kDegenerateArea * longest)) {
      note(report.degenerateTriangles, triangleName(t));
    } else if (doubleArea < kSliver * longest) {
      note(report.slivers, triangleName(t));
    }
  }
}

bool inRange(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& corners) {
  return std::all_of(corners.begin(), corners.end(), [&](std::int32_t v) {
    return v >= 0 && static_cast<std::size_t>(v) < mesh.vertices.size();
  });
}

bool lexicallyLess(const Vector3& a, const Vector3& b) {
  return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
}

/// For each vertex, the lowest index of a vertex at the same place.
std::vector<std::int32_t> firstAtSamePlace(const std::vector<Vector3>& vertices) {
  std::vector<std::int32_t> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return lexicallyLess(vertices[a], vertices[b]); });
  std::vector<std::int32_t> first(vertices.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[order[i]] == vertices[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  return first;
}

void dropUnusedVertices(TriangleMesh& mesh) {
  std::vector<std::int32_t> newIndex(mesh.vertices.size(), -1);
  for (const auto& t : mesh.triangles) {
    for (std::int32_t v : t) newIndex[v] = 0;
  }
  std::int32_t kept = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (newIndex[v] < 0) continue;
    newIndex[v] = kept;
    mesh.vertices[kept++] = mesh.vertices[v];
  }
  mesh.vertices.resize(kept);
  for (auto& t : mesh.triangles) {
    for (std::int32_t& v : t) v = newIndex[v];
  }
}

}  // namespace

MeshReport checkMesh(const TriangleMesh& mesh) {
  MeshReport report;
  report.vertexCount = static_cast<std::int64_t>(mesh.vertices.size());
  report.triangleCount = static_cast<std::int64_t>(mesh.triangles.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!mesh.vertices[v].allFinite()) note(report.nonFiniteVertices, "vertex " + std::to_string(v));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!inRange(mesh, mesh.triangles[t])) note(report.indicesOutOfRange, triangleName(t));
  }
  if (!report.isReadable()) return report;
  checkAreas(mesh, report);
  checkDuplicates(mesh, report);
  checkEdges(mesh, report);
  report.area = surfaceArea(mesh);
  report.volume = signedVolume(mesh);
  return report;
}

std::string MeshReport::text() const {
  std::ostringstream out;
  out << triangleCount << " triangles, " << vertexCount << " vertices";
  if (isReadable()) out << ", area " << area << " m^2, volume " << volume << " m^3";
  const auto line = [&](const MeshFault& fault, const char* what) {
    if (fault.count > 0) out << "\n" << fault.count << ' ' << what << ", first: " << fault.firstExample;
  };
  line(nonFiniteVertices, "vertices not finite");
  line(indicesOutOfRange, "triangles with an index out of range");
  line(degenerateTriangles, "triangles of zero area");
  line(slivers, "slivers (height below 1/1000 of the longest edge)");
  line(duplicateTriangles, "duplicate triangles");
  line(openEdges, "open edges");
  line(flippedEdges, "edges between inconsistently oriented triangles");
  line(crowdedEdges, "edges of more than two triangles");
  if (isInsideOut()) out << "\nall faces look inwards (the volume is negative); turnInsideOut() mends it";
  if (isClosed() && volume == 0.0) out << "\nthe volume is zero";
  if (triangleCount == 0) out << "\nthere are no triangles";
  return out.str();
}

std::int64_t weldVertices(TriangleMesh& mesh) {
  const auto before = static_cast<std::int64_t>(mesh.vertices.size());
  const std::vector<std::int32_t> first = firstAtSamePlace(mesh.vertices);
  for (auto& t : mesh.triangles) {
    for (std::int32_t& v : t) v = first[v];
  }
  std::erase_if(mesh.triangles, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  dropUnusedVertices(mesh);
  return before - static_cast<std::int64_t>(mesh.vertices.size());
}

void turnInsideOut(TriangleMesh& mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
}

TriangleMesh seenFrom(const Pose& frame, TriangleMesh mesh) {
  for (Vector3& v : mesh.vertices) v = frame.toOwn(v);
  return mesh;
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
  const auto shift = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles) mesh.triangles.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
}

Box boundingBox(const TriangleMesh& mesh) {
  if (mesh.vertices.empty()) return {};
  Box box{mesh.vertices.front(), mesh.vertices.front()};
  for (const Vector3& v : mesh.vertices) {
    box.lower = box.lower.cwiseMin(v);
    box.upper = box.upper.cwiseMax(v);
  }
  return box;
}

double surfaceArea(const TriangleMesh& mesh) {
  double area = 0.0;
  for (const auto& t : mesh.triangles) area += 0.5 * doubleAreaVector(mesh, t).norm();
  return area;
}

double signedVolume(const TriangleMesh& mesh) {
  const Vector3 center =
      boundingBox(mesh).center();  // near the surface, so that far-off meshes lose no digits
  double sixVolumes = 0.0;
  for (const auto& t : mesh.triangles) {
    sixVolumes += (mesh.vertices[t[0]] - center).dot(doubleAreaVector(mesh, t));
  }
  return sixVolumes / 6.0;
}

}  // namespace granular
