// SPDX-License-Identifier: MIT
#include "granular/geometry/winding_number.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

namespace granular {
namespace {

constexpr std::int32_t kLeafTriangles = 8;
// A node farther than this many of its radii counts as one dipole. 2 is what Barill et al. use with higher
// terms; a dipole alone needs more for the same error.
constexpr double kFar = 3.0;
constexpr double kFourPi = 4.0 * std::numbers::pi;

}  // namespace

double windingOfTriangle(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p) {
  const Vector3 x = a - p, y = b - p, z = c - p;
  const double lx = x.norm(), ly = y.norm(), lz = z.norm();
  const double volume = x.dot(y.cross(z));
  const double scale = lx * ly * lz + x.dot(y) * lz + y.dot(z) * lx + z.dot(x) * ly;
  if (volume == 0.0) return 0.0;  // in the plane of the triangle: as much on one side as on the other
  return 2.0 * std::atan2(volume, scale) / kFourPi;
}

WindingNumber::WindingNumber(const TriangleMesh& mesh) {
  triangles_.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    triangles_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  if (!triangles_.empty()) build(0, static_cast<std::int32_t>(triangles_.size()));
}

std::int32_t WindingNumber::build(std::int32_t first, std::int32_t last) {
  const auto self = static_cast<std::int32_t>(nodes_.size());
  Node node;
  double area = 0.0;
  Vector3 middle = Vector3::Zero();
  const auto centroid = [](const Triangle& t) { return Vector3((t.a + t.b + t.c) / 3.0); };
  Vector3 low = centroid(triangles_[first]), high = low;
  for (std::int32_t t = first; t < last; ++t) {
    const Triangle& triangle = triangles_[t];
    const Vector3 own = 0.5 * (triangle.b - triangle.a).cross(triangle.c - triangle.a);
    node.areaVector += own;
    area += own.norm();
    middle += own.norm() * centroid(triangle);
    low = low.cwiseMin(centroid(triangle));
    high = high.cwiseMax(centroid(triangle));
  }
  node.center = area > 0.0 ? Vector3(middle / area) : Vector3(0.5 * (low + high));
  for (std::int32_t t = first; t < last; ++t) {
    for (const Vector3* v : {&triangles_[t].a, &triangles_[t].b, &triangles_[t].c}) {
      node.radius = std::max(node.radius, (*v - node.center).norm());
    }
  }
  nodes_.push_back(node);
  if (last - first <= kLeafTriangles) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return self;
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::int32_t half = first + (last - first) / 2;
  std::nth_element(
      triangles_.begin() + first, triangles_.begin() + half, triangles_.begin() + last,
      [&](const Triangle& x, const Triangle& y) { return centroid(x)[axis] < centroid(y)[axis]; });
  build(first, half);
  nodes_[self].first = build(half, last);
  return self;
}

double WindingNumber::at(const Vector3& p) const {
  if (nodes_.empty()) return 0.0;
  double sum = 0.0;
  std::array<std::int32_t, 64> stack;  // twice the depth of a tree of 2^31 triangles
  int depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const std::int32_t n = stack[--depth];
    const Node& node = nodes_[n];
    const Vector3 away = node.center - p;
    const double squared = away.squaredNorm();
    if (squared > kFar * kFar * node.radius * node.radius) {
      sum += node.areaVector.dot(away) / (kFourPi * squared * std::sqrt(squared));
    } else if (node.count > 0) {
      for (std::int32_t t = node.first; t < node.first + node.count; ++t) {
        sum += windingOfTriangle(triangles_[t].a, triangles_[t].b, triangles_[t].c, p);
      }
    } else {
      stack[depth++] = node.first;
      stack[depth++] = n + 1;
    }
  }
  return sum;
}

MeshFault findBuriedTriangles(const TriangleMesh& mesh, const WindingNumber& winding) {
  constexpr double kAside = 1e-4;                 // of the longest edge: just off the face
  constexpr double kPlacesByArea = 4000.0;        // shared out among the triangles, beside one for each
  constexpr std::size_t kMostTriangles = 20'000;  // 50 ms; more tells nothing new about a mesh
  // Additive recurrence of Roberts (2018), 1/g and 1/g^2 with g^3 = g + 1, from the middle of a triangle.
  constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;
  const double wholeArea = surfaceArea(mesh);
  const std::size_t stride = (mesh.triangles.size() + kMostTriangles - 1) / kMostTriangles;
  MeshFault fault;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += stride) {
    const auto& corner = mesh.triangles[t];
    const Vector3 areaVector = doubleAreaVector(mesh, corner);
    const Vector3 &a = mesh.vertices[corner[0]], &b = mesh.vertices[corner[1]], &c = mesh.vertices[corner[2]];
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    if (!(areaVector.norm() > 1e-6 * longest * longest)) continue;
    const Vector3 aside = kAside * longest * areaVector.normalized();
    const int places = 1 + static_cast<int>(0.5 * areaVector.norm() / wholeArea * kPlacesByArea);
    bool isBuried = false;
    double u = 1.0 / 3.0, v = 1.0 / 3.0;
    for (int n = 0; n < places && !isBuried; ++n) {
      const bool isBeyond = u + v > 1.0;
      const Vector3 p = a + (isBeyond ? 1.0 - u : u) * (b - a) + (isBeyond ? 1.0 - v : v) * (c - a);
      isBuried = winding.isInside(p + aside);
      u = std::fmod(u + kFirst, 1.0);
      v = std::fmod(v + kSecond, 1.0);
    }
    if (isBuried && fault.count++ == 0) fault.firstExample = "triangle " + std::to_string(t);
  }
  return fault;
}

}  // namespace granular
