// SPDX-License-Identifier: MIT
// Coverings as a whole. Holes are looked for by brute force: every sample against every particle.
#include "granular/geometry/cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/base/random.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

double nearestDistance(const Covering& covering, const Vector3& p) {
  double best = 1e300;
  for (const Vector3& q : covering.positions) best = std::min(best, (p - q).squaredNorm());
  return std::sqrt(best);
}

/// Radius of the largest sphere centred on the given surface points that touches no particle.
double largestHole(const Covering& covering, const std::vector<Vector3>& samples) {
  double worst = 0.0;
  for (const Vector3& p : samples)
    worst = std::max(worst, nearestDistance(covering, p) - covering.radii.front());
  return worst;
}

std::vector<Vector3> sphereSamples(double radius, int count) {
  std::vector<Vector3> samples;
  Random random(99);
  for (int n = 0; n < count; ++n) samples.push_back(radius * (random.rotation() * Vector3::UnitX()));
  return samples;
}

std::vector<Vector3> boxSamples(double half, int count) {
  std::vector<Vector3> samples;
  Random random(98);
  for (int n = 0; n < count; ++n) {
    Vector3 p(random.uniform(-half, half), random.uniform(-half, half), random.uniform(-half, half));
    p[n % 3] = n % 2 ? half : -half;
    samples.push_back(p);
  }
  for (int c = 0; c < 8; ++c)
    samples.push_back(half * Vector3(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1));
  return samples;
}

TEST(Covering, LeavesNoHoleAGrainCouldEnter) {
  const double r = 0.08;
  for (std::uint64_t seed : {1, 2, 3}) {
    CoverReport report;
    const Covering ball = coverMesh(makeIcosphere(1.0, 4), {.particleRadius = r, .seed = seed}, &report);
    EXPECT_TRUE(report.holesClosed) << report.text();
    EXPECT_LT(largestHole(ball, sphereSamples(1.0 - r, 20000)), 0.5 * r) << "seed " << seed;
    const Covering box = coverMesh(makeBox({2.0, 2.0, 2.0}), {.particleRadius = r, .seed = seed}, &report);
    EXPECT_TRUE(report.holesClosed) << report.text();
    EXPECT_LT(largestHole(box, boxSamples(1.0 - r, 20000)), 0.5 * r) << "seed " << seed;
  }
}

TEST(Covering, HoleOfTheReportIsTheHoleThatBruteForceFinds) {
  const double r = 0.1;
  CoverReport report;
  const Covering covering = coverMesh(makeIcosphere(1.0, 5), {.particleRadius = r}, &report);
  EXPECT_NEAR(report.largestHole, largestHole(covering, sphereSamples(1.0 - r, 40000)), 0.1 * r);
}

TEST(Covering, ClosesItselfToSmallerGrainsWhenAsked) {
  const double r = 0.1, grain = 0.02;
  CoverReport report;
  const Covering covering =
      coverMesh(makeIcosphere(1.0, 4), {.particleRadius = r, .smallestGrainRadius = grain}, &report);
  EXPECT_TRUE(report.holesClosed) << report.text();
  EXPECT_LT(largestHole(covering, sphereSamples(1.0 - r, 20000)), 0.5 * grain);
}

TEST(Covering, FillsTheHolesOfAPoorDensity) {
  const double r = 0.1;
  CoverReport report;
  const Covering covering = coverMesh(makeIcosphere(1.0, 4), {.particleRadius = r, .density = 0.3}, &report);
  EXPECT_GT(report.filledParticles, 0);
  EXPECT_TRUE(report.holesClosed) << report.text();
  EXPECT_LT(largestHole(covering, sphereSamples(1.0 - r, 20000)), 0.5 * r);
}

TEST(Covering, LiesInThePlaneOfAFlatFace) {
  const double r = 0.07;
  const Covering covering = coverMesh(makeBox({2.0, 2.0, 2.0}), {.particleRadius = r});
  int onTop = 0;
  for (const Vector3& p : covering.positions) {
    if (p[2] < 1.0 - 1.5 * r || p.head<2>().cwiseAbs().maxCoeff() > 1.0 - 1.01 * r)
      continue;  // not on a side
    ++onTop;
    EXPECT_NEAR(p[2], 1.0 - r, 1e-3 * r);
  }
  const double wanted = 0.84 * 4.0 * (1.0 - r) * (1.0 - r) / (std::numbers::pi * r * r);
  EXPECT_NEAR(onTop, wanted, 0.15 * wanted);
}

TEST(Covering, StaysWithinTheSolidByDefault) {
  const TriangleMesh torus = makeTorus(1.0, 0.4, 48, 24);
  const MeshDistance distance(torus);
  const double r = 0.08;
  for (const Vector3& p : coverMesh(torus, {.particleRadius = r}).positions) {
    EXPECT_NEAR(distance.nearest(p).signedDistance, -r, 1e-6 * r);
  }
}

TEST(Covering, SitsAtTheOffsetThatIsAskedFor) {
  const TriangleMesh mesh = makeCylinder(0.5, 1.2, 32);
  const MeshDistance distance(mesh);
  const double r = 0.06;
  for (double offset : {-0.5 * r, 0.0, r}) {
    CoverReport report;
    const Covering covering = coverMesh(mesh, {.particleRadius = r, .offset = offset}, &report);
    EXPECT_TRUE(report.holesClosed) << offset << ": " << report.text();
    for (const Vector3& p : covering.positions)
      EXPECT_NEAR(distance.nearest(p).signedDistance, offset, 1e-6 * r);
  }
}

TEST(Covering, EnvelopeTouchesTheFacesAndRoundsOffTheCorners) {
  const double r = 0.08;
  CoverReport report;
  const Covering covering = coverMesh(makeBox({2.0, 2.0, 2.0}), {.particleRadius = r}, &report);
  // Halfway between particles a apart in an even layer the envelope lies r - sqrt(r^2 - d^2) deep, d <=
  // a/sqrt(3).
  EXPECT_GT(report.envelopeMean, 0.1 * r);
  EXPECT_LT(report.envelopeMean, 0.4 * r);
  EXPECT_GT(report.envelopeMax,
            (std::numbers::sqrt3 - 1.0) * r - 0.1 * r);  // a corner is sqrt(3) r from its particle at best
}

TEST(Covering, HoldsPlatesThinnerThanAParticle) {
  const double r = 0.05;
  for (double thickness : {0.1 * r, 1.0 * r, 1.9 * r, 2.0 * r, 2.1 * r, 2.6 * r}) {
    CoverReport report;
    const Covering covering = coverMesh(makeBox({1.0, 0.8, thickness}), {.particleRadius = r}, &report);
    EXPECT_TRUE(report.holesClosed) << thickness / r << " r: " << report.text();
    // All over the plate's middle, but for its rim, something is within a grain's reach.
    double worst = 0.0;
    for (double x = -0.5 + r; x <= 0.5 - r; x += 0.2 * r) {
      for (double y = -0.4 + r; y <= 0.4 - r; y += 0.2 * r) {
        worst = std::max(worst, nearestDistance(covering, {x, y, 0.0}) - r);
      }
    }
    EXPECT_LT(worst, 0.65 * r) << thickness / r << " r";
    // The layer is in the middle, not on the faces: at 0.9 of half the thickness, 0.7 near the rim.
    for (const Vector3& p : covering.positions) {
      EXPECT_LE(std::abs(p[2]), std::max(0.5 * thickness - r, 0.3 * 0.5 * thickness) + 1e-3 * r);
    }
  }
}

TEST(Covering, HoldsABallSmallerThanAParticle) {
  CoverReport report;
  const Covering covering = coverMesh(makeIcosphere(0.5, 3), {.particleRadius = 1.0}, &report);
  ASSERT_GE(covering.positions.size(), 1u);
  EXPECT_LE(covering.positions.size(), 2u);
  for (const Vector3& p : covering.positions) EXPECT_LT(p.norm(), 0.1);
}

TEST(Covering, SameSeedSameBitsOnAnyNumberOfThreads) {
  const TriangleMesh torus = makeTorus(1.0, 0.35, 40, 20);
  const Covering one = coverMesh(torus, {.particleRadius = 0.09, .seed = 4, .threads = 1});
  EXPECT_EQ(one.positions, coverMesh(torus, {.particleRadius = 0.09, .seed = 4, .threads = 3}).positions);
  EXPECT_NE(one.positions, coverMesh(torus, {.particleRadius = 0.09, .seed = 5}).positions);
}

TEST(Covering, TakesASecondLayer) {
  const TriangleMesh ball = makeIcosphere(1.0, 4);
  Covering covering = coverMesh(ball, {.particleRadius = 0.2});
  const std::size_t first = covering.positions.size();
  append(covering, coverMesh(ball, {.particleRadius = 0.1, .offset = 0.0, .seed = 2}));
  ASSERT_EQ(covering.positions.size(), covering.radii.size());
  EXPECT_GT(covering.positions.size(), 2 * first);
  EXPECT_EQ(covering.radii.front(), 0.2);
  EXPECT_EQ(covering.radii.back(), 0.1);
}

TEST(Covering, ReportSaysWhatWasMeasured) {
  CoverReport report;
  const Covering covering = coverMesh(makeIcosphere(1.0, 4), {.particleRadius = 0.1}, &report);
  EXPECT_EQ(report.particleCount, static_cast<std::int64_t>(covering.positions.size()));
  EXPECT_TRUE(report.converged);
  EXPECT_LE(report.spacingMin, report.spacingMedian);
  EXPECT_LE(report.spacingMedian, report.spacingMax);
  EXPECT_EQ(report.holeBound, 0.05);
  EXPECT_NE(report.text().find("largest hole"), std::string::npos);
}

/// Particles whose envelope is nearest to p: how far it is from p.
double envelopeGap(const Covering& covering, const Vector3& p) {
  double best = 1e300;
  for (std::size_t i = 0; i < covering.positions.size(); ++i) {
    best = std::min(best, std::abs((covering.positions[i] - p).norm() - covering.radii[i]));
  }
  return best;
}

// A box of 90 degrees: the particle nearest to a point of an edge stands on the crease at best, sqrt(2) r
// from the edge, and up to half a spacing (2.1 r) along it: sqrt(2 + 1.05^2) - 1 = 0.76. A corner is sqrt(3)
// r away.
TEST(Covering, KeepsTheEdgesOfABoxAsSharpAsParticlesOfItsSizeCan) {
  const double r = 0.08;
  CoverReport report;
  const Covering covering = coverMesh(makeBox({2.0, 2.0, 2.0}), {.particleRadius = r}, &report);
  EXPECT_LT(report.edgeMax, 0.77 * r);
  EXPECT_NEAR(report.edgeLength, 24.0, 0.1 * 24.0);
  double worst = 0.0;
  for (int n = 0; n <= 200; ++n) worst = std::max(worst, envelopeGap(covering, {1.0, -1.0, -1.0 + 0.01 * n}));
  EXPECT_LT(worst, 0.77 * r);
  for (int c = 0; c < 8; ++c) {
    const Vector3 corner(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1);
    EXPECT_NEAR(envelopeGap(covering, corner), (std::numbers::sqrt3 - 1.0) * r, 0.02 * r)
        << corner.transpose();
  }
}

TEST(Covering, OfSmallerParticlesAtTheEdgesHalvesTheErrorThere) {
  const double r = 0.08;
  CoverReport plain, fine;
  coverMesh(makeBox({2.0, 2.0, 2.0}), {.particleRadius = r}, &plain);
  const Covering covering =
      coverMesh(makeBox({2.0, 2.0, 2.0}), {.particleRadius = r, .edgeParticleRadius = 0.5 * r}, &fine);
  EXPECT_LT(fine.edgeMax, 0.77 * 0.5 * r);
  EXPECT_GT(plain.edgeMean, 1.5 * fine.edgeMean);
  EXPECT_EQ(covering.radii.size(), covering.positions.size());
  // Nowhere beyond the faces: the envelope keeps the body's size.
  for (std::size_t i = 0; i < covering.positions.size(); ++i) {
    EXPECT_LT(covering.positions[i].cwiseAbs().maxCoeff() + covering.radii[i], 1.0 + 1e-3 * r);
  }
}

TEST(Covering, OfABoxWithoutALidClosesIt) {
  TriangleMesh open = makeBox({1.0, 1.0, 1.0});
  weldVertices(open);
  std::erase_if(open.triangles, [&](const auto& t) {
    return open.vertices[t[0]][2] + open.vertices[t[1]][2] + open.vertices[t[2]][2] > 1.4;
  });
  CoverReport report;
  const Covering covering = coverMesh(open, {.particleRadius = 0.08}, &report);
  EXPECT_EQ(report.repair.closedGaps, 1);
  EXPECT_NEAR(report.repair.closingArea, 1.0, 1e-12);
  EXPECT_TRUE(report.holesClosed) << report.text();
  EXPECT_LT(largestHole(covering, boxSamples(0.5 - 0.08, 5000)), 0.5 * 0.08);
}

TEST(Covering, OfOverlappingBoxesLeavesNothingInside) {
  TriangleMesh cross = makeBox({2.0, 0.6, 0.6});
  append(cross, makeBox({0.6, 2.0, 0.6}));
  CoverReport report;
  const double r = 0.05;
  const Covering covering = coverMesh(cross, {.particleRadius = r}, &report);
  EXPECT_GT(report.repair.buriedTriangles.count, 0);
  EXPECT_TRUE(report.holesClosed) << report.text();
  const auto inBox = [](const Vector3& p, double x, double y) {
    return std::min({x - std::abs(p[0]), y - std::abs(p[1]), 0.3 - std::abs(p[2])});
  };
  for (const Vector3& p : covering.positions) {
    // Depth below the surface of the union.
    EXPECT_LT(std::max(inBox(p, 1.0, 0.3), inBox(p, 0.3, 1.0)), 1.5 * r) << p.transpose();
  }
}

TEST(Covering, OfASheetHoldsGrainsFromBothSides) {
  CoverReport report;
  const double r = 0.04;
  const Covering covering =
      coverMesh(makePlanePatch(1.0, 0.8, 4), {.particleRadius = r, .sheetThickness = 0.02}, &report);
  EXPECT_TRUE(report.holesClosed) << report.text();
  std::vector<Vector3> middle;
  for (double x = -0.5 + r; x <= 0.5 - r; x += 0.2 * r) middle.emplace_back(x, 0.013, 0.0);
  EXPECT_LT(largestHole(covering, middle), 0.65 * r);
  for (const Vector3& p : covering.positions) EXPECT_LT(std::abs(p[2]), 0.01);
}

TEST(Covering, RefusesWhatItCannotCover) {
  EXPECT_THROW(coverMesh(makePlanePatch(1.0, 1.0), {.particleRadius = 0.1}), std::invalid_argument);
  const TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  EXPECT_THROW(coverMesh(box, {}), std::invalid_argument);
  EXPECT_THROW(coverMesh(box, {.particleRadius = -1.0}), std::invalid_argument);
  EXPECT_THROW(coverMesh(box, {.particleRadius = 0.1, .density = 0.0}), std::invalid_argument);
  EXPECT_THROW(coverMesh(box, {.particleRadius = 0.1, .offset = 1e9}), std::invalid_argument);
  EXPECT_THROW(coverMesh(box, {.particleRadius = 1e-5}), std::invalid_argument);  // 10^10 particles
  try {
    coverMesh(box, {.particleRadius = -0.01});
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "CoverDef.particleRadius is -0.01 m; it must be finite and > 0");
  }
}

}  // namespace
}  // namespace granular
