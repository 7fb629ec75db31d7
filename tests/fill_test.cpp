// SPDX-License-Identifier: MIT
// Fills: every property by brute force over all pairs of particles.
#include "granular/system/fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

struct OwnedParticle {
  Vector3 position;
  double radius;
  std::size_t owner;
};

std::vector<OwnedParticle> particlesOf(const GrainShapeDef& shape, const std::vector<PlacedGrain>& grains) {
  std::vector<OwnedParticle> all;
  for (std::size_t g = 0; g < grains.size(); ++g) {
    for (const ShapeParticle& p : shape.particles) {
      all.push_back({grains[g].pose.toWorld(grains[g].scale * p.position), grains[g].scale * p.radius, g});
    }
  }
  return all;
}

/// Least distance between the surfaces of particles of different grains, m.
double leastGap(const std::vector<OwnedParticle>& all) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      if (all[i].owner == all[j].owner) continue;
      least = std::min(least, (all[i].position - all[j].position).norm() - all[i].radius - all[j].radius);
    }
  }
  return least;
}

double solidVolume(const std::vector<OwnedParticle>& all) {
  double volume = 0.0;
  for (const OwnedParticle& p : all) volume += 4.0 / 3.0 * std::numbers::pi * std::pow(p.radius, 3);
  return volume;
}

/// Lopsided, of unequal particles, drawn far from its middle: what a lattice by bounding spheres would do
/// badly.
GrainShapeDef hammerShape() {
  return {"hammer", {{{1.00, 0, 0}, 0.004}, {{1.007, 0, 0}, 0.005}, {{1.018, 0.002, 0}, 0.009}}};
}

const Box kCube = {{-0.06, 0.01, -0.05}, {0.06, 0.11, 0.07}};

class FillOfShape : public ::testing::TestWithParam<GrainShapeDef> {};

TEST_P(FillOfShape, LeavesTheGapBetweenAllGrains) {
  const FillDef def = {.seed = 3, .gap = 0.02, .minScale = 0.7, .maxScale = 1.2};
  const auto all = particlesOf(GetParam(), fillRegion(boxRegion(kCube), GetParam(), def));
  double smallest = std::numeric_limits<double>::infinity();
  for (const ShapeParticle& p : GetParam().particles) smallest = std::min(smallest, 0.7 * p.radius);
  EXPECT_GE(leastGap(all), 0.02 * smallest - 1e-15);
}

TEST_P(FillOfShape, KeepsEveryParticleInsideTheBox) {
  for (const OwnedParticle& p : particlesOf(GetParam(), fillRegion(boxRegion(kCube), GetParam()))) {
    EXPECT_GE((p.position - kCube.lower).minCoeff(), p.radius - 1e-15);
    EXPECT_GE((kCube.upper - p.position).minCoeff(), p.radius - 1e-15);
  }
}

TEST_P(FillOfShape, OfTheSameSeedIsTheSameGrains) {
  const auto a = fillRegion(boxRegion(kCube), GetParam(), {.seed = 5});
  const auto b = fillRegion(boxRegion(kCube), GetParam(), {.seed = 5});
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].pose.position, b[i].pose.position);
    EXPECT_EQ(a[i].pose.orientation.coeffs(), b[i].pose.orientation.coeffs());
  }
}

TEST_P(FillOfShape, OfAnotherSeedIsOtherGrains) {
  const auto a = fillRegion(boxRegion(kCube), GetParam(), {.seed = 5});
  const auto b = fillRegion(boxRegion(kCube), GetParam(), {.seed = 6});
  EXPECT_NE(a.front().pose.position, b.front().pose.position);
}

INSTANTIATE_TEST_SUITE_P(Shapes, FillOfShape,
                         ::testing::Values(sphereShape(0.005), tetrahedronShape(0.004), cubeShape(0.004),
                                           hammerShape()),
                         [](const auto& shape) { return shape.param.name; });

TEST(Fill, OfTetrahedraIsDenserThanThreeTenthsAwayFromTheBorder) {
  const double r = 0.004;
  const GrainShapeDef shape = tetrahedronShape(r);
  const auto all = particlesOf(shape, fillRegion(boxRegion({{0, 0, 0}, {0.2, 0.2, 0.2}}), shape));
  // Volume of particles with centres in the inner half-width cube: unbiased but for its surface, 2 % here.
  std::vector<OwnedParticle> inner;
  for (const OwnedParticle& p : all) {
    if ((p.position - Vector3::Constant(0.1)).cwiseAbs().maxCoeff() < 0.05) inner.push_back(p);
  }
  EXPECT_GT(solidVolume(inner) / 1e-3, 0.33);
}

TEST(Fill, OrientationsPointEverywhereAlike) {
  const auto grains = fillRegion(boxRegion({{0, 0, 0}, {0.3, 0.3, 0.3}}), sphereShape(0.006));
  Vector3 sum = Vector3::Zero();
  for (const PlacedGrain& g : grains) sum += g.pose.orientation * Vector3::UnitX();
  // A mean of n random directions has a standard deviation of 1/sqrt(3 n) in each component; five of them
  // allowed.
  const double n = static_cast<double>(grains.size());
  EXPECT_GT(n, 1000.0);
  EXPECT_LT((sum / n).cwiseAbs().maxCoeff(), 5.0 / std::sqrt(3.0 * n));
}

TEST(Fill, PlacesExactlyTheCountAskedFor) {
  EXPECT_EQ(fillRegion(boxRegion(kCube), tetrahedronShape(0.004), {.count = 77}).size(), 77u);
}

TEST(Fill, WithACountFillsFromTheBottomAgainstUp) {
  const auto low = fillRegion(boxRegion(kCube), sphereShape(0.005), {.count = 60});
  const auto high = fillRegion(boxRegion(kCube), sphereShape(0.005), {.count = 60, .up = {0, -1, 0}});
  for (const PlacedGrain& g : low) EXPECT_LT(g.pose.position.y(), kCube.center().y());
  for (const PlacedGrain& g : high) EXPECT_GT(g.pose.position.y(), kCube.center().y());
}

TEST(Fill, PacksDenserWhenTheCountNeedsIt) {
  const FillDef loose = {.solidFraction = 0.2};
  const auto few = fillRegion(boxRegion(kCube), tetrahedronShape(0.004), loose);
  FillDef more = loose;
  more.count = static_cast<std::int64_t>(1.3 * static_cast<double>(few.size()));
  const auto grains = fillRegion(boxRegion(kCube), tetrahedronShape(0.004), more);
  EXPECT_EQ(static_cast<std::int64_t>(grains.size()), *more.count);
  EXPECT_GT(leastGap(particlesOf(tetrahedronShape(0.004), grains)), 0.0);
}

TEST(Fill, SaysHowManyFitWhenTheCountDoesNot) {
  try {
    fillRegion(boxRegion(kCube), sphereShape(0.02), {.count = 1000});
    FAIL() << "1000 spheres of 4 cm do not fit into a box of 10 cm";
  } catch (const std::runtime_error& e) {
    EXPECT_TRUE(std::string(e.what()).starts_with("FillDef.count is 1000; only ")) << e.what();
  }
}

TEST(Fill, ThrowsWhenNotOneGrainFits) {
  EXPECT_THROW(fillRegion(boxRegion({{0, 0, 0}, {1, 1, 0.01}}), sphereShape(0.006)), std::runtime_error);
}

TEST(Fill, FindsTheOnlyPlaceInABoxJustLargeEnough) {
  const auto grains = fillRegion(boxRegion({{0, 0, 0}, {0.0101, 0.0101, 0.0101}}), sphereShape(0.005));
  EXPECT_EQ(grains.size(), 1u);
}

TEST(Fill, KeepsClearOfObstacles) {
  const std::vector<ShapeParticle> obstacles = {{{0, 0.05, 0}, 0.03}, {{0.04, 0.02, 0.02}, 0.002}};
  const auto all = particlesOf(tetrahedronShape(0.004), fillRegion(boxRegion(kCube), tetrahedronShape(0.004),
                                                                   {.obstacles = obstacles}));
  for (const OwnedParticle& p : all) {
    for (const ShapeParticle& o : obstacles) EXPECT_GT((p.position - o.position).norm(), p.radius + o.radius);
  }
}

TEST(Fill, OfAConeStaysUnderItsSlope) {
  const Vector3 foot(0.1, -0.2, 0.3);
  const double radius = 0.15;
  const double height = 0.1;
  const auto all =
      particlesOf(tetrahedronShape(0.004),
                  fillRegion(coneRegion(foot, {0, 2, 0}, radius, height), tetrahedronShape(0.004)));
  for (const OwnedParticle& p : all) {
    const Vector3 d = p.position - foot;
    // Distance to the slope through (radius, 0) and (0, height), by Hesse's normal form.
    const double side =
        (radius * height - height * std::hypot(d.x(), d.z()) - radius * d.y()) / std::hypot(radius, height);
    EXPECT_GE(std::min(d.y(), side), p.radius - 1e-12);
  }
}

TEST(Fill, OfATiltedCylinderStaysInside) {
  const Vector3 foot(0.1, 0.2, 0.3);
  const Vector3 axis = Vector3(1, 2, -2) / 3.0;
  const auto all =
      particlesOf(sphereShape(0.005), fillRegion(cylinderRegion(foot, axis, 0.05, 0.2), sphereShape(0.005)));
  double top = 0.0;
  for (const OwnedParticle& p : all) {
    const double z = axis.dot(p.position - foot);
    EXPECT_GE(z, p.radius - 1e-12);
    EXPECT_LE(z, 0.2 - p.radius + 1e-12);
    EXPECT_LE((p.position - foot - z * axis).norm(), 0.05 - p.radius + 1e-12);
    top = std::max(top, z);
  }
  EXPECT_GT(top, 0.18);  // filled to the end, not only where the bounds' corners are
}

TEST(Fill, OfABallHoldsAboutTheBallsShareOfItsCube) {
  const auto ball = fillRegion(ballRegion({0, 0, 0}, 0.1), sphereShape(0.005));
  const auto cube = fillRegion(boxRegion({{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}}), sphereShape(0.005));
  // Room for centres: a ball of 0.095 against a cube of 0.19; the lattice adds a few per cent either way.
  EXPECT_NEAR(static_cast<double>(ball.size()) / static_cast<double>(cube.size()), std::numbers::pi / 6.0,
              0.06);
}

TEST(FillRegionOfASlope, HoldsWhatLiesBetweenThePlaneAndItsDepth) {
  const FillRegion slope = slopeRegion({.foot = {1, 2, 3},
                                        .uphill = {0, 0, -2},
                                        .up = {0, 1, 0},
                                        .angleDegrees = 30.0,
                                        .length = 4.0,
                                        .width = 2.0,
                                        .depth = 0.5});
  const Vector3 along = {0, 0.5, -std::sqrt(0.75)}, normal = {0, std::sqrt(0.75), 0.5};
  const auto at = [&](double s, double n, double across) -> Vector3 {
    return Vector3(1, 2, 3) + s * along + n * normal + across * Vector3(1, 0, 0);
  };
  EXPECT_NEAR(slope.depth(at(2.0, 0.1, 0.0)), 0.1, 1e-12);    // above the plane
  EXPECT_NEAR(slope.depth(at(2.0, 0.45, 0.0)), 0.05, 1e-12);  // below the layer's top
  EXPECT_NEAR(slope.depth(at(0.02, 0.25, 0.0)), 0.02, 1e-12);
  EXPECT_NEAR(slope.depth(at(2.0, 0.25, 0.97)), 0.03, 1e-12);
  EXPECT_LT(slope.depth(at(4.1, 0.25, 0.0)), 0.0);
  for (const double s : {0.0, 4.0}) {
    const Vector3 corner = at(s, 0.5, 1.0);
    EXPECT_GE((corner - slope.bounds.lower).minCoeff(), -1e-12);
    EXPECT_GE((slope.bounds.upper - corner).minCoeff(), -1e-12);
  }
}

TEST(FillRegionOfAMesh, IsTheBoxThatTheMeshIs) {
  const FillRegion mesh = meshRegion(makeBox({0.2, 0.4, 0.6}));
  const FillRegion box = boxRegion({{-0.1, -0.2, -0.3}, {0.1, 0.2, 0.3}});
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3 p = {random.uniform(-0.1, 0.1), random.uniform(-0.2, 0.2), random.uniform(-0.3, 0.3)};
    EXPECT_NEAR(mesh.depth(p), box.depth(p), 1e-12);
  }
  EXPECT_LT(mesh.depth({0.11, 0, 0}), 0.0);
}

TEST(FillRegionOfAMesh, RefusesAnOpenMesh) {
  TriangleMesh open = makeBox({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_THROW(meshRegion(open), std::invalid_argument);
}

TEST(FillRegionOfATurnedBox, HasTheBoundsOfItsCorners) {
  const Quaternion turn(Eigen::AngleAxisd(std::numbers::pi / 6.0, Vector3::UnitZ()));
  const FillRegion box = boxRegion(Pose{{1, 0, 0}, turn}, {2, 1, 4});
  const double x = std::cos(std::numbers::pi / 6.0) + 0.5 * std::sin(std::numbers::pi / 6.0);
  EXPECT_NEAR(box.bounds.upper.x(), 1.0 + x, 1e-12);
  EXPECT_NEAR(box.bounds.upper.z(), 2.0, 1e-12);
  EXPECT_NEAR(box.depth({1, 0, 0}), 0.5, 1e-12);
}

class SizesSpread : public ::testing::TestWithParam<SizeSpread> {};

TEST_P(SizesSpread, StayBetweenTheirBoundsWithTheMeanCubeTheyPromise) {
  Random random(5);
  const double low = 0.5, high = 2.0;
  double cubes = 0.0, squares = 0.0;
  constexpr int kDraws = 200000;
  for (int i = 0; i < kDraws; ++i) {
    const double scale = drawScale(GetParam(), low, high, random);
    ASSERT_GE(scale, low);
    ASSERT_LE(scale, high);
    const double cube = scale * scale * scale;
    cubes += cube;
    squares += cube * cube;
  }
  const double mean = cubes / kDraws;
  const double error = std::sqrt((squares / kDraws - mean * mean) / kDraws);
  EXPECT_NEAR(mean, meanCubeOf(GetParam(), low, high), 4.0 * error);  // four standard errors
}

INSTANTIATE_TEST_SUITE_P(OfEveryKind, SizesSpread,
                         ::testing::Values(SizeSpread::Uniform, SizeSpread::LogUniform,
                                           SizeSpread::EqualVolume));

TEST(Fill, SpreadByEqualVolumeBringsAsMuchInSmallGrainsAsInLarge) {
  const FillDef def = {
      .seed = 2, .solidFraction = 0.1, .minScale = 0.5, .maxScale = 1.5, .sizes = SizeSpread::EqualVolume};
  double small = 0.0, large = 0.0;
  for (const PlacedGrain& grain :
       fillRegion(boxRegion({{-0.2, 0, -0.2}, {0.2, 0.4, 0.2}}), sphereShape(0.006), def)) {
    (grain.scale < 1.0 ? small : large) += std::pow(grain.scale, 3);
  }
  // So few grains that all find room (in dense fills large ones do less often); some 700 large ones, so that
  // four standard errors are 15 %.
  EXPECT_NEAR(small / large, 1.0, 0.15);
}

TEST(Fill, NamesTheSettingThatIsWrong) {
  const auto messageOf = [](const FillDef& def) -> std::string {
    try {
      fillRegion(boxRegion(kCube), sphereShape(0.005), def);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "nothing thrown";
  };
  EXPECT_EQ(messageOf({.count = 0}), "FillDef.count is 0; it must be > 0");
  EXPECT_EQ(messageOf({.solidFraction = 0.8}), "FillDef.solidFraction is 0.8; it must be in (0, 0.7]");
  EXPECT_EQ(messageOf({.minScale = 1.0, .maxScale = 0.5}),
            "FillDef.maxScale is 0.5; it must be finite and >= minScale");
}

}  // namespace
}  // namespace granular
