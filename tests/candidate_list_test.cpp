// SPDX-License-Identifier: MIT
#include "granular/search/candidate_list.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "granular/base/random.h"
#include "granular/search/candidate_blocks.h"

namespace granular {
namespace {

/// Particles in pairs (two to an owner); the last quarter of the owners do not move.
struct Cloud {
  std::vector<ParticleRow> rows;
  std::vector<double> margin;
  std::vector<std::int32_t> owner, rank;
  std::vector<SurfaceRow> surfaces;
  std::vector<double> surfaceMargin, overhang;
  std::int32_t dynamicCount = 0, movingCount = 0;
  MeetingRules rules;

  /// Radii of all sizes between 0.02 m and the largest, margins of up to 0.02 m.
  explicit Cloud(int count, std::uint64_t seed, double largestRadius = 0.04) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const double radius = 0.02 * std::pow(largestRadius / 0.02, random.uniform());
      rows.push_back({random.uniform(), random.uniform(), random.uniform(), radius});
      owner.push_back(i / 2);
    }
    dynamicCount = count * 3 / 4;
    movingCount = count * 7 / 8;
    for (int i = 0; i < movingCount; ++i) margin.push_back(random.uniform(0.0, 0.02));
    rank.resize(count);
    std::iota(rank.begin(), rank.end(), 0);
    for (int i = dynamicCount - 1; i > 0; --i) {  // ranks in another order than slots
      std::swap(rank[i], rank[random.bits() % (i + 1)]);
    }
  }
  SearchInput input() const {
    return {.particles = rows,
            .surfaces = surfaces,
            .owner = owner,
            .rank = rank,
            .dynamicCount = dynamicCount,
            .movingCount = movingCount,
            .rules = &rules,
            .overhang = overhang,
            .margin = margin,
            .surfaceMargin = surfaceMargin};
  }
  double reach(int i) const { return rows[i].radius + (i < movingCount ? margin[i] : 0.0); }
  Vector3 center(int i) const { return {rows[i].x, rows[i].y, rows[i].z}; }
  bool isCandidate(int i, int j) const {
    return (center(i) - center(j)).norm() < reach(i) + reach(j) && owner[i] != owner[j] &&
           rank[i] < rank[j] && i < dynamicCount && rules.mayMeet(owner[i], owner[j]);
  }

  /// Exact balls, half of them moving, of owners of their own. Particles reach farther to them than to
  /// others.
  void addBalls(int count, std::uint64_t seed) {
    Random random(seed);
    const int owners = owner.back() + 1;
    for (int s = 0; s < count; ++s) {
      surfaces.push_back({.shape = &kBall,
                          .boundingRadius = boundingRadius(kBall),
                          .point = {random.uniform(), random.uniform(), random.uniform()}});
      surfaceMargin.push_back(s % 2 == 0 ? 0.0 : random.uniform(0.0, 0.1));
      owner.push_back(owners + s);
      rank.push_back(static_cast<std::int32_t>(rank.size()));
    }
    for (int o = 0; o < owners + count; ++o) overhang.push_back(random.uniform(0.0, 0.01));
  }
  bool isNearBall(int i, int s) const {
    return (center(i) - surfaces[s].point).norm() <
           kBallRadius + surfaceMargin[s] + reach(i) + overhang[owner[i]];
  }

  static constexpr double kBallRadius = 0.05;
  static inline const ExactSurface kBall = ExactSphere{.radius = kBallRadius};
};

using Pairs = std::set<std::pair<std::int32_t, std::int32_t>>;

Pairs bruteForce(const Cloud& cloud) {
  Pairs pairs;
  const int count = static_cast<int>(cloud.rows.size());
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      if (cloud.isCandidate(i, j)) pairs.insert({i, j});
    }
    for (int b = 0; b < static_cast<int>(cloud.surfaces.size()) && i < cloud.dynamicCount; ++b) {
      if (cloud.isNearBall(i, b)) pairs.insert({i, count + b});
    }
  }
  return pairs;
}

Pairs listed(const CandidateList& list) {
  Pairs pairs;
  for (std::int32_t i = 0; i + 1 < static_cast<std::int32_t>(list.rowStart().size()); ++i) {
    for (std::int32_t c = list.rowStart()[i]; c < list.rowStart()[i + 1]; ++c) {
      EXPECT_TRUE(pairs.insert({i, list.partner()[c]}).second) << "offered twice";
    }
  }
  return pairs;
}

Pairs listedOf(const Cloud& cloud, int threads = 1) {
  CandidateList list;
  list.rebuild(cloud.input(), Executor(threads));
  return listed(list);
}

TEST(CandidateList, HoldsExactlyThePairsBruteForceFinds) {
  const Cloud cloud(1200, 11);
  const Pairs expected = bruteForce(cloud);
  EXPECT_GT(expected.size(), 500u);
  EXPECT_EQ(listedOf(cloud), expected);
}

TEST(CandidateList, HoldsThemAmongParticlesOfManySizes) {
  const Cloud cloud(1500, 15, 0.5);
  EXPECT_EQ(listedOf(cloud, 2), bruteForce(cloud));
}

TEST(CandidateList, HoldsParticlesNearSurfaces) {
  Cloud cloud(900, 16);
  cloud.addBalls(40, 17);
  const Pairs expected = bruteForce(cloud);
  EXPECT_GT(std::count_if(expected.begin(), expected.end(), [](const auto& p) { return p.second >= 900; }),
            100);
  EXPECT_EQ(listedOf(cloud), expected);
}

TEST(CandidateList, ForgetsSurfacesThatAreGone) {
  Cloud cloud(600, 22);
  const Cloud without = cloud;
  cloud.addBalls(40, 23);
  CandidateList list;
  list.rebuild(cloud.input(), Executor(1));
  list.reset();
  list.rebuild(without.input(), Executor(1));
  EXPECT_EQ(listed(list), bruteForce(without));
}

TEST(CandidateList, RowsAreInTheOrderOfRanks) {
  Cloud cloud(900, 18);
  cloud.addBalls(20, 19);
  CandidateList list;
  list.rebuild(cloud.input(), Executor(2));
  for (std::int32_t i = 0; i < cloud.dynamicCount; ++i) {
    std::int32_t last = cloud.rank[i];
    for (std::int32_t c = list.rowStart()[i]; c < list.rowStart()[i + 1]; ++c) {
      EXPECT_GT(cloud.rank[list.partner()[c]], last);
      last = cloud.rank[list.partner()[c]];
    }
  }
}

TEST(CandidateList, IsRightAfterParticlesHaveMoved) {
  Cloud cloud(600, 12, 0.1);
  CandidateList list;
  Random random(1);
  for (int round = 0; round < 5; ++round) {
    for (int i = 0; i < cloud.movingCount; ++i) {
      cloud.rows[i].x += random.uniform(-0.1, 0.1);
      cloud.margin[i] = random.uniform(0.0, 0.02 + 0.1 * round);
    }
    list.rebuild(cloud.input(), Executor(2));
  }
  EXPECT_EQ(listed(list), bruteForce(cloud));
}

TEST(CandidateList, IsRightAfterWhatStandsStillWasMoved) {
  Cloud cloud(600, 20);
  CandidateList list;
  list.rebuild(cloud.input(), Executor(1));
  for (int i = cloud.movingCount; i < 600; ++i) cloud.rows[i].y += 0.03;
  list.fixedMoved();
  list.rebuild(cloud.input(), Executor(1));
  EXPECT_EQ(listed(list), bruteForce(cloud));
}

TEST(CandidateList, DoesNotVisitWhatStandsFarFromAllThatMoves) {
  Cloud cloud(600, 21);
  CandidateList list;
  list.rebuild(cloud.input(), Executor(1));
  const std::int64_t near = list.testCount();
  for (int i = cloud.movingCount; i < 600; ++i) cloud.rows[i].y += 3.0;
  list.fixedMoved();
  list.rebuild(cloud.input(), Executor(1));
  const std::int64_t far = list.testCount();
  EXPECT_LT(far, near);
  cloud.rows.resize(cloud.movingCount);
  CandidateList without;
  without.rebuild(cloud.input(), Executor(1));
  EXPECT_EQ(far, without.testCount());
}

TEST(CandidateList, ObeysMasksAndExcludedPairs) {
  Cloud cloud(600, 13);
  cloud.rules.group.resize(300);
  cloud.rules.mask.resize(300);
  for (int o = 0; o < 300; ++o) {
    cloud.rules.group[o] = o % 3 == 0 ? 2 : 1;
    cloud.rules.mask[o] = o % 5 == 0 ? 1 : 3;
  }
  const auto [i, j] = *listedOf(cloud).begin();
  cloud.rules.excludedPairs = {MeetingRules::pairKey(cloud.owner[i], cloud.owner[j])};
  EXPECT_EQ(listedOf(cloud), bruteForce(cloud));
  EXPECT_FALSE(listedOf(cloud).contains({i, j}));
}

TEST(CandidateBlocks, HaveAllPairsOfTheirOwnOnceInOrderOfRank) {
  constexpr int kCount = 800, kSlotsPerBlock = 100;
  const Cloud cloud(kCount, 14);
  CandidateList list;
  list.rebuild(cloud.input(), Executor(1));
  std::vector<std::int32_t> patchOfSlot(kCount, -1), blockOfPatch, firstSlot;
  for (int i = 0; i < cloud.dynamicCount; ++i) patchOfSlot[i] = cloud.owner[i];
  for (int patch = 0; patch <= cloud.owner[cloud.dynamicCount - 1]; ++patch) {
    blockOfPatch.push_back(2 * patch / kSlotsPerBlock);
  }
  for (int slot = 0; slot <= cloud.dynamicCount; slot += kSlotsPerBlock) firstSlot.push_back(slot);
  const auto blockOf = [&](std::int32_t slot) {
    return patchOfSlot[slot] < 0 ? -1 : blockOfPatch[patchOfSlot[slot]];
  };
  CandidateBlocks blocks;
  blocks.rebuild(list,
                 {.rank = cloud.rank,
                  .patchOfSlot = patchOfSlot,
                  .blockOfPatch = blockOfPatch,
                  .firstSlot = firstSlot,
                  .wantsIndices = true},
                 Executor(2));

  std::vector<std::set<std::int32_t>> seen(firstSlot.size() - 1);
  std::int64_t shared = 0;
  for (std::int32_t block = 0; block + 1 < std::ssize(firstSlot); ++block) {
    std::pair<std::int32_t, std::int32_t> last(-1, -1);
    for (std::int32_t k = blocks.starts()[block]; k < blocks.starts()[block + 1]; ++k) {
      const std::int32_t row = blocks.row()[k], partner = blocks.partner()[k], c = blocks.index()[k];
      EXPECT_TRUE(seen[block].insert(c).second);
      EXPECT_EQ(partner, list.partner()[c]);
      EXPECT_TRUE(list.rowStart()[row] <= c && c < list.rowStart()[row + 1]);
      EXPECT_TRUE(blockOf(row) == block || blockOf(partner) == block);
      const std::pair ranks(cloud.rank[row], cloud.rank[partner]);
      EXPECT_LT(last, ranks);
      last = ranks;
    }
  }
  for (std::int32_t row = 0; row < cloud.dynamicCount; ++row) {
    for (std::int32_t c = list.rowStart()[row]; c < list.rowStart()[row + 1]; ++c) {
      EXPECT_TRUE(seen[blockOf(row)].contains(c));
      const std::int32_t other = blockOf(list.partner()[c]);
      EXPECT_TRUE(other < 0 || seen[other].contains(c));
      shared += other >= 0 && other != blockOf(row);
    }
  }
  EXPECT_GT(shared, 100);
  EXPECT_EQ(blocks.starts().back(), list.size() + shared);
}

}  // namespace
}  // namespace granular
