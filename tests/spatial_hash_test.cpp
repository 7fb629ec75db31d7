// SPDX-License-Identifier: MIT
#include "granular/search/spatial_hash.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <set>

#include "granular/base/random.h"

namespace granular {
namespace {

/// Particles of all sizes up to `largest` radii of 0.02 m in a cube of 1 m.
struct Points {
  std::vector<ParticleRow> rows;
  std::vector<double> margin;
  std::vector<std::int32_t> rank;

  Points(int count, double largest, Random& random) : margin(count, 0.0), rank(count) {
    for (int i = 0; i < count; ++i) {
      rows.push_back(
          {random.uniform(), random.uniform(), random.uniform(), 0.02 * random.uniform(1.0, largest)});
    }
    std::iota(rank.rbegin(), rank.rend(), 0);
  }
  void placeIn(SpatialHash& hash) const {
    hash.place({.particles = rows, .margin = margin, .rank = rank, .firstSlot = 7}, Executor(2));
  }
  Vector3 center(int i) const { return {rows[i].x, rows[i].y, rows[i].z}; }
};

std::set<std::int32_t> found(const SpatialHash& hash, const Box& box, double reach) {
  SpatialHash::Cursors cursors;
  std::vector<SpatialHash::Run> runs;
  hash.findRuns(box, reach, cursors, runs);
  std::set<std::int32_t> slots;
  for (const SpatialHash::Run& run : runs) {
    for (std::int32_t at = run.begin; at < run.end; ++at) {
      EXPECT_TRUE(slots.insert(SpatialHash::slotOf(hash.tag()[at])).second) << "found twice";
    }
  }
  return slots;
}

/// Every particle that reaches a ball about some place is found there; few others are.
void expectFindsAll(const SpatialHash& hash, const Points& points, Random& random) {
  ASSERT_EQ(hash.size(), static_cast<std::int32_t>(points.rows.size()));
  std::size_t visited = 0;
  for (int query = 0; query < 300; ++query) {
    const Vector3 p(random.uniform(), random.uniform(), random.uniform());
    const double reach = random.uniform(0.0, 0.1);
    const std::set<std::int32_t> slots = found(hash, {p, p}, reach);
    visited += slots.size();
    for (int i = 0; i < hash.size(); ++i) {
      if ((points.center(i) - p).norm() < reach + points.rows[i].radius + points.margin[i]) {
        EXPECT_TRUE(slots.contains(7 + i)) << i;
      }
    }
  }
  EXPECT_LT(visited, 300 * points.rows.size() / 4);
}

TEST(SpatialHash, FindsAllThatBruteForceFinds) {
  Random random(5);
  const Points points(1000, 1.5, random);
  SpatialHash hash;
  points.placeIn(hash);
  expectFindsAll(hash, points, random);
}

TEST(SpatialHash, FindsAllAmongManySizes) {
  Random random(8);
  Points points(1000, 1.0, random);
  for (int i = 0; i < 1000; i += 50) points.rows[i].radius *= 1.0 + 0.3 * (i % 7);
  SpatialHash hash;
  points.placeIn(hash);
  expectFindsAll(hash, points, random);
}

TEST(SpatialHash, StaysRightWhileParticlesCrossBordersAndReachFartherOrLess) {
  Random random(6);
  Points points(500, 1.2, random);
  SpatialHash hash;
  points.placeIn(hash);
  for (int round = 0; round < 30; ++round) {
    for (int i = 0; i < 500; ++i) {
      ParticleRow& row = points.rows[i];
      row.x += random.uniform(-0.01, 0.01), row.y += random.uniform(-0.01, 0.01);
      points.margin[i] = random.uniform() < 0.02 ? 0.08 : 0.003;
    }
    points.placeIn(hash);
  }
  EXPECT_GT(hash.moveCount(), 500);
  expectFindsAll(hash, points, random);
}

TEST(SpatialHash, LiesInTheOrderOfAFreshOneAfterAnyHistory) {
  Random random(9);
  Points points(300, 1.3, random);
  SpatialHash hash;
  points.placeIn(hash);
  const std::vector<ParticleRow> start = points.rows;
  for (ParticleRow& row : points.rows) row.z += random.uniform(-0.3, 0.3);
  points.placeIn(hash);
  points.rows = start;
  points.placeIn(hash);
  SpatialHash fresh;
  points.placeIn(fresh);
  EXPECT_TRUE(std::equal(hash.tag().begin(), hash.tag().end(), fresh.tag().begin(), fresh.tag().end()));
}

TEST(SpatialHash, ChangesNothingWhenParticlesStayInTheirVoxels) {
  const std::vector<ParticleRow> before = {{0.1, 0.1, 0.1, 1.0}, {0.5, 0.5, 0.5, 1.0}};
  const std::vector<ParticleRow> after = {{0.3, 0.1, 0.2, 1.0}, {0.5, 0.5, 0.5, 1.0}};
  const std::vector<std::int32_t> rank = {0, 1};
  SpatialHash hash;
  hash.place({.particles = before, .margin = {}, .rank = rank}, Executor(1));
  // Borders are at the second one, and 2.4 radii from it.
  hash.place({.particles = after, .margin = {}, .rank = rank}, Executor(1));
  EXPECT_EQ(hash.moveCount(), 0);
  EXPECT_TRUE(hash.x()[0] == 0.3 || hash.x()[1] == 0.3) << "but where they are";
}

// Otherwise a scene that blows up would not end: voxels between its pieces are more than can be walked
// through.
TEST(SpatialHash, ReadsNoMoreRunsThanThereAreVoxelsWhereverThingsAre) {
  Random random(5);
  Points points(100, 3.0, random);
  for (int i = 0; i < 3; ++i)
    points.rows[i].x = points.rows[i].y = (i - 1) * 1e90, points.rows[i].z = i * 1e30;
  SpatialHash hash;
  points.placeIn(hash);
  SpatialHash::Cursors cursors;
  std::vector<SpatialHash::Run> runs;
  const Box all{Vector3::Constant(-1e100), Vector3::Constant(1e100)};
  hash.findRuns(all, 0.1, cursors, runs);
  EXPECT_LE(static_cast<std::int32_t>(runs.size()), hash.voxelCount());
  EXPECT_EQ(found(hash, all, 0.1).size(), points.rows.size());
}

TEST(SpatialHash, SurvivesPositionsBeyondAllReason) {
  Random random(10);
  Points points(500, 1.2, random);
  points.rows[0].x = 1e300;
  points.rows[1].y = -1e300;
  points.rows[2].z = std::numeric_limits<double>::quiet_NaN();
  points.margin[3] = std::numeric_limits<double>::infinity();
  SpatialHash hash;
  points.placeIn(hash);
  ASSERT_EQ(hash.size(), 500);
  points.margin[3] = 0.0;
  points.placeIn(hash);
  points.rows[2].z = 0.5;
  points.placeIn(hash);
  expectFindsAll(hash, points, random);
}

}  // namespace
}  // namespace granular
