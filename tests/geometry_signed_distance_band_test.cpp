// SPDX-License-Identifier: MIT
// The exact distance to a mesh, and the band sampled from it.
#include "granular/geometry/signed_distance_band.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "granular/base/random.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

Vector3 randomPoint(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

/// Signed distance to a box of half size h about the origin, closed form.
double boxDistance(const Vector3& p, const Vector3& h) {
  const Vector3 q = p.cwiseAbs() - h;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

/// Nearest distance by trying every triangle on a fine lattice of its points, an upper bound good to `step`.
double bruteDistance(const TriangleMesh& mesh, const Vector3& p, int steps) {
  double best = 1e300;
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i <= steps; ++i) {
      for (int j = 0; i + j <= steps; ++j) {
        const Vector3 q =
            (i * mesh.vertices[t[0]] + j * mesh.vertices[t[1]] + (steps - i - j) * mesh.vertices[t[2]]) /
            steps;
        best = std::min(best, (p - q).norm());
      }
    }
  }
  return best;
}

TEST(MeshDistance, IsTheClosedFormRoundABox) {
  const Vector3 half(0.5, 0.75, 1.0);
  const MeshDistance distance(makeBox(2.0 * half));
  Random random(3);
  for (int n = 0; n < 5000; ++n) {
    const Vector3 p = randomPoint(random, 2.0);
    EXPECT_NEAR(distance.nearest(p).signedDistance, boxDistance(p, half), 1e-14) << p.transpose();
  }
}

TEST(MeshDistance, IsWhatTryingEveryTriangleGives) {
  const TriangleMesh torus = makeTorus(1.0, 0.4, 12, 8);
  const MeshDistance distance(torus);
  Random random(5);
  for (int n = 0; n < 100; ++n) {
    const Vector3 p = randomPoint(random, 1.6);
    const double brute = bruteDistance(torus, p, 40);  // lattice cells of 0.5/40 m: at most 0.009 m too far
    const double exact = std::abs(distance.nearest(p).signedDistance);
    EXPECT_LE(exact, brute + 1e-12);
    EXPECT_GE(exact, brute - 0.01);
  }
}

TEST(MeshDistance, SignIsRightWhereThePlainNormalOfTheNearestFaceWouldBeWrong) {
  // Above a sharp spike: the nearest feature is its tip, and the normals of some of its faces point away.
  TriangleMesh spike;
  spike.vertices = {{0.0, 0.0, 1.0}, {0.1, 0.0, 0.0}, {-0.1, 0.1, 0.0}, {-0.1, -0.1, 0.0}};
  spike.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}};
  ASSERT_TRUE(checkMesh(spike).isSolid());
  const MeshDistance distance(spike);
  Random random(11);
  for (int n = 0; n < 1000; ++n) {
    const Vector3 p = Vector3(0.0, 0.0, 1.0) +
                      0.1 * Vector3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 1));
    EXPECT_GT(distance.nearest(p).signedDistance, 0.0) << p.transpose();
  }
}

TEST(MeshDistance, AHintChangesNoBit) {
  const TriangleMesh mesh = makeIcosphere(1.0, 3);
  const MeshDistance distance(mesh);
  Random random(13);
  for (int n = 0; n < 2000; ++n) {
    const Vector3 p = randomPoint(random, 1.5);
    const auto hint =
        static_cast<std::int32_t>(random.uniform(0.0, static_cast<double>(mesh.triangles.size())));
    const NearestPoint plain = distance.nearest(p), hinted = distance.nearest(p, hint);
    EXPECT_EQ(plain.signedDistance, hinted.signedDistance);
    EXPECT_EQ(plain.triangle, hinted.triangle);
    EXPECT_EQ(plain.point, hinted.point);
  }
}

TEST(MeshDistance, NearestWithinAnswersOnlyWithinTheDistance) {
  const MeshDistance distance(makeBox({2.0, 2.0, 2.0}));
  EXPECT_FALSE(distance.nearestWithin({1.5, 0.0, 0.0}, 0.49));
  EXPECT_TRUE(distance.nearestWithin({1.5, 0.0, 0.0}, 0.51));
}

TEST(MeshDistance, RefusesAMeshItCannotIndex) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  mesh.triangles[0][0] = 99;
  EXPECT_THROW(MeshDistance{mesh}, std::invalid_argument);
  EXPECT_THROW(MeshDistance{TriangleMesh{}}, std::invalid_argument);
}

TEST(SignedDistanceBand, MatchesTheSphereFormulaWithinOneVoxel) {
  // Trilinear interpolation of |p| errs by up to h^2/8 times the sum of second derivatives, 2/|p|: h^2/4/0.7;
  // the facets of subdivision 5 add at most 4e-4.
  const double h = 0.1;
  const SignedDistanceBand band(MeshDistance(makeIcosphere(1.0, 5)),
                                {.spacing = h, .lower = -2 * h, .upper = 2 * h});
  Random random(17);
  int inBand = 0;
  for (int n = 0; n < 20000; ++n) {
    const Vector3 p = randomPoint(random, 1.3);
    const double exact = p.norm() - 1.0;
    const auto sample = band.sample(p);
    if (std::abs(exact) < 2 * h) {
      ASSERT_TRUE(sample) << p.transpose();
    }
    if (!sample || std::abs(exact) > 2 * h) continue;
    ++inBand;
    EXPECT_NEAR(sample->value, exact, h * h / 2.8 + 4e-4);
    EXPECT_LT((sample->gradient - p.normalized()).norm(), 0.15);  // h/2 times the second derivatives, about
  }
  EXPECT_GT(inBand, 3000);
}

TEST(SignedDistanceBand, IsExactAtItsNodes) {
  const Vector3 half(0.5, 0.4, 0.3);
  const SignedDistanceBand band(MeshDistance(makeBox(2.0 * half)),
                                {.spacing = 0.07, .lower = -0.1, .upper = 0.2});
  int nodes = 0;
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j) {
      for (int k = 0; k < 40; ++k) {
        const auto value = band.nodeValue(i, j, k);
        if (!value) continue;
        ++nodes;
        EXPECT_NEAR(*value, boxDistance(band.nodePosition(i, j, k), half), 1e-14);
      }
    }
  }
  EXPECT_GT(nodes, 1000);
}

TEST(SignedDistanceBand, IsExactInFrontOfAFlatFace) {
  const double h = 0.1;
  const SignedDistanceBand band(MeshDistance(makeBox({2.0, 2.0, 2.0})),
                                {.spacing = h, .lower = -0.2, .upper = 0.2});
  Random random(19);
  for (int n = 0; n < 2000; ++n) {
    const Vector3 p(random.uniform(0.8, 1.2), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    const auto sample = band.sample(p);
    ASSERT_TRUE(sample);
    EXPECT_NEAR(sample->value, p[0] - 1.0, 1e-13);
    EXPECT_LT((sample->gradient - Vector3::UnitX()).norm(), 1e-11);
  }
}

TEST(SignedDistanceBand, SignIsRightAtEdgesAndVerticesOfABox) {
  const Vector3 half(0.5, 0.4, 0.3);
  const MeshDistance distance(makeBox(2.0 * half));
  Random random(23);
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 signs(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    for (int n = 0; n < 500; ++n) {
      const Vector3 out(random.uniform(0.0, 0.1), random.uniform(0.0, 0.1), random.uniform(0.0, 0.1));
      EXPECT_GT(distance.nearest((half + out).cwiseProduct(signs)).signedDistance, 0.0);
      EXPECT_LT(distance.nearest((half - out).cwiseProduct(signs)).signedDistance, 0.0);
      Vector3 beside = out;  // outside one face only, in front of an edge
      beside[n % 3] = -out[n % 3] * 0.99;
      EXPECT_GT(distance.nearest((half + beside).cwiseProduct(signs)).signedDistance, 0.0);
    }
  }
}

TEST(SignedDistanceBand, MemoryGrowsWithTheSurface) {
  const TriangleMesh ball = makeIcosphere(1.0, 4);
  const MeshDistance distance(ball);
  const auto nodes = [&](double h) {
    return static_cast<double>(
        SignedDistanceBand(distance, {.spacing = h, .lower = -h, .upper = h}).nodeCount());
  };
  // Halving the spacing: four times for a surface, eight times for a volume.
  EXPECT_NEAR(nodes(0.02) / nodes(0.04), 4.0, 0.3);
  EXPECT_LT(nodes(0.02), 20.0 * surfaceArea(ball) / (0.02 * 0.02));
}

TEST(SignedDistanceBand, HasTheSameBitsForAnyThreadCount) {
  const MeshDistance distance(makeTorus(1.0, 0.4, 30, 20));
  const BandDef def{.spacing = 0.05, .lower = -0.1, .upper = 0.1};
  BandDef threaded = def;
  threaded.threads = 3;
  const SignedDistanceBand one(distance, def), three(distance, threaded);
  for (int i = 0; i < 64; ++i) {
    for (int j = 0; j < 64; ++j) {
      for (int k = 0; k < 24; ++k) EXPECT_EQ(one.nodeValue(i, j, k), three.nodeValue(i, j, k));
    }
  }
}

TEST(SignedDistanceBand, RefusesASpacingFarTooFine) {
  const MeshDistance distance(makeBox({1.0, 1.0, 1.0}));
  EXPECT_THROW(SignedDistanceBand(distance, {.spacing = 1e-7, .lower = 0.0, .upper = 0.0}),
               std::invalid_argument);
  EXPECT_THROW(SignedDistanceBand(distance, {.spacing = 0.0, .lower = 0.0, .upper = 0.0}),
               std::invalid_argument);
  EXPECT_THROW(SignedDistanceBand(distance, {.spacing = 0.1, .lower = 0.1, .upper = 0.0}),
               std::invalid_argument);
}

TEST(SignedDistanceBand, RefusesMoreVoxelsThanAllowed) {
  const MeshDistance box(makeBox({1.0, 1.0, 1.0}));
  const BandDef def{.spacing = 0.01, .lower = -0.02, .upper = 0.02, .maxVoxels = 10'000};
  try {
    const SignedDistanceBand band(box, def);
    FAIL() << "six faces of 100 x 100 voxels, four deep, are more";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("BandDef.maxVoxels"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace granular
