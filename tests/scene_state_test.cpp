// SPDX-License-Identifier: MIT
// State files: what goes in comes out, what is damaged is refused, runs go on from them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "demos/runner/run_scene.h"
#include "demos/scene/json_object.h"
#include "demos/scene/scene_catalog.h"
#include "demos/world/saved_state.h"
#include "scene_fixture.h"

namespace granular_demo {
namespace {

using testing::read;
using testing::smallScene;

constexpr int kTicks = 20;  // half a second: the grains lie on the floor

/// Grains, a ball and a floor, with laws that remember.
Json memoryScene() {
  Json scene = smallScene();
  scene["pairs"] = Json::array();
  for (const char* other : {"sand", "steel"}) {
    scene["pairs"].push_back({{"between", {"sand", other}},
                              {"normal", {{"restitution", 0.1}}},
                              {"shear", {{"law", "static-friction"}}}});
  }
  scene["bodies"]["ball"]["position"] = {0, 0.4, 0};
  scene["bodies"]["plate"]["covering"] = {{"particleRadius", 0.02}};
  scene["bodies"]["plate"]["motion"] = "static";
  scene["bodies"]["plate"].erase("script");
  scene["container"]["closed"] = false;
  scene.erase("groundHeight");
  scene["outputs"]["pictures"] = false;
  return scene;
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(::testing::TempDir()) / ("granular_state_" + name);
}

/// The state of the scene after a few ticks, when grains touch.
SavedState stateLater() {
  BuiltScene scene(read(memoryScene()), 1);
  for (int i = 0; i < kTicks; ++i) scene.tick();
  return scene.savedState();
}

std::string complaintAboutFile(const std::filesystem::path& file) {
  try {
    readState(file);
    return "";
  } catch (const SceneError& error) {
    return error.what();
  }
}

TEST(SavedState, ComesBackFromItsFileBitForBit) {
  const SavedState state = stateLater();
  const auto file = scratch("whole");
  writeState(state, file);
  const SavedState again = readState(file);
  EXPECT_EQ(again.document, state.document);
  EXPECT_EQ(again.time, state.time);
  EXPECT_EQ(again.ticks, kTicks);
  ASSERT_EQ(again.grains.size(), state.grains.size());
  for (std::size_t i = 0; i < state.grains.size(); ++i) {
    EXPECT_EQ(again.grains[i].source, state.grains[i].source);
    EXPECT_EQ(again.grains[i].motion.pose.position, state.grains[i].motion.pose.position);
    EXPECT_EQ(again.grains[i].motion.pose.orientation.coeffs(),
              state.grains[i].motion.pose.orientation.coeffs());
    EXPECT_EQ(again.grains[i].motion.angularVelocity, state.grains[i].motion.angularVelocity);
  }
  ASSERT_EQ(again.bodies.size(), 1u);
  EXPECT_EQ(again.bodies[0].name, "ball");
  EXPECT_EQ(again.bodies[0].motion.velocity, state.bodies[0].motion.velocity);
  ASSERT_GT(state.memory.size(), 0u);
  ASSERT_EQ(again.memory.size(), state.memory.size());
  for (std::size_t i = 0; i < state.memory.size(); ++i)
    EXPECT_EQ(again.memory[i].displacement, state.memory[i].displacement);
}

TEST(SavedState, PutsGrainsBodiesAndMemoryBack) {
  const SavedState state = stateLater();
  BuiltScene scene(read(memoryScene()), 1, &state);
  EXPECT_EQ(scene.ticksDone(), kTicks);
  const SavedState again = scene.savedState();
  ASSERT_EQ(again.grains.size(), state.grains.size());
  for (std::size_t i = 0; i < state.grains.size(); ++i) {
    EXPECT_EQ(again.grains[i].motion.pose.position, state.grains[i].motion.pose.position);
    EXPECT_EQ(again.grains[i].motion.velocity, state.grains[i].motion.velocity);
  }
  EXPECT_LT((again.bodies[0].motion.pose.position - state.bodies[0].motion.pose.position).norm(), 1e-15);
  EXPECT_EQ(again.memory.size(), state.memory.size());
}

/// The scene of memories, in which things may fall asleep.
SceneDef sleepyScene() {
  Json scene = memoryScene();
  scene["sleep"] = Json::object();
  return read(scene);
}

std::int64_t sleepingGrains(const SavedState& state) {
  return std::count_if(state.sleep.sleepers.begin(), state.sleep.sleepers.end(),
                       [](const auto& sleeper) { return sleeper.kind == granular::OwnerKind::Grain; });
}

/// Until half of the grains sleep.
void fallAsleep(BuiltScene& built) {
  for (int i = 0; i < 400; ++i) {
    built.tick();
    const granular::StepReport report = built.grains().measure();
    if (report.frozenContacts > 0 && 2 * report.awakeGrains < built.grains().grainCount()) break;
  }
}

SavedState stateAsleep() {
  BuiltScene built(sleepyScene(), 1);
  fallAsleep(built);
  return built.savedState();
}

void expectSameSleep(const granular::SleepState& a, const granular::SleepState& b) {
  ASSERT_EQ(a.sleepers.size(), b.sleepers.size());
  for (std::size_t i = 0; i < a.sleepers.size(); ++i) {
    EXPECT_EQ(a.sleepers[i].kind, b.sleepers[i].kind);
    EXPECT_EQ(a.sleepers[i].index, b.sleepers[i].index);
    EXPECT_EQ(a.sleepers[i].held.force, b.sleepers[i].held.force);
    EXPECT_EQ(a.sleepers[i].held.torque, b.sleepers[i].held.torque);
    EXPECT_EQ(a.sleepers[i].carried, b.sleepers[i].carried);
  }
  ASSERT_EQ(a.resters.size(), b.resters.size());
  for (std::size_t i = 0; i < a.resters.size(); ++i) {
    EXPECT_EQ(a.resters[i].kind, b.resters[i].kind);
    EXPECT_EQ(a.resters[i].index, b.resters[i].index);
    EXPECT_EQ(a.resters[i].seconds, b.resters[i].seconds);
    EXPECT_EQ(a.resters[i].pose.position, b.resters[i].pose.position);
  }
  EXPECT_EQ(a.untilLook, b.untilLook);
  EXPECT_EQ(a.untilWaking, b.untilWaking);
  ASSERT_EQ(a.frozen.size(), b.frozen.size());
  for (std::size_t i = 0; i < a.frozen.size(); ++i) {
    EXPECT_EQ(a.frozen[i].force, b.frozen[i].force);
    EXPECT_EQ(a.frozen[i].point, b.frozen[i].point);
    EXPECT_EQ(a.frozen[i].overlap, b.frozen[i].overlap);
    EXPECT_EQ(a.frozen[i].memory.displacement, b.frozen[i].memory.displacement);
    EXPECT_EQ(a.frozen[i].memory.index[0], b.frozen[i].memory.index[0]);
    EXPECT_EQ(a.frozen[i].memory.index[1], b.frozen[i].memory.index[1]);
  }
}

TEST(SavedState, KeepsWhoSleepsBitForBit) {
  const SavedState state = stateAsleep();
  ASSERT_GT(state.sleep.frozen.size(), 0u);
  ASSERT_GT(state.sleep.resters.size(), 0u);
  const auto file = scratch("asleep");
  writeState(state, file);
  const SavedState read = readState(file);
  expectSameSleep(read.sleep, state.sleep);
  const BuiltScene resumed(sleepyScene(), 1, &read);
  expectSameSleep(resumed.savedState().sleep, state.sleep);
}

TEST(SavedState, GrainsSleepOnWhenTheSceneGoesOn) {
  BuiltScene whole(sleepyScene(), 1);
  fallAsleep(whole);
  const SavedState state = whole.savedState();
  ASSERT_GT(sleepingGrains(state), 0);
  BuiltScene resumed(sleepyScene(), 1, &state);
  whole.tick();  // in which one or another may wake by itself
  resumed.tick();
  EXPECT_GT(sleepingGrains(whole.savedState()), 0);
  EXPECT_EQ(sleepingGrains(resumed.savedState()), sleepingGrains(whole.savedState()));
}

TEST(SavedState, NothingSleepsInASceneThatKnowsNoSleep) {
  const SavedState state = stateAsleep();
  BuiltScene resumed(read(memoryScene()), 1, &state);
  EXPECT_TRUE(resumed.savedState().sleep.sleepers.empty());
  EXPECT_EQ(resumed.savedState().memory.size(), state.memory.size());
}

TEST(SavedState, GoesOnAsTheRunThatNeverStopped) {
  const SceneDef def = read(memoryScene());
  BuiltScene whole(def, 1);
  for (int i = 0; i < kTicks; ++i) whole.tick();
  const SavedState state = whole.savedState();
  BuiltScene resumed(def, 1, &state);
  for (int i = 0; i < 4; ++i) {
    whole.tick();
    resumed.tick();
  }
  EXPECT_EQ(resumed.time(), whole.time());
  // The step control begins anew, so the two differ by its tolerance, 1e-3 of a radius of 1 cm a sub-step.
  const auto a = whole.grains().grainMotions(), b = resumed.grains().grainMotions();
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_LT((a[i].pose.position - b[i].pose.position).norm(), 1e-3) << i;
}

TEST(SavedState, FindsScriptedBodiesWhereTheirScriptsHaveThem) {
  const SceneDef def = read(smallScene());
  BuiltScene whole(def, 1);
  for (int i = 0; i < kTicks; ++i) whole.tick();
  const SavedState state = whole.savedState();
  BuiltScene resumed(def, 1, &state);
  const auto a = whole.cloudBodies(), b = resumed.cloudBodies();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Pose there = whole.grains().bodyMotion(a[i].id).pose,
               here = resumed.grains().bodyMotion(b[i].id).pose;
    EXPECT_LT((there.position - here.position).norm(), 1e-12) << i;
    EXPECT_LT(there.orientation.angularDistance(here.orientation), 1e-7) << i;
  }
}

TEST(StateFile, IsRefusedWhenCutOff) {
  const auto file = scratch("cut");
  writeState(stateLater(), file);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  EXPECT_EQ(complaintAboutFile(file), file.string() + ": not a state file, or cut off: it is not whole CBOR");
}

TEST(StateFile, IsRefusedWhenANumberWasChanged) {
  const auto file = scratch("damaged");
  SavedState state = stateLater();
  writeState(state, file);
  std::string bytes;
  {
    std::ifstream in(file, std::ios::binary);
    bytes.assign(std::istreambuf_iterator<char>(in), {});
  }
  const std::size_t at = bytes.find("\"density\"");  // in the scene's text
  ASSERT_NE(at, std::string::npos);
  bytes[at + 1] = 'D';
  std::ofstream(file, std::ios::binary) << bytes;
  EXPECT_EQ(complaintAboutFile(file),
            file.string() + ": checksum: differs from the content: the file is damaged");
}

TEST(StateFile, IsRefusedWhenItIsAnotherFile) {
  const auto file = scratch("other");
  const auto bytes = Json::to_cbor(Json{{"format", "something"}});
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  EXPECT_EQ(complaintAboutFile(file),
            file.string() + ": not a state file: \"format\" is not \"granular-state\"");
  EXPECT_EQ(complaintAboutFile("no/such/file"), "no/such/file: cannot be opened");
}

TEST(SceneThatContinues, SaysThatItNeedsAState) {
  try {
    readSceneFile(findScene("bulldozer"), "small");
    FAIL() << "nothing thrown";
  } catch (const SceneError& error) {
    EXPECT_EQ(error.path, "continues");
    EXPECT_NE(std::string(error.what()).find("needs its state file"), std::string::npos);
  }
}

TEST(SceneThatContinues, BeginsWithTheGrainsAndBodiesOfTheOther) {
  const SavedState state = stateLater();
  const std::string later = R"({"name": "later", "continues": "test", "duration": 1,
    "grains": {"second": {"shape": "pair", "material": "sand", "position": [0, 5, 0]}},
    "bodies": {"ball": {"material": "sand"}}})";
  const SceneDef def = readScene(later, "folder/later.json", "default", state.document);
  const BuiltScene scene(def, 1, &state);
  EXPECT_EQ(scene.ticksDone(), 0);  // another scene: its time begins
  EXPECT_EQ(scene.grains().grainCount(), static_cast<std::int32_t>(state.grains.size()));
  EXPECT_LT((scene.body("ball").pose().position - state.bodies[0].motion.pose.position).norm(), 1e-12);
}

TEST(SceneThatContinues, RefusesGrainsThatItNoLongerKnows) {
  const SavedState state = stateLater();
  const std::string later =
      R"({"name": "later", "continues": "test", "duration": 1, "fills": {"heap": null}})";
  const SceneDef def = readScene(later, "folder/later.json", "default", state.document);
  try {
    const BuiltScene scene(def, 1, &state);
    FAIL() << "nothing thrown";
  } catch (const SceneError& error) {
    EXPECT_EQ(error.path, "fills.heap");
  }
}

}  // namespace
}  // namespace granular_demo
