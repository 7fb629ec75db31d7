// SPDX-License-Identifier: MIT
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "granular/geometry/marching_tetrahedra.h"
#include "granular/geometry/signed_distance_band.h"
#include "meshes/our_meshes.h"

namespace granular_meshes {
namespace {

/// A limb: the hull of two balls, standing in for a muscle.
struct Limb {
  Vector3 from, to;
  double fromRadius, toRadius;
};

/// Distance to a limb whose radius runs evenly along its axis, m. It is a lower bound of the true distance,
/// changing by less than the distance walked as long as the radii differ by less than the length.
double distance(const Limb& limb, const Vector3& p) {
  const Vector3 axis = limb.to - limb.from;
  const double length = axis.norm();
  const double slope = (limb.fromRadius - limb.toRadius) / length;
  // Foot point of the line that leaves the cone at a right angle, instead of the axis.
  const double along = (p - limb.from).dot(axis) / length;
  const double across = std::sqrt(std::max(0.0, (p - limb.from).squaredNorm() - along * along));
  const double shifted = along + across * slope / std::sqrt(1.0 - slope * slope);
  const double t = std::clamp(shifted / length, 0.0, 1.0);
  return (p - limb.from - t * axis).norm() - (limb.fromRadius + t * (limb.toRadius - limb.fromRadius));
}

/// Minimum of two distances with the crease filled over a width `blend`, m (Quilez 2013, polynomial smooth
/// minimum).
double smoothMinimum(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * h * h * blend;
}

/// A two-humped camel, 2.6 m from tail to nose, looking along +x; left is +y.
std::vector<Limb> camelLimbs() {
  std::vector<Limb> limbs = {
      {{-0.62, 0.0, 1.28}, {0.58, 0.0, 1.30}, 0.33, 0.31},    // barrel of the body
      {{-0.05, 0.0, 1.18}, {0.50, 0.0, 1.20}, 0.30, 0.32},    // chest
      {{-0.38, 0.0, 1.50}, {-0.40, 0.0, 1.84}, 0.26, 0.13},   // rear hump
      {{0.30, 0.0, 1.50}, {0.27, 0.0, 1.86}, 0.26, 0.13},     // front hump
      {{0.72, 0.0, 1.26}, {1.10, 0.0, 1.22}, 0.22, 0.15},     // neck, going down
      {{1.10, 0.0, 1.22}, {1.27, 0.0, 1.72}, 0.15, 0.11},     // and up again
      {{1.25, 0.0, 1.80}, {1.62, 0.0, 1.70}, 0.135, 0.075},   // head and muzzle
      {{-0.92, 0.0, 1.36}, {-1.06, 0.0, 0.92}, 0.07, 0.06},   // tail
      {{-1.06, 0.0, 0.92}, {-1.07, 0.0, 0.78}, 0.06, 0.085},  // and its tuft
  };
  for (double side : {-1.0, 1.0}) {
    limbs.push_back({{1.22, side * 0.07, 1.86}, {1.15, side * 0.20, 1.96}, 0.085, 0.075});   // ear
    limbs.push_back({{0.62, side * 0.19, 1.18}, {0.64, side * 0.19, 0.62}, 0.18, 0.10});     // upper fore leg
    limbs.push_back({{0.64, side * 0.19, 0.62}, {0.63, side * 0.19, 0.10}, 0.10, 0.08});     // lower fore leg
    limbs.push_back({{0.63, side * 0.19, 0.10}, {0.73, side * 0.19, 0.08}, 0.10, 0.085});    // fore foot
    limbs.push_back({{-0.66, side * 0.19, 1.22}, {-0.74, side * 0.19, 0.66}, 0.23, 0.11});   // thigh
    limbs.push_back({{-0.74, side * 0.19, 0.66}, {-0.80, side * 0.19, 0.10}, 0.105, 0.08});  // shank
    limbs.push_back({{-0.80, side * 0.19, 0.10}, {-0.69, side * 0.19, 0.08}, 0.10, 0.085});  // hind foot
  }
  return limbs;
}

using DistanceFunction = std::function<double(const Vector3&)>;

Vector3 slope(const DistanceFunction& distanceAt, const Vector3& p) {
  constexpr double kStep = 1e-4;  // m, of the difference quotient
  Vector3 result;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3 step = kStep * Vector3::Unit(axis);
    result[axis] = (distanceAt(p + step) - distanceAt(p - step)) / (2.0 * kStep);
  }
  return result;
}

/// Moves every vertex to the middle of its neighbours, then back to the surface: the slivers of the
/// tetrahedra go.
void evenOut(const DistanceFunction& distanceAt, TriangleMesh& mesh) {
  std::vector<Vector3> sum(mesh.vertices.size(), Vector3::Zero());
  std::vector<int> neighbours(mesh.vertices.size(), 0);
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      sum[t[k]] += mesh.vertices[t[(k + 1) % 3]];
      ++neighbours[t[k]];
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    const Vector3 p = sum[v] / neighbours[v];
    const Vector3 s = slope(distanceAt, p);
    mesh.vertices[v] = p - distanceAt(p) / s.squaredNorm() * s;
  }
}

/// Throws if a face looks away from the outside of the surface at its middle.
void requireUnfolded(const DistanceFunction& distanceAt, const TriangleMesh& mesh) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& c = mesh.triangles[t];
    const Vector3 middle = (mesh.vertices[c[0]] + mesh.vertices[c[1]] + mesh.vertices[c[2]]) / 3.0;
    if (granular::doubleAreaVector(mesh, c).dot(slope(distanceAt, middle)) <= 0.0) {
      throw std::runtime_error("triangle " + std::to_string(t) + " is folded over at " +
                               std::to_string(middle[0]) + " " + std::to_string(middle[1]) + " " +
                               std::to_string(middle[2]));
    }
  }
}

}  // namespace

TriangleMesh makeCamel() {
  constexpr double kBlend = 0.10;  // m
  const std::vector<Limb> limbs = camelLimbs();
  const auto camel = [&](const Vector3& p) {
    double d = distance(limbs.front(), p);
    for (std::size_t i = 1; i < limbs.size(); ++i) d = smoothMinimum(d, distance(limbs[i], p), kBlend);
    return d;
  };
  const granular::SignedDistanceBand band(camel, {{-1.3, -0.6, -0.1}, {1.9, 0.6, 2.2}},
                                          {.spacing = 0.085, .lower = -0.01, .upper = 0.01});
  TriangleMesh mesh = granular::marchingTetrahedra(band, 0.0);
  for (int round = 0; round < 5; ++round) evenOut(camel, mesh);
  requireUnfolded(camel, mesh);
  return mesh;
}

}  // namespace granular_meshes
