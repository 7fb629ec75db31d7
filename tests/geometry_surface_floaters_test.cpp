// SPDX-License-Identifier: MIT
#include "granular/geometry/surface_floaters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

SurfaceSample unitSphere(std::int32_t, const Vector3& p) {
  return {p.norm() - 1.0, p.normalized()};
}

/// Box of half size 1, its true distance: the normal jumps at every edge.
SurfaceSample unitBox(std::int32_t, const Vector3& p) {
  const Vector3 q = p.cwiseAbs() - Vector3::Ones();
  Vector3 normal = q.cwiseMax(0.0);
  if (normal.norm() == 0.0) {
    int axis = 0;
    q.maxCoeff(&axis);
    normal = Vector3::Unit(axis);
  }
  const double value = q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
  return {value, normal.normalized().cwiseProduct(p.cwiseSign())};
}

/// Spacing of an even layer of `count` particles on `area`.
double evenSpacing(double area, std::size_t count) {
  return std::sqrt(2.0 / std::numbers::sqrt3 * area / static_cast<double>(count));
}

std::vector<double> nearestDistances(const std::vector<Vector3>& points) {
  std::vector<double> nearest(points.size(), 1e300);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      if (i != j) nearest[i] = std::min(nearest[i], (points[i] - points[j]).norm());
    }
  }
  std::sort(nearest.begin(), nearest.end());
  return nearest;
}

TEST(SurfaceFloaters, CountIsDensityTimesAreaOverDiscArea) {
  // Of one triangle: the whole part always, the remainder as a probability.
  TriangleMesh triangle;
  triangle.vertices = {{0.0, 0.0, 0.0}, {2.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  triangle.triangles = {{0, 1, 2}};
  const double radius = 0.1, density = 0.8;
  const double wanted = density * 1.0 / (std::numbers::pi * radius * radius);  // 25.46
  const int trials = 4000;
  double sum = 0.0;
  for (int seed = 0; seed < trials; ++seed) {
    const auto count = static_cast<double>(seedFloaters(triangle, radius, density, Random(seed)).size());
    EXPECT_TRUE(count == std::floor(wanted) || count == std::floor(wanted) + 1.0) << count;
    sum += count;
  }
  EXPECT_NEAR(sum / trials, wanted, 4.0 * 0.5 / std::sqrt(trials));  // four standard errors at most
}

TEST(SurfaceFloaters, CountHoldsOnTrianglesMuchSmallerThanAParticle) {
  const TriangleMesh ball = makeIcosphere(1.0, 5);  // 20480 triangles
  const double radius = 0.05, density = 0.9;
  const double wanted = density * surfaceArea(ball) / (std::numbers::pi * radius * radius);
  const auto count = static_cast<double>(seedFloaters(ball, radius, density, Random(5)).size());
  EXPECT_NEAR(count, wanted, 4.0 * std::sqrt(wanted));
}

TEST(SurfaceFloaters, StartWithinTheirTriangle) {
  TriangleMesh triangle;
  triangle.vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}};
  triangle.triangles = {{0, 1, 2}};
  for (const Vector3& p : seedFloaters(triangle, 0.02, 1.0, Random(1))) {
    EXPECT_GE(p[0], 0.0);
    EXPECT_GE(p[1], 0.0);
    EXPECT_LE(p[0] + p[1], 1.0 + 1e-12);
  }
}

TEST(SurfaceFloaters, EndOnTheZeroSet) {
  const double radius = 0.1;
  std::vector<Vector3> floaters =
      seedFloaters(makeIcosphere(1.1, 3), radius, 0.85, Random(2));  // starts off the surface
  const double spacing = evenSpacing(4.0 * std::numbers::pi, floaters.size());
  const FloaterReport report =
      relaxFloaters(floaters, unitSphere, {.spacing = spacing, .convergence = 3e-3 * radius});
  EXPECT_TRUE(report.converged);
  // A floater leaves the sphere by half the square of its last move along it, which has all but stopped.
  for (const Vector3& p : floaters) EXPECT_NEAR(p.norm(), 1.0, 1e-3 * radius);
}

TEST(SurfaceFloaters, EndEvenlySpaced) {
  const double radius = 0.1;
  std::vector<Vector3> floaters = seedFloaters(makeIcosphere(1.0, 3), radius, 0.85, Random(3));
  const double spacing = evenSpacing(4.0 * std::numbers::pi, floaters.size());
  const double before = nearestDistances(floaters).front();
  relaxFloaters(floaters, unitSphere, {.spacing = spacing, .convergence = 3e-3 * radius});
  const std::vector<double> nearest = nearestDistances(floaters);
  EXPECT_LT(before, 0.3 * spacing);  // random points nearly touch
  EXPECT_GT(nearest.front(), 0.8 * spacing);
  EXPECT_LT(nearest.back(), 1.1 * spacing);
}

TEST(SurfaceFloaters, ComeToRestOnABoxWithSharpEdges) {
  const double radius = 0.1;
  std::vector<Vector3> floaters = seedFloaters(makeBox({2.0, 2.0, 2.0}), radius, 0.85, Random(4));
  const double spacing = evenSpacing(24.0, floaters.size());
  const FloaterReport report =
      relaxFloaters(floaters, unitBox, {.spacing = spacing, .convergence = 3e-3 * radius});
  EXPECT_TRUE(report.converged) << report.meanMove / radius;
  EXPECT_GT(nearestDistances(floaters).front(), 0.6 * spacing);
}

TEST(SurfaceFloaters, SameSeedSameParticles) {
  const auto run = [](std::uint64_t seed, int threads) {
    std::vector<Vector3> floaters = seedFloaters(makeIcosphere(1.0, 3), 0.05, 0.85, Random(seed));
    relaxFloaters(floaters, unitSphere,
                  {.spacing = 0.1, .convergence = 1e-4, .maxIterations = 50, .threads = threads});
    return floaters;
  };
  const auto first = run(9, 1);
  EXPECT_EQ(first, run(9, 1));
  EXPECT_EQ(first, run(9, 3));
  EXPECT_NE(first, run(10, 1));
}

TEST(SurfaceFloaters, PartWhenTheyStartAtTheSamePlace) {
  std::vector<Vector3> floaters(3, Vector3::UnitZ());
  relaxFloaters(floaters, unitSphere, {.spacing = 0.2, .convergence = 1e-5});
  EXPECT_GT(nearestDistances(floaters).front(), 0.2);
}

TEST(SurfaceFloaters, StopAtTheIterationLimitUnconverged) {
  std::vector<Vector3> floaters = seedFloaters(makeIcosphere(1.0, 3), 0.05, 0.85, Random(1));
  const FloaterReport report =
      relaxFloaters(floaters, unitSphere, {.spacing = 0.1, .convergence = 1e-9, .maxIterations = 7});
  EXPECT_EQ(report.iterations, 7);
  EXPECT_FALSE(report.converged);
}

}  // namespace
}  // namespace granular
