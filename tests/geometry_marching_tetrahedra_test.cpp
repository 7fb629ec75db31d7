// SPDX-License-Identifier: MIT
#include "granular/geometry/marching_tetrahedra.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

TEST(MarchingTetrahedra, IsWatertight) {
  const TriangleMesh meshes[] = {makeIcosphere(1.0, 3), makeBox({1.0, 1.3, 0.7}), makeTorus(1.0, 0.4, 40, 20),
                                 makeCone(0.6, 1.2, 24)};
  for (const TriangleMesh& mesh : meshes) {
    const SignedDistanceBand band(MeshDistance(mesh), {.spacing = 0.06, .lower = -0.1, .upper = 0.1});
    for (double offset : {-0.1, -0.03, 0.0, 0.1}) {
      const MeshReport report = checkMesh(marchingTetrahedra(band, offset));
      EXPECT_TRUE(report.isSolid()) << offset << ": " << report.text();
      EXPECT_EQ(report.crowdedEdges.count, 0) << offset;
      EXPECT_EQ(report.degenerateTriangles.count, 0) << offset;
    }
  }
}

TEST(MarchingTetrahedra, IsWatertightWhereTheSurfacePassesThroughNodes) {
  // A box on the lattice: whole faces of nodes lie exactly on the surface.
  const auto box = [](const Vector3& p) {
    const Vector3 q = p.cwiseAbs() - Vector3::Constant(0.5);
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
  };
  // Bounds half a spacing larger: the lattice begins half a spacing off theirs.
  const SignedDistanceBand band(box, {Vector3::Constant(-0.5625), Vector3::Constant(0.5625)},
                                {.spacing = 0.125, .lower = 0.0, .upper = 0.0});
  ASSERT_EQ(std::remainder((band.nodePosition(0, 0, 0)[0] - 0.5) / 0.125, 1.0), 0.0);
  const TriangleMesh mesh = marchingTetrahedra(band, 0.0);
  const MeshReport report = checkMesh(mesh);
  EXPECT_TRUE(report.isSolid()) << report.text();
  EXPECT_EQ(report.degenerateTriangles.count, 0);
  for (const Vector3& v : mesh.vertices)
    EXPECT_NEAR(box(v), 0.0, std::sqrt(3.0) * 0.125e-3);  // 1/1000 of an edge
}

double ballVolumeError(double spacing, double offset) {
  const auto ball = [](const Vector3& p) { return p.norm() - 1.0; };
  const SignedDistanceBand band(ball, {Vector3::Constant(-1.0), Vector3::Constant(1.0)},
                                {.spacing = spacing, .lower = offset, .upper = offset});
  const double exact = 4.0 / 3.0 * std::numbers::pi * std::pow(1.0 + offset, 3);
  return std::abs(signedVolume(marchingTetrahedra(band, offset)) / exact - 1.0);
}

TEST(MarchingTetrahedra, VolumeOfASphereConvergesWithTheSquareOfTheSpacing) {
  const double coarse = ballVolumeError(0.1, 0.0), fine = ballVolumeError(0.05, 0.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.5);
  EXPECT_LT(fine, 0.005);
}

TEST(MarchingTetrahedra, OffsetIsPositiveOutside) {
  EXPECT_LT(ballVolumeError(0.05, 0.3), 0.005);
  EXPECT_LT(ballVolumeError(0.05, -0.3), 0.01);
}

TEST(MarchingTetrahedra, IsEmptyDeeperThanThePartIsThick) {
  const SignedDistanceBand band(MeshDistance(makeBox({1.0, 1.0, 0.1})),
                                {.spacing = 0.02, .lower = -0.1, .upper = 0.0});
  EXPECT_TRUE(marchingTetrahedra(band, -0.06).triangles.empty());
}

TEST(MarchingTetrahedra, RefusesAnOffsetOutsideTheBand) {
  const SignedDistanceBand band(MeshDistance(makeBox({1.0, 1.0, 1.0})),
                                {.spacing = 0.1, .lower = -0.1, .upper = 0.1});
  EXPECT_THROW(marchingTetrahedra(band, 0.2), std::invalid_argument);
}

}  // namespace
}  // namespace granular
