// SPDX-License-Identifier: MIT
// Star and wedge.
#include <cmath>
#include <numbers>

#include "meshes/mesh_builders.h"
#include "meshes/our_meshes.h"

namespace granular_meshes {

TriangleMesh makeStar() {
  std::vector<std::vector<Vector3>> sections;
  for (double z : {-0.2, 0.2}) {
    sections.emplace_back();
    for (int k = 0; k < 10; ++k) {
      const double angle = 0.5 * std::numbers::pi + k * std::numbers::pi / 5.0;
      const double radius = k % 2 == 0 ? 1.0 : 0.45;
      sections.back().emplace_back(radius * std::cos(angle), radius * std::sin(angle), z);
    }
  }
  return loft(sections);
}

TriangleMesh makeWedge() {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {1.2, 0.0, 0.0}, {0.0, 0.7, 0.0}, {0.0, 0.0, 0.5}, {0.9, 0.0, 0.3}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {0, 4, 3}, {1, 2, 4}, {2, 3, 4}};
  return mesh;
}

}  // namespace granular_meshes
