// SPDX-License-Identifier: MIT
// What is kept of sleepers: who is where, frozen contacts by owner, sums from which terms are taken out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "granular/base/random.h"
#include "granular/system/detail/frozen_contacts.h"
#include "granular/system/detail/sleeper_grid.h"

namespace granular::detail {
namespace {

Vector3 pointIn(Random& random, double edge) {
  return {random.uniform(-edge, edge), random.uniform(-edge, edge), random.uniform(-edge, edge)};
}

/// Balls of many sizes in a cube, some of which are taken out again.
struct GridScene {
  explicit GridScene(std::int32_t count) {
    for (std::int32_t i = 0; i < count; ++i) {
      balls.push_back({i, pointIn(random, 1.0), random.uniform(0.005, 0.05)});
    }
    grid.insert(balls);
    for (std::int32_t i = 0; i < count; i += 3) grid.remove(i);
    std::erase_if(balls, [](const SleeperGrid::Grain& ball) { return ball.index % 3 == 0; });
  }
  std::vector<std::int32_t> found(const Vector3& at, double reach) {
    std::vector<std::int32_t> indices;
    grid.startSearch();
    grid.find(at, reach, indices);
    std::sort(indices.begin(), indices.end());
    return indices;
  }

  Random random{7};
  SleeperGrid grid;
  std::vector<SleeperGrid::Grain> balls;
};

TEST(SleeperGrid, FindsAllThatBruteForceFinds) {
  GridScene scene(600);
  for (int query = 0; query < 200; ++query) {
    const Vector3 at = pointIn(scene.random, 1.2);
    const double reach = scene.random.uniform(0.0, 0.4);
    const std::vector<std::int32_t> found = scene.found(at, reach);
    for (const SleeperGrid::Grain& ball : scene.balls) {
      if ((ball.center - at).norm() > reach + ball.reach) continue;
      EXPECT_TRUE(std::binary_search(found.begin(), found.end(), ball.index));
    }
  }
}

TEST(SleeperGrid, FindsNobodyTwice) {
  GridScene scene(600);
  std::vector<std::int32_t> found;
  scene.grid.startSearch();
  for (int query = 0; query < 50; ++query) scene.grid.find(pointIn(scene.random, 1.0), 0.3, found);
  std::sort(found.begin(), found.end());
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
}

TEST(SleeperGrid, LeavesOutWhatIsFar) {
  // Up to the reach of the query and of the largest, 0.05 m, and a cell, four times as wide as that.
  GridScene scene(600);
  const Vector3 at(0.1, 0.1, 0.1);
  const std::vector<std::int32_t> found = scene.found(at, 0.2);
  ASSERT_FALSE(found.empty());
  for (const SleeperGrid::Grain& ball : scene.balls) {
    if (!std::binary_search(found.begin(), found.end(), ball.index)) continue;
    EXPECT_LE((ball.center - at).cwiseAbs().maxCoeff(), 0.2 + 0.05 + 4 * 0.05);
  }
}

TEST(SleeperGrid, FindsAllWithinAnyReach) {
  GridScene scene(90);
  EXPECT_EQ(scene.found({1e9, 0, 0}, 1e30).size(), scene.balls.size());
}

FrozenContact between(std::int32_t a, std::int32_t b, double force) {
  FrozenContact contact;
  contact.memory.index[0] = a;
  contact.memory.index[1] = b;
  contact.memory.local[0] = contact.memory.local[1] = 0;
  contact.force = {force, 0, 0};
  contact.relativeOverlap = contact.normalEnergy = force;
  return contact;
}

Vector3 forceOn(const FrozenContacts& frozen, std::int32_t grain) {
  Vector3 sum = Vector3::Zero();
  for (const FrozenContacts::Side& at : frozen.of({OwnerKind::Grain, grain})) sum += at.force();
  return sum;
}

TEST(FrozenContacts, AreInTheListsOfBothOwners) {
  FrozenContacts frozen;
  frozen.add(between(0, 1, 2.0));
  frozen.add(between(1, 2, 3.0));
  EXPECT_EQ(forceOn(frozen, 0), Vector3(2, 0, 0));
  EXPECT_EQ(forceOn(frozen, 1), Vector3(1, 0, 0));
  EXPECT_EQ(forceOn(frozen, 2), Vector3(-3, 0, 0));
}

TEST(FrozenContacts, OfOneOwnerAreTakenOutOfAllLists) {
  FrozenContacts frozen;
  for (std::int32_t i = 1; i < 6; ++i) frozen.add(between(0, i, i));
  frozen.add(between(2, 3, 7.0));
  EXPECT_EQ(frozen.takeOut({OwnerKind::Grain, 2}).size(), 2u);
  EXPECT_EQ(frozen.size(), 4);
  EXPECT_EQ(frozen.of({OwnerKind::Grain, 0}).size(), 4u);
  EXPECT_EQ(forceOn(frozen, 3), Vector3(-3, 0, 0));
  EXPECT_TRUE(frozen.of({OwnerKind::Grain, 2}).empty());
}

TEST(FrozenContacts, SumToTheSameBitsWhateverCameAndWentBefore) {
  Random random(3);
  FrozenContacts frozen, again;
  for (std::int32_t i = 1; i < 40; ++i) frozen.add(between(0, i, random.uniform(-1.0, 1.0)));
  for (std::int32_t i = 2; i < 40; i += 2) {
    const FrozenContact taken = frozen.takeOut({OwnerKind::Grain, i}).front();
    if (i % 4 == 0) frozen.add(taken);
  }
  for (const FrozenContact& contact : frozen.all()) again.add(contact);
  EXPECT_EQ(forceOn(frozen, 0), forceOn(again, 0));
  EXPECT_EQ(frozen.elastic(), again.elastic());
  EXPECT_EQ(frozen.largestOverlap(), again.largestOverlap());
}

TEST(FrozenContacts, KnowTheLargestOverlapWhenItWasTakenOut) {
  FrozenContacts frozen;
  for (std::int32_t i = 1; i < 6; ++i) frozen.add(between(0, i, i));
  EXPECT_EQ(frozen.largestOverlap(), 5.0);
  frozen.takeOut({OwnerKind::Grain, 5});
  EXPECT_EQ(frozen.largestOverlap(), 4.0);
}

TEST(RunningSum, HasNothingLeftOfTermsTakenOut) {
  // A plain sum would have lost the small term to the large one: 1 + 2^60 = 2^60.
  RunningSum sum;
  sum.add(1.0);
  sum.add(0x1p60);
  sum.add(-0x1p60);
  EXPECT_EQ(sum.value(), 1.0);
}

}  // namespace
}  // namespace granular::detail
