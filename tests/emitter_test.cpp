// SPDX-License-Identifier: MIT
// Emitters: what they pour and when, and that the system takes grains between steps.
#include "granular/system/emitter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace granular {
namespace {

const Box kSpout = {{-0.1, 0.5, -0.1}, {0.1, 0.6, 0.1}};
const GrainShapeDef kShape = tetrahedronShape(0.005);

void addParticles(const std::vector<PlacedGrain>& grains, std::int32_t firstOwner,
                  std::vector<ParticleView>& all) {
  for (const PlacedGrain& grain : grains) {
    for (const ShapeParticle& p : kShape.particles)
      all.push_back({grain.pose.toWorld(grain.scale * p.position), grain.scale * p.radius, OwnerKind::Grain,
                     firstOwner});
    ++firstOwner;
  }
}

double leastGap(const std::vector<ParticleView>& all) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      if (all[i].ownerIndex == all[j].ownerIndex) continue;
      least = std::min(least, (all[i].position - all[j].position).norm() - all[i].radius - all[j].radius);
    }
  }
  return least;
}

TEST(Emitter, PoursItsRateTimesTheTime) {
  Emitter emitter(boxRegion(kSpout), kShape, {.rate = 130.0});
  std::size_t poured = 0;
  for (int tick = 0; tick < 240; ++tick) poured += emitter.pour(1.0 / 240.0, {}).size();
  EXPECT_EQ(poured, 130u);
  EXPECT_EQ(emitter.waiting(), 0);
}

TEST(Emitter, StopsAtItsCount) {
  Emitter emitter(boxRegion(kSpout), kShape, {.rate = 100.0, .count = 7});
  std::size_t poured = 0;
  for (int tick = 0; tick < 60; ++tick) poured += emitter.pour(1.0 / 60.0, {}).size();
  EXPECT_EQ(poured, 7u);
  EXPECT_TRUE(emitter.isDone());
}

TEST(Emitter, KeepsTheGapToEverythingThere) {
  Emitter emitter(boxRegion(kSpout), kShape, {.rate = 40.0, .gap = 0.1, .minScale = 0.8, .maxScale = 1.1});
  std::vector<ParticleView> all = {{{0, 0.55, 0}, 0.04, OwnerKind::Body, 1000}};
  std::int32_t owner = 0;
  for (int i = 0; i < 2; ++i) {
    const auto grains = emitter.pour(1.0, all);
    EXPECT_EQ(grains.size(), 40u);
    addParticles(grains, owner, all);
    owner += 40;
  }
  EXPECT_GE(leastGap(all), 0.1 * 0.8 * 0.005 - 1e-12);
}

TEST(Emitter, LeavesGrainsWaitingWhereThereIsNoRoom) {
  // A region that one grain fills: its reach is 11.1 mm.
  Emitter emitter(ballRegion({0, 0, 0}, 0.014), kShape, {.rate = 10.0});
  std::vector<ParticleView> all;
  const auto first = emitter.pour(0.3, all);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_EQ(emitter.waiting(), 2);
  addParticles(first, 0, all);
  EXPECT_TRUE(emitter.pour(0.1, all).empty());
  EXPECT_EQ(emitter.waiting(), 3);
  EXPECT_EQ(emitter.pour(0.0, {}).size(), 1u);  // the room is free again: those that wait come first
}

TEST(Emitter, GoesOnWhereAnotherStopped) {
  const EmitterDef def = {.rate = 50.0, .seed = 9};
  Emitter whole(boxRegion(kSpout), kShape, def), first(boxRegion(kSpout), kShape, def);
  whole.pour(0.5, {});
  first.pour(0.5, {});
  Emitter second(boxRegion(kSpout), kShape, def);
  second.resume(first.secondsPoured(), first.poured());
  const auto expected = whole.pour(0.5, {}), got = second.pour(0.5, {});
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_EQ(got[i].pose.position, expected[i].pose.position);
}

TEST(Emitter, NamesTheSettingThatIsWrong) {
  try {
    Emitter(boxRegion(kSpout), kShape, {.rate = 0.0});
    FAIL() << "nothing thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "EmitterDef.rate is 0 grains/s; it must be finite and > 0");
  }
}

/// Grains dropped one by one between steps onto a half-space.
std::vector<RigidMotion> pouredOnto(int threads) {
  GranularSystem sand(SystemDef{.threads = threads});
  const MaterialId stone = sand.addMaterial({.name = "stone"});
  const GrainShapeId shape = sand.addGrainShape(kShape);
  sand.addBody({.exact = HalfSpace{}, .material = stone});
  Emitter emitter(boxRegion({{-0.03, 0.05, -0.03}, {0.03, 0.1, 0.03}}), kShape, {.rate = 60.0, .count = 12});
  std::vector<ParticleView> present;
  for (int tick = 0; tick < 30; ++tick) {
    sand.readParticles(present);
    for (const PlacedGrain& grain : emitter.pour(1.0 / 60.0, present))
      sand.addGrain({.shape = shape, .material = stone, .pose = grain.pose, .velocity = {0, -1, 0}});
    sand.step(1.0 / 60.0);
  }
  return {sand.grainMotions().begin(), sand.grainMotions().end()};
}

TEST(GrainsAddedBetweenSteps, AreTheSameBitsForOneThreadAndThree) {
  const auto one = pouredOnto(1), three = pouredOnto(3);
  ASSERT_EQ(one.size(), 12u);
  ASSERT_EQ(three.size(), 12u);
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].pose.position, three[i].pose.position);
    EXPECT_EQ(one[i].velocity, three[i].velocity);
  }
}

TEST(GrainsAddedBetweenSteps, FallOnTheParabolaBesideThoseThatWereThere) {
  GranularSystem sand;
  const MaterialId stone = sand.addMaterial({.name = "stone"});
  const GrainShapeId shape = sand.addGrainShape(kShape);
  const GrainId first = sand.addGrain({.shape = shape, .material = stone, .pose = {.position = {0, 1, 0}}});
  sand.step(0.1);
  const GrainId second = sand.addGrain({.shape = shape, .material = stone, .pose = {.position = {1, 1, 0}}});
  sand.step(0.1);
  const auto motions = sand.grainMotions();
  EXPECT_NEAR(motions[first.index].pose.position.y(), 1.0 - 0.5 * 9.81 * 0.04, 1e-9);
  EXPECT_NEAR(motions[second.index].pose.position.y(), 1.0 - 0.5 * 9.81 * 0.01, 1e-9);
}

}  // namespace
}  // namespace granular
