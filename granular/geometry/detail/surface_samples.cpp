// SPDX-License-Identifier: MIT
#include "granular/geometry/detail/surface_samples.h"

#include <cmath>

namespace granular::detail {

std::vector<SurfacePoint> sampleSurface(const TriangleMesh& mesh, double areaEach) {
  constexpr double kFirst = 0.7548776662466927, kSecond = 0.5698402909980532;  // 1/g, 1/g^2, g^3 = g + 1
  std::vector<SurfacePoint> samples;
  double waiting = 0.5;  // samples due, at the start of the triangle
  double u = 0.5, v = 0.5;
  for (const auto& t : mesh.triangles) {
    const Vector3 areaVector = doubleAreaVector(mesh, t);
    const double doubleArea = areaVector.norm();
    if (!(doubleArea > 0.0)) continue;
    for (waiting += 0.5 * doubleArea / areaEach; waiting >= 1.0; waiting -= 1.0) {
      u = std::fmod(u + kFirst, 1.0);
      v = std::fmod(v + kSecond, 1.0);
      const double a = u + v > 1.0 ? 1.0 - u : u, b = u + v > 1.0 ? 1.0 - v : v;
      const Vector3& corner = mesh.vertices[t[0]];
      samples.push_back({corner + a * (mesh.vertices[t[1]] - corner) + b * (mesh.vertices[t[2]] - corner),
                         areaVector / doubleArea});
    }
  }
  return samples;
}

}  // namespace granular::detail
