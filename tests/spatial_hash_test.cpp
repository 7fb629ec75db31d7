// SPDX-License-Identifier: MIT
#include "granular/search/spatial_hash.h"

#include <gtest/gtest.h>

#include <set>

#include "granular/base/random.h"

namespace granular {
namespace {

std::vector<Vector3> randomPoints(int count, double size, Random& random) {
  std::vector<Vector3> points(count);
  for (Vector3& p : points) {
    p = {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
  }
  return points;
}

std::set<std::int32_t> neighbourhood(const SpatialHash& hash, std::int32_t voxel) {
  std::set<std::int32_t> found;
  for (const std::int32_t near : hash.neighbours(voxel)) {
    if (near < 0) continue;
    for (std::int32_t i = hash.first(near); i >= 0; i = hash.next(i)) found.insert(i);
  }
  return found;
}

void expectFindsAllPairs(const SpatialHash& hash, const std::vector<Vector3>& points) {
  const auto count = static_cast<std::int32_t>(points.size());
  std::vector<std::set<std::int32_t>> near(count);
  std::int32_t held = 0;
  for (std::int32_t v = 0; v < hash.voxelCount(); ++v) {
    const auto found = neighbourhood(hash, v);
    for (std::int32_t i = hash.first(v); i >= 0; i = hash.next(i), ++held) near[i] = found;
  }
  ASSERT_EQ(held, count);
  for (std::int32_t i = 0; i < count; ++i) {
    for (std::int32_t j = 0; j < count; ++j) {
      const double apart = (points[i] - points[j]).norm();
      if (apart <= hash.voxelEdge()) {
        EXPECT_TRUE(near[i].contains(j)) << i << " " << j;
      }
      if (apart > 2.0 * std::sqrt(3.0) * hash.voxelEdge()) {
        EXPECT_FALSE(near[i].contains(j)) << i << " " << j;
      }
    }
  }
}

TEST(SpatialHash, FindsExactlyTheParticlesBruteForceFinds) {
  Random random(5);
  std::vector<Vector3> points = randomPoints(400, 1.0, random);
  SpatialHash hash;
  hash.reset(0.2, 400);
  for (int i = 0; i < 400; ++i) hash.place(i, points[i]);
  expectFindsAllPairs(hash, points);
}

TEST(SpatialHash, StaysRightWhileParticlesCrossBorders) {
  Random random(6);
  std::vector<Vector3> points = randomPoints(200, 0.5, random);
  SpatialHash hash;
  hash.reset(0.15, 200);
  for (int round = 0; round < 30; ++round) {
    for (int i = 0; i < 200; ++i) {
      points[i] += 0.05 * Vector3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      hash.place(i, points[i]);
    }
  }
  expectFindsAllPairs(hash, points);
  EXPECT_GT(hash.moveCount(), 200);
}

TEST(SpatialHash, ChangesNothingWhenParticlesStayInTheirVoxels) {
  SpatialHash hash;
  hash.reset(1.0, 2);
  hash.place(0, {0.2, 0.2, 0.2});
  hash.place(1, {0.7, 0.7, 0.7});
  hash.place(0, {0.4, 0.1, 0.9});
  EXPECT_EQ(hash.moveCount(), 0);
  EXPECT_EQ(hash.voxelCount(), 1);
}

TEST(SpatialHash, SurvivesPositionsBeyondAllReason) {
  SpatialHash hash;
  hash.reset(0.01, 2);
  hash.place(0, {1e300, -1e300, 0.0});
  hash.place(1, {0.0, 0.0, 0.0});
  EXPECT_EQ(hash.voxelCount(), 2);
}

}  // namespace
}  // namespace granular
