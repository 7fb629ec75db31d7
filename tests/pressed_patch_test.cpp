// SPDX-License-Identifier: MIT
// PressedPatch against a solid cut into a million small cubes, and its parts against each other.
#include "granular/contact/pressed_patch.h"

#include <gtest/gtest.h>

#include <cmath>

#include "granular/base/random.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

const Vector3 kSize(0.3, 0.2, 0.1);

std::vector<SurfacePiece> boxPieces() {
  const TriangleMesh box = makeBox(kSize);
  std::vector<SurfacePiece> pieces;
  for (const auto& t : box.triangles) {
    pieces.push_back({0, {box.vertices[t[0]], box.vertices[t[1]], box.vertices[t[2]]}});
  }
  return pieces;
}

/// Directions in which faces, edges and corners go first.
const Vector3 kDirections[] = {{0, -1, 0}, {0, -1, 1e-9}, {0.7, 0.7, 0}, {1, -2, 0.5}, {-0.3, 0.5, -0.9}};

/// How far the box reaches along N.
double reach(const Vector3& N) {
  return 0.5 * kSize.dot(N.cwiseAbs());
}

// As long as only the underside is below.
TEST(PressedPatch, OfABoxIsTheVolumeBelow) {
  const std::vector<SurfacePiece> pieces = boxPieces();
  constexpr int kCells = 100;
  for (const Vector3& direction : kDirections) {
    const Vector3 N = direction.normalized();
    for (const double depth : {0.01, 0.06}) {
      const double distance = reach(N) - depth;
      double count = 0.0;
      Vector3 middle = Vector3::Zero();
      for (int i = 0; i < kCells * kCells * kCells; ++i) {
        const Vector3 cell(i % kCells, i / kCells % kCells, i / kCells / kCells);
        const Vector3 p =
            kSize.cwiseProduct((cell + Vector3::Constant(0.5)) / kCells - Vector3::Constant(0.5));
        if (N.dot(p) <= distance) continue;
        count += 1.0;
        middle += p;
      }
      const double volume = kSize.prod() * count / std::pow(kCells, 3);
      const PressedPatch patch = pressedPatch(pieces, Vector3::Zero(), distance, N);
      // The cut goes through one layer of cells: half of it is uncertain at most.
      EXPECT_NEAR(patch.area * patch.depth, volume, 0.5 * patch.area * kSize.maxCoeff() / kCells);
      const Vector3 offset = patch.center - middle / count;
      EXPECT_LT((offset - offset.dot(N) * N).norm(), kSize.maxCoeff() / kCells) << N.transpose();
    }
  }
}

TEST(PressedPatch, GivesForcesThatAreTheSlopeOfItsEnergy) {
  const std::vector<SurfacePiece> pieces = boxPieces();
  for (const Vector3& direction : kDirections) {
    const Vector3 N = direction.normalized();
    for (const double depth : {0.01, 0.06}) {
      const auto at = [&](double d) { return pressedPatch(pieces, Vector3::Zero(), reach(N) - d, N); };
      const auto energy = [&](double d) { return 0.5 * at(d).area * at(d).meanSquareDepth; };
      const double h = 1e-5;
      const PressedPatch patch = at(depth);
      EXPECT_NEAR((energy(depth + h) - energy(depth - h)) / (2.0 * h), patch.area * patch.depth,
                  1e-6 * patch.area * patch.depth + 1e-12);
      // Where a whole edge goes in at once the area has a kink, and no slope.
      if (direction.z() == 1e-9) continue;
      EXPECT_NEAR((at(depth + h).area - at(depth - h).area) / (2.0 * h), patch.areaSlope,
                  1e-3 * patch.areaSlope + 1e-9);
    }
  }
}

TEST(PressedPatch, IsNothingAboveTheSurface) {
  const Vector3 N = Vector3(1, -2, 0.5).normalized();
  EXPECT_EQ(pressedPatch(boxPieces(), Vector3::Zero(), reach(N) + 1e-12, N).area, 0.0);
}

TEST(PressedPatch, IsNoDifferentWhereTheSurfaceIsCutUp) {
  std::vector<SurfacePiece> cut;
  Random random(3);
  for (const SurfacePiece& piece : boxPieces()) {
    const auto& [a, b, c] = piece.corners;
    const double s = random.uniform(0.2, 0.4), t = random.uniform(0.2, 0.4);
    const Vector3 inside = a + s * (b - a) + t * (c - a);
    cut.push_back({0, {a, b, inside}});
    cut.push_back({0, {b, c, inside}});
    cut.push_back({0, {c, a, inside}});
  }
  const Vector3 N = Vector3(1, -2, 0.5).normalized();
  const PressedPatch whole = pressedPatch(boxPieces(), Vector3::Zero(), reach(N) - 0.05, N);
  const PressedPatch parts = pressedPatch(cut, Vector3::Zero(), reach(N) - 0.05, N);
  EXPECT_NEAR(parts.area, whole.area, 1e-12 * whole.area);
  EXPECT_NEAR(parts.depth, whole.depth, 1e-12 * whole.depth);
  EXPECT_NEAR(parts.meanSquareDepth, whole.meanSquareDepth, 1e-12 * whole.meanSquareDepth);
  EXPECT_LT((parts.center - whole.center).norm(), 1e-12);
}

}  // namespace
}  // namespace granular
