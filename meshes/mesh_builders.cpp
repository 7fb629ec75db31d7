// SPDX-License-Identifier: MIT
#include "meshes/mesh_builders.h"

#include <array>

#include "granular/geometry/detail/cut_polygon.h"

namespace granular_meshes {
namespace {

void addCap(TriangleMesh& mesh, const std::vector<Vector3>& section, std::int32_t first, bool isTurned) {
  for (const auto& t : granular::detail::cutPolygon(section)) {
    const std::int32_t a = first + t[0], b = first + t[1], c = first + t[2];
    if (isTurned) {
      mesh.triangles.push_back({a, c, b});
    } else {
      mesh.triangles.push_back({a, b, c});
    }
  }
}

}  // namespace

TriangleMesh loft(const std::vector<std::vector<Vector3>>& sections) {
  TriangleMesh mesh;
  const auto around = static_cast<std::int32_t>(sections.front().size());
  for (const auto& section : sections)
    mesh.vertices.insert(mesh.vertices.end(), section.begin(), section.end());
  for (std::int32_t s = 0; s + 1 < std::ssize(sections); ++s) {
    for (std::int32_t i = 0; i < around; ++i) {
      const std::int32_t a = s * around + i, b = s * around + (i + 1) % around;
      mesh.triangles.push_back({a, b, b + around});
      mesh.triangles.push_back({a, b + around, a + around});
    }
  }
  addCap(mesh, sections.front(), 0, true);
  addCap(mesh, sections.back(), static_cast<std::int32_t>(std::ssize(mesh.vertices)) - around, false);
  return mesh;
}

TriangleMesh latticeSolid(const std::vector<double>& x, const std::vector<double>& y,
                          const std::vector<double>& z, const std::function<bool(int, int, int)>& isFilled) {
  const std::array<int, 3> cells = {static_cast<int>(x.size()) - 1, static_cast<int>(y.size()) - 1,
                                    static_cast<int>(z.size()) - 1};
  const auto filled = [&](const std::array<int, 3>& c) {
    for (int axis = 0; axis < 3; ++axis) {
      if (c[axis] < 0 || c[axis] >= cells[axis]) return false;
    }
    return isFilled(c[0], c[1], c[2]);
  };
  TriangleMesh mesh;
  const auto corner = [&](std::array<int, 3> c) { mesh.vertices.emplace_back(x[c[0]], y[c[1]], z[c[2]]); };
  const auto addFace = [&](const std::array<int, 3>& cell, int axis, bool isUpper) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int n = 0; n < 4; ++n) {
      std::array<int, 3> c = cell;
      c[axis] += isUpper ? 1 : 0;
      c[u] += n == 1 || n == 2 ? 1 : 0;
      c[v] += n >= 2 ? 1 : 0;
      corner(c);
    }
    const std::int32_t b = first + (isUpper ? 1 : 3), d = first + (isUpper ? 3 : 1);
    mesh.triangles.push_back({first, b, first + 2});
    mesh.triangles.push_back({first, first + 2, d});
  };
  for (int i = 0; i < cells[0]; ++i) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int k = 0; k < cells[2]; ++k) {
        const std::array<int, 3> cell = {i, j, k};
        if (!filled(cell)) continue;
        for (int axis = 0; axis < 3; ++axis) {
          for (bool isUpper : {false, true}) {
            std::array<int, 3> beyond = cell;
            beyond[axis] += isUpper ? 1 : -1;
            if (!filled(beyond)) addFace(cell, axis, isUpper);
          }
        }
      }
    }
  }
  granular::weldVertices(mesh);
  return mesh;
}

}  // namespace granular_meshes
