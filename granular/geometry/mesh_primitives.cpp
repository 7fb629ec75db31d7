// SPDX-License-Identifier: MIT
#include "granular/geometry/mesh_primitives.h"

#include <cmath>
#include <map>
#include <numbers>

#include "granular/base/require.h"

namespace granular {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

void requireAtLeast(int value, int least, std::string_view field) {
  require(value >= least, field, value, "", ">= " + std::to_string(least));
}

/// Adds the parallelogram corner + [0,1] u + [0,1] v as divisions^2 squares of two triangles; normal along u
/// x v. Points are computed from the corner outwards, so that patches that share an edge may differ by
/// rounding.
void addPatch(TriangleMesh& mesh, const Vector3& corner, const Vector3& u, const Vector3& v, int divisions) {
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  for (int j = 0; j <= divisions; ++j) {
    for (int i = 0; i <= divisions; ++i)
      mesh.vertices.push_back(corner + u * i / divisions + v * j / divisions);
  }
  for (int j = 0; j < divisions; ++j) {
    for (int i = 0; i < divisions; ++i) {
      const std::int32_t a = first + j * (divisions + 1) + i, b = a + 1, c = a + divisions + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
}

/// Vertex halfway along an edge, pushed out to the sphere; the same index from both sides.
std::int32_t midpoint(TriangleMesh& mesh,
                      std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t>& known, std::int32_t a,
                      std::int32_t b, double radius) {
  const auto [entry, isNew] =
      known.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<std::int32_t>(mesh.vertices.size()));
  if (isNew) mesh.vertices.push_back(radius * (mesh.vertices[a] + mesh.vertices[b]).normalized());
  return entry->second;
}

TriangleMesh makeIcosahedron(double radius) {
  // Twelve corners of three golden rectangles in the coordinate planes; faces join corners at the shortest
  // distance.
  TriangleMesh mesh;
  constexpr double g = std::numbers::phi;
  for (int axis = 0; axis < 3; ++axis) {
    for (int signs = 0; signs < 4; ++signs) {
      Vector3 v = Vector3::Zero();
      v[axis] = signs & 1 ? -1.0 : 1.0;
      v[(axis + 1) % 3] = signs & 2 ? -g : g;
      mesh.vertices.push_back(v);
    }
  }
  const auto joined = [&](int a, int b) { return (mesh.vertices[a] - mesh.vertices[b]).squaredNorm() < 5.0; };
  for (std::int32_t a = 0; a < 12; ++a) {
    for (std::int32_t b = a + 1; b < 12; ++b) {
      for (std::int32_t c = b + 1; c < 12; ++c) {
        if (!joined(a, b) || !joined(b, c) || !joined(c, a)) continue;
        const bool outward = mesh.vertices[a].dot(mesh.vertices[b].cross(mesh.vertices[c])) > 0.0;
        mesh.triangles.push_back(outward ? std::array{a, b, c} : std::array{a, c, b});
      }
    }
  }
  for (Vector3& v : mesh.vertices) v = radius * v.normalized();
  return mesh;
}

void subdivideSphere(TriangleMesh& mesh, double radius) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> known;
  std::vector<std::array<std::int32_t, 3>> finer;
  for (const auto [a, b, c] : std::vector(mesh.triangles)) {
    const std::int32_t ab = midpoint(mesh, known, a, b, radius);
    const std::int32_t bc = midpoint(mesh, known, b, c, radius);
    const std::int32_t ca = midpoint(mesh, known, c, a, radius);
    finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  mesh.triangles = std::move(finer);
}

}  // namespace

TriangleMesh makeBox(const Vector3& size, int divisions) {
  for (int axis = 0; axis < 3; ++axis) requirePositive(size[axis], "makeBox size", "m");
  requireAtLeast(divisions, 1, "makeBox divisions");
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    for (double side : {-1.0, 1.0}) {
      const int uAxis = (axis + 1) % 3, vAxis = (axis + 2) % 3;
      Vector3 corner = -1.0 * Vector3::Ones(), u = 2.0 * Vector3::Unit(uAxis), v = 2.0 * Vector3::Unit(vAxis);
      corner[axis] = side;
      if (side < 0.0) std::swap(u, v);
      addPatch(mesh, corner, u, v, divisions);
    }
  }
  // Faces meet on the lattice of the unit cube: rounding to it makes shared corners equal, then they weld.
  for (Vector3& p : mesh.vertices) {
    p = (0.5 * (p.array() + 1.0) * divisions).round() / divisions - 0.5;
    p = p.cwiseProduct(size).eval();
  }
  weldVertices(mesh);
  return mesh;
}

TriangleMesh makeIcosphere(double radius, int subdivisions) {
  requirePositive(radius, "makeIcosphere radius", "m");
  require(subdivisions >= 0 && subdivisions <= 9, "makeIcosphere subdivisions", subdivisions, "", "0 to 9");
  TriangleMesh mesh = makeIcosahedron(radius);
  for (int i = 0; i < subdivisions; ++i) subdivideSphere(mesh, radius);
  return mesh;
}

TriangleMesh makeRevolution(const std::vector<std::pair<double, double>>& profile, int segments) {
  requireAtLeast(static_cast<int>(profile.size()), 3, "makeRevolution profile points");
  requireAtLeast(segments, 3, "makeRevolution segments");
  require(profile.front().first == 0.0 && profile.back().first == 0.0, "makeRevolution radius at the ends",
          std::max(profile.front().first, profile.back().first), "m", "0");
  TriangleMesh mesh;
  const int rings = static_cast<int>(profile.size()) - 2;
  mesh.vertices.emplace_back(0.0, 0.0, profile.front().second);
  for (int ring = 1; ring <= rings; ++ring) {
    requirePositive(profile[ring].first, "makeRevolution radius between the ends", "m");
    for (int s = 0; s < segments; ++s) {
      const double angle = kTwoPi * s / segments;
      mesh.vertices.emplace_back(profile[ring].first * std::cos(angle), profile[ring].first * std::sin(angle),
                                 profile[ring].second);
    }
  }
  const auto top = static_cast<std::int32_t>(mesh.vertices.size());
  mesh.vertices.emplace_back(0.0, 0.0, profile.back().second);
  const auto at = [&](int ring, int s) {
    return static_cast<std::int32_t>(1 + (ring - 1) * segments + s % segments);
  };
  for (int s = 0; s < segments; ++s) {
    mesh.triangles.push_back({0, at(1, s + 1), at(1, s)});
    for (int ring = 1; ring < rings; ++ring) {
      mesh.triangles.push_back({at(ring, s), at(ring, s + 1), at(ring + 1, s + 1)});
      mesh.triangles.push_back({at(ring, s), at(ring + 1, s + 1), at(ring + 1, s)});
    }
    mesh.triangles.push_back({at(rings, s), at(rings, s + 1), top});
  }
  return mesh;
}

TriangleMesh makeCylinder(double radius, double height, int segments) {
  requirePositive(height, "makeCylinder height", "m");
  const double half = 0.5 * height;
  return makeRevolution({{0.0, -half}, {radius, -half}, {radius, half}, {0.0, half}}, segments);
}

TriangleMesh makeCone(double radius, double height, int segments) {
  requirePositive(height, "makeCone height", "m");
  const double half = 0.5 * height;
  return makeRevolution({{0.0, -half}, {radius, -half}, {0.0, half}}, segments);
}

TriangleMesh makeCapsule(double radius, double cylinderHeight, int segments) {
  requirePositive(radius, "makeCapsule radius", "m");
  requirePositive(cylinderHeight, "makeCapsule cylinderHeight", "m");
  requireAtLeast(segments, 3, "makeCapsule segments");
  const int steps =
      std::max(2, segments / 4);  // latitude steps of a quarter circle, about as long as a segment
  std::vector<std::pair<double, double>> profile;
  for (int end = 0; end < 2; ++end) {
    for (int k = 0; k <= steps; ++k) {
      const double latitude = 0.5 * std::numbers::pi * (end == 0 ? k - steps : k) / steps;
      const bool pole = k == (end == 0 ? 0 : steps);
      const double shift = end == 0 ? -0.5 * cylinderHeight : 0.5 * cylinderHeight;
      profile.emplace_back(pole ? 0.0 : radius * std::cos(latitude), shift + radius * std::sin(latitude));
    }
  }
  return makeRevolution(profile, segments);
}

TriangleMesh makeTorus(double ringRadius, double tubeRadius, int ringSegments, int tubeSegments) {
  requirePositive(tubeRadius, "makeTorus tubeRadius", "m");
  require(std::isfinite(ringRadius) && ringRadius > tubeRadius, "makeTorus ringRadius", ringRadius, "m",
          "finite and > tubeRadius");
  requireAtLeast(ringSegments, 3, "makeTorus ringSegments");
  requireAtLeast(tubeSegments, 3, "makeTorus tubeSegments");
  TriangleMesh mesh;
  for (int i = 0; i < ringSegments; ++i) {
    for (int j = 0; j < tubeSegments; ++j) {
      const double along = kTwoPi * i / ringSegments, around = kTwoPi * j / tubeSegments;
      const double fromAxis = ringRadius + tubeRadius * std::cos(around);
      mesh.vertices.emplace_back(fromAxis * std::cos(along), fromAxis * std::sin(along),
                                 tubeRadius * std::sin(around));
    }
  }
  const auto at = [&](int i, int j) {
    return static_cast<std::int32_t>((i % ringSegments) * tubeSegments + j % tubeSegments);
  };
  for (int i = 0; i < ringSegments; ++i) {
    for (int j = 0; j < tubeSegments; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

TriangleMesh makePlanePatch(double sizeX, double sizeY, int divisions) {
  requirePositive(sizeX, "makePlanePatch sizeX", "m");
  requirePositive(sizeY, "makePlanePatch sizeY", "m");
  requireAtLeast(divisions, 1, "makePlanePatch divisions");
  TriangleMesh mesh;
  addPatch(mesh, {-0.5 * sizeX, -0.5 * sizeY, 0.0}, {sizeX, 0.0, 0.0}, {0.0, sizeY, 0.0}, divisions);
  return mesh;
}

}  // namespace granular
