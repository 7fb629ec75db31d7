// SPDX-License-Identifier: MIT
#include "granular/search/candidate_list.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "granular/base/random.h"

namespace granular {
namespace {

/// Particles in pairs (two to an owner); the last quarter of the owners do not move.
struct Cloud {
  std::vector<ParticleRow> rows;
  std::vector<std::int32_t> owner, rank, slotOfRank;
  std::int32_t dynamicCount = 0;
  MeetingRules rules;

  explicit Cloud(int count, std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      rows.push_back({random.uniform(), random.uniform(), random.uniform(), random.uniform(0.02, 0.04)});
      owner.push_back(i / 2);
    }
    dynamicCount = count * 3 / 4;
    slotOfRank.resize(count);
    std::iota(slotOfRank.begin(), slotOfRank.end(), 0);
    for (int i = dynamicCount - 1; i > 0; --i) {  // ranks in another order than slots
      std::swap(slotOfRank[i], slotOfRank[random.bits() % (i + 1)]);
    }
    rank.resize(count);
    for (int r = 0; r < count; ++r) rank[slotOfRank[r]] = r;
  }
  SearchInput input() const {
    return {.particles = rows,
            .surfaces = {},
            .owner = owner,
            .rank = rank,
            .slotOfRank = slotOfRank,
            .dynamicCount = dynamicCount,
            .rules = &rules};
  }
  bool isCandidate(int i, int j, double skin) const {
    const Vector3 d(rows[i].x - rows[j].x, rows[i].y - rows[j].y, rows[i].z - rows[j].z);
    return d.norm() < rows[i].radius + rows[j].radius + skin && owner[i] != owner[j] && rank[i] < rank[j] &&
           i < dynamicCount && rules.mayMeet(owner[i], owner[j]);
  }
};

using Pairs = std::set<std::pair<std::int32_t, std::int32_t>>;

Pairs bruteForce(const Cloud& cloud, double skin) {
  Pairs pairs;
  const int count = static_cast<int>(cloud.rows.size());
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      if (cloud.isCandidate(i, j, skin)) pairs.insert({i, j});
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

TEST(CandidateList, HoldsExactlyThePairsBruteForceFinds) {
  const Cloud cloud(1200, 11);
  CandidateList list;
  list.reset(1200, 0.04, 0.01);
  list.rebuild(cloud.input(), Executor(1));
  const Pairs expected = bruteForce(cloud, 0.01);
  EXPECT_GT(expected.size(), 500u);
  EXPECT_EQ(listed(list), expected);
}

TEST(CandidateList, IsRightAfterParticlesHaveMoved) {
  Cloud cloud(600, 12);
  CandidateList list;
  list.reset(600, 0.04, 0.01);
  Random random(1);
  for (int round = 0; round < 5; ++round) {
    for (ParticleRow& row : cloud.rows) row.x += random.uniform(-0.1, 0.1);
    list.rebuild(cloud.input(), Executor(2));
  }
  EXPECT_EQ(listed(list), bruteForce(cloud, 0.01));
}

TEST(CandidateList, ObeysMasksAndExcludedPairs) {
  Cloud cloud(600, 13);
  cloud.rules.group.resize(300);
  cloud.rules.mask.resize(300);
  for (int o = 0; o < 300; ++o) {
    cloud.rules.group[o] = o % 3 == 0 ? 2 : 1;
    cloud.rules.mask[o] = o % 5 == 0 ? 1 : 3;
  }
  CandidateList all;
  all.reset(600, 0.04, 0.01);
  all.rebuild(cloud.input(), Executor(1));
  const auto [i, j] = *listed(all).begin();
  cloud.rules.excludedPairs = {MeetingRules::pairKey(cloud.owner[i], cloud.owner[j])};
  CandidateList list;
  list.reset(600, 0.04, 0.01);
  list.rebuild(cloud.input(), Executor(1));
  EXPECT_EQ(listed(list), bruteForce(cloud, 0.01));
  EXPECT_FALSE(listed(list).contains({i, j}));
}

TEST(CandidateIncidence, NamesEveryCandidateOnceByThePatchOfItsSecondParticleInOrderOfRank) {
  const Cloud cloud(800, 14);
  CandidateList list;
  list.reset(800, 0.04, 0.02);
  list.rebuild(cloud.input(), Executor(1));
  std::vector<std::int32_t> patchOfSlot(800, -1);
  for (int i = 0; i < cloud.dynamicCount; ++i) patchOfSlot[i] = cloud.owner[i];
  CandidateIncidence incidence;
  incidence.rebuild(list, cloud.input(), patchOfSlot, 300);

  std::vector<std::int32_t> rowOf(list.size());
  for (std::int32_t i = 0; i < cloud.dynamicCount; ++i) {
    for (std::int32_t c = list.rowStart()[i]; c < list.rowStart()[i + 1]; ++c) rowOf[c] = i;
  }
  std::vector<int> seen(list.size(), 0);
  for (std::int32_t patch = 0; patch < 300; ++patch) {
    std::int32_t lastRank = -1;
    for (const std::int32_t c : incidence.of(patch)) {
      ++seen[c];
      EXPECT_EQ(patchOfSlot[list.partner()[c]], patch);
      EXPECT_GE(cloud.rank[rowOf[c]], lastRank);
      lastRank = cloud.rank[rowOf[c]];
    }
  }
  for (std::int32_t c = 0; c < list.size(); ++c) {
    EXPECT_EQ(seen[c], list.partner()[c] < cloud.dynamicCount ? 1 : 0);
  }
}

}  // namespace
}  // namespace granular
