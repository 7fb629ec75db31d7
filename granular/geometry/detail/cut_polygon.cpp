// SPDX-License-Identifier: MIT
#include "granular/geometry/detail/cut_polygon.h"

#include <numeric>

namespace granular::detail {
namespace {

/// Twice the area vector of a polygon (Newell's method).
Vector3 areaVector(std::span<const Vector3> corners) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
    sum += (corners[i] - corners[0]).cross(corners[i + 1] - corners[0]);
  }
  return sum;
}

/// How far the path a, b, c turns left seen against `normal`; 0 if it runs straight.
double turn(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& normal) {
  return (b - a).cross(c - b).dot(normal);
}

bool holds(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& p, const Vector3& normal) {
  return turn(a, b, p, normal) >= 0.0 && turn(b, c, p, normal) >= 0.0 && turn(c, a, p, normal) >= 0.0;
}

/// Whether the corner at place `at` of what is left can be cut off.
bool isEar(std::span<const Vector3> corners, const std::vector<std::int32_t>& left, std::size_t at,
           const Vector3& normal) {
  const std::size_t n = left.size();
  const Vector3 &a = corners[left[(at + n - 1) % n]], &b = corners[left[at]],
                &c = corners[left[(at + 1) % n]];
  if (turn(a, b, c, normal) <= 0.0) return false;
  for (std::size_t k = 2; k + 1 < n; ++k) {
    if (holds(a, b, c, corners[left[(at + k) % n]], normal)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<std::int32_t, 3>> cutPolygon(std::span<const Vector3> corners) {
  const Vector3 normal = areaVector(corners);
  std::vector<std::int32_t> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::size_t at = 0;  // goes round, so that ears are taken from all sides
  while (left.size() > 3) {
    const std::size_t n = left.size();
    std::size_t tries = 0;
    while (tries < n && !isEar(corners, left, (at + tries) % n, normal)) ++tries;
    at = (at + tries) % n;  // none in a polygon that crosses itself: any corner will do
    triangles.push_back({left[(at + n - 1) % n], left[at], left[(at + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
    at = at % left.size();
  }
  triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

}  // namespace granular::detail
