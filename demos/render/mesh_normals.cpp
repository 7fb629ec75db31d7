// SPDX-License-Identifier: MIT
#include "demos/render/mesh_normals.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

namespace granular_demo {
namespace {

using granular::TriangleMesh;
using granular::Vector3;

struct Corner {
  std::size_t place;  // vertices at the same coordinates share it
  std::size_t face;
  int index;  // 0, 1, 2 within the face
  double angle;
};

/// For each vertex the index of the first vertex at the same coordinates.
std::vector<std::size_t> placesOf(const std::vector<Vector3>& vertices) {
  const auto key = [&](std::size_t i) {
    return std::tuple(vertices[i].x(), vertices[i].y(), vertices[i].z());
  };
  std::vector<std::size_t> order(vertices.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](auto a, auto b) { return std::pair(key(a), a) < std::pair(key(b), b); });
  std::vector<std::size_t> places(vertices.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
    places[order[k]] = same ? places[order[k - 1]] : order[k];
  }
  return places;
}

double angleBetween(const Vector3& a, const Vector3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

std::vector<Corner> cornersByPlace(const TriangleMesh& mesh) {
  const std::vector<std::size_t> places = placesOf(mesh.vertices);
  std::vector<Corner> corners;
  corners.reserve(3 * mesh.triangles.size());
  for (std::size_t face = 0; face < mesh.triangles.size(); ++face) {
    const auto& triangle = mesh.triangles[face];
    for (int k = 0; k < 3; ++k) {
      const auto at = [&](int i) {
        return static_cast<std::size_t>(triangle[static_cast<std::size_t>((k + i) % 3)]);
      };
      const Vector3& p = mesh.vertices[at(0)];
      corners.push_back(
          {places[at(0)], face, k, angleBetween(mesh.vertices[at(1)] - p, mesh.vertices[at(2)] - p)});
    }
  }
  std::stable_sort(corners.begin(), corners.end(), [](auto& a, auto& b) { return a.place < b.place; });
  return corners;
}

std::vector<Vector3> faceNormals(const TriangleMesh& mesh) {
  std::vector<Vector3> normals;
  normals.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vector3& p = mesh.vertices[static_cast<std::size_t>(a)];
    const Vector3 cross = (mesh.vertices[static_cast<std::size_t>(b)] - p)
                              .cross(mesh.vertices[static_cast<std::size_t>(c)] - p);
    normals.push_back(cross.stableNormalized());
  }
  return normals;
}

}  // namespace

std::vector<std::array<Eigen::Vector3f, 3>> cornerNormals(const TriangleMesh& mesh,
                                                          double creaseAngleDegrees) {
  const double smallestCosine = std::cos(creaseAngleDegrees * std::numbers::pi / 180.0);
  const std::vector<Vector3> normals = faceNormals(mesh);
  const std::vector<Corner> corners = cornersByPlace(mesh);
  std::vector<std::array<Eigen::Vector3f, 3>> result(mesh.triangles.size());
  for (std::size_t first = 0; first < corners.size();) {
    std::size_t last = first;
    while (last < corners.size() && corners[last].place == corners[first].place) ++last;
    for (std::size_t i = first; i < last; ++i) {
      const Vector3& own = normals[corners[i].face];
      Vector3 sum = Vector3::Zero();
      for (std::size_t j = first; j < last; ++j) {
        const Vector3& other = normals[corners[j].face];
        if (j == i || own.dot(other) > smallestCosine) sum += corners[j].angle * other;
      }
      result[corners[i].face][static_cast<std::size_t>(corners[i].index)] =
          (sum.norm() > 0.0 ? Vector3(sum.normalized()) : own).cast<float>();
    }
    first = last;
  }
  return result;
}

}  // namespace granular_demo
