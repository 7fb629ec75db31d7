// SPDX-License-Identifier: MIT
// Copies, joints, emitters, meters and bounds of scene files; and scenes that cannot be built.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "demos/runner/energy_balance.h"
#include "demos/runner/meter.h"
#include "demos/runner/run_scene.h"
#include "scene_fixture.h"

namespace granular_demo {
namespace {

using testing::read;
using testing::smallScene;

/// Weightless space with one kind of block; nothing in it.
Json emptyScene() {
  return Json::parse(R"({
    "name": "test", "duration": 0.5, "frameRate": 20, "ticksPerFrame": 2, "gravity": [0, 0, 0],
    "materials": {"stone": {"density": 2000, "youngsModulus": 1e7}},
    "shapes": {"ball": {"type": "sphere", "particleRadius": 0.01}},
    "outputs": {"pictures": false}
  })");
}

Json block(const Vector3& position) {
  return {{"shape", {{"type", "box"}, {"size", {0.1, 0.1, 0.1}}}},
          {"motion", "dynamic"},
          {"density", 2000},
          {"material", "stone"},
          {"covering", {{"particleRadius", 0.02}}},
          {"position", {position.x(), position.y(), position.z()}}};
}

std::string complaintWhenBuilt(const Json& json) {
  try {
    runScene(read(json), {.frames = 1});
    return "";
  } catch (const SceneError& error) {
    return error.what();
  }
}

TEST(Copies, StandInTheirGridAndInBond) {
  Json json = emptyScene();
  json["gravity"] = {0, -1, 0};
  json["bodies"]["brick"] = block({1, 2, 3});
  json["bodies"]["brick"]["copies"] = {
      {"counts", {3, 2, 1}}, {"step", {0.2, 0.1, 0}}, {"stagger", {0.1, 0, 0}}};
  const BuiltScene scene(read(json), 1);
  ASSERT_EQ(scene.bodies().size(), 6u);
  EXPECT_LT((scene.body("brick[2]").pose().position - Vector3(1.4, 2, 3)).norm(), 1e-12);
  EXPECT_LT((scene.body("brick[4]").pose().position - Vector3(1.3, 2.1, 3)).norm(), 1e-12);
}

TEST(Copies, ShareOneCovering) {
  Json json = emptyScene();
  json["bodies"]["brick"] = block({0, 0, 0});
  json["bodies"]["brick"]["copies"] = {{"counts", {2, 1, 1}}, {"step", {0.2, 0, 0}}};
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(scene.body("brick[0]").covering, scene.body("brick[1]").covering);
  EXPECT_EQ(scene.body("brick[0]").solid, scene.body("brick[1]").solid);
}

TEST(Copies, TurnAtRandomByTheSeedOfTheScene) {
  Json json = emptyScene();
  json["bodies"]["brick"] = block({0, 0, 0});
  json["bodies"]["brick"]["copies"] = {
      {"counts", {2, 1, 1}}, {"step", {0.3, 0, 0}}, {"orientations", "random"}};
  const auto turnOf = [&](int seed) {
    json["seed"] = seed;
    return BuiltScene(read(json), 1).body("brick[1]").pose().orientation;
  };
  EXPECT_LT(turnOf(1).angularDistance(turnOf(1)), 1e-12);
  EXPECT_GT(turnOf(1).angularDistance(turnOf(2)), 1e-3);
}

/// Two blocks in space, a little apart, pulled apart by their velocities.
Json jointedPair(double breakingForce) {
  Json json = emptyScene();
  json["bodies"]["a"] = block({0, 0, 0});
  json["bodies"]["b"] = block({0.11, 0, 0});
  json["bodies"]["a"]["velocity"] = {-0.5, 0, 0};
  json["bodies"]["b"]["velocity"] = {0.5, 0, 0};
  json["joints"]["weld"] = {{"type", "fixed"}, {"between", {"a", "b"}}, {"breakingForce", breakingForce}};
  return json;
}

// Each block weighs 2 kg, so stopping them takes 1 N s, in one tick of 1/40 s 40 N.
TEST(Joint, HoldsBelowItsBreakingForce) {
  BuiltScene scene(read(jointedPair(80.0)), 1);
  for (int i = 0; i < 20; ++i) scene.tick();
  EXPECT_EQ(scene.joints().broken(), 0u);
  EXPECT_NEAR((scene.body("b").pose().position - scene.body("a").pose().position).x(), 0.11, 0.02);
}

TEST(Joint, BreaksAboveIt) {
  BuiltScene scene(read(jointedPair(20.0)), 1);
  for (int i = 0; i < 20; ++i) scene.tick();
  EXPECT_EQ(scene.joints().broken(), 1u);
  EXPECT_EQ(scene.joints().brokenNames(), std::vector<std::string>{"weld"});
}

/// Velocity of the second of two blocks that reach 5 mm into one another, after ten ticks.
double speedApart(double breakingForce, double approach) {
  Json json = jointedPair(breakingForce);
  json["largestStartOverlap"] = 10;
  json["bodies"]["b"]["position"] = {0.095, 0, 0};
  json["bodies"]["a"]["velocity"] = {approach, 0, 0};
  json["bodies"]["b"]["velocity"] = {-approach, 0, 0};
  json["joints"]["weld"]["touching"] = false;
  BuiltScene scene(read(json), 1);
  for (int i = 0; i < 10; ++i) scene.tick();
  return static_cast<double>(scene.body("b").body->getLinearVelocity().x());
}

TEST(Joint, HoldsBodiesThatDoNotTouchOneAnotherUntilItBreaks) {
  EXPECT_EQ(speedApart(1e9, 0.0), 0.0);
  EXPECT_GT(speedApart(20.0, 0.5), 0.01);  // broken, then sprung apart
}

TEST(Joint, KeepsTheMomentumOfThePair) {
  Json json = jointedPair(1e9);
  json["bodies"]["b"]["velocity"] = {0.9, 0.4, 0};
  BuiltScene scene(read(json), 1);
  const granular::StepReport start = scene.grains().measure();
  granular::StepReport end;
  for (int i = 0; i < 20; ++i) end = scene.tick();
  EXPECT_LT((end.momentum - start.momentum).norm(), 1e-12 * start.momentum.norm() * 100);
}

TEST(Joint, EnergyItTakesIsAccountedFor) {
  BuiltScene scene(read(jointedPair(1e9)), 1);
  EnergyBalance balance;
  balance.add(scene.grains().measure(), scene);
  for (int i = 0; i < 20; ++i) balance.add(scene.tick(), scene);
  EXPECT_LT(scene.outsideEnergy().byConstraints, -0.4);  // both blocks' 0.25 J, nearly all
  EXPECT_LT(scene.grains().measure().energy.total(), 0.01);
  EXPECT_LT(balance.worstFraction(), 1e-3);
}

TEST(SceneEmitter, PoursGrainsWhoseEnergyIsCounted) {
  Json json = emptyScene();
  json["gravity"] = {0, -10, 0};
  json["emitters"]["spout"] = {{"region", {{"type", "ball"}, {"center", {0, 2, 0}}, {"radius", 0.2}}},
                               {"shape", "ball"},
                               {"material", "stone"},
                               {"rate", 40},
                               {"to", 0.25},
                               {"velocity", {0, -3, 0}}};
  BuiltScene scene(read(json), 1);
  EnergyBalance balance;
  balance.add(scene.grains().measure(), scene);
  for (int i = 0; i < 20; ++i) balance.add(scene.tick(), scene);
  EXPECT_EQ(scene.grains().grainCount(), 10);
  const double mass = 10 * 2000 * 4.0 / 3.0 * 3.14159265358979 * 1e-6;
  EXPECT_NEAR(scene.outsideEnergy().emittedMass, mass, 1e-9);
  EXPECT_LT(balance.worstFraction(), 1e-9);
}

TEST(SceneEmitter, IntoAFullRegionIsRefusedBeforeTheFirstStep) {
  Json json = emptyScene();
  json["emitters"]["spout"] = {{"region", {{"type", "ball"}, {"center", {0, 0, 0}}, {"radius", 0.012}}},
                               {"shape", "ball"},
                               {"material", "stone"},
                               {"rate", 40}};
  json["fills"]["plug"] = {{"region", {{"type", "ball"}, {"center", {0, 0, 0}}, {"radius", 0.0115}}},
                           {"shape", "ball"},
                           {"material", "stone"},
                           {"count", 1}};
  EXPECT_EQ(complaintWhenBuilt(json),
            "folder/test.json: emitters.spout: its region is full: no room for one grain (of 40.000000 a "
            "second)");
}

TEST(SceneThatCannotBeBuilt, NamesTheFillThatIsLargerThanItsRegion) {
  Json json = emptyScene();
  json["fills"]["heap"] = {{"region", {{"type", "ball"}, {"center", {0, 0, 0}}, {"radius", 0.03}}},
                           {"shape", "ball"},
                           {"material", "stone"},
                           {"count", 500}};
  const std::string complaint = complaintWhenBuilt(json);
  EXPECT_NE(complaint.find("folder/test.json: fills.heap: FillDef.count is 500; only"), std::string::npos)
      << complaint;
}

TEST(SceneThatCannotBeBuilt, NamesTheMeshThatIsMissing) {
  Json json = emptyScene();
  json["fills"]["heap"] = {
      {"region", {{"type", "mesh"}, {"file", "none.obj"}}}, {"shape", "ball"}, {"material", "stone"}};
  EXPECT_EQ(testing::complaintAbout(json),
            "folder/test.json: fills.heap.region.file: value \"none.obj\"; allowed: a mesh file, relative to "
            "the scene file");
}

TEST(SceneThatCannotBeBuilt, NamesBodiesThatReachIntoOneAnother) {
  Json json = emptyScene();
  json["bodies"]["a"] = block({0, 0, 0});
  json["bodies"]["b"] = block({0.085, 0, 0});  // 15 mm deep, three quarters of a particle radius
  const std::string complaint = complaintWhenBuilt(json);
  EXPECT_NE(complaint.find("folder/test.json: bodies.a: reaches into \"b\" by 0.01"), std::string::npos)
      << complaint;
}

TEST(SceneThatCannotBeBuilt, NamesABodyInsideAnother) {
  Json json = emptyScene();
  json["bodies"]["a"] = block({0, 0, 0});
  json["bodies"]["a"]["shape"]["size"] = {0.5, 0.5, 0.5};
  json["bodies"]["b"] = block({0, 0, 0});
  EXPECT_NE(complaintWhenBuilt(json).find("bodies.a: "), std::string::npos);
}

TEST(SceneText, RefusesPartsThatNameNothing) {
  const auto complaint = [](const std::function<void(Json&)>& change) {
    Json json = emptyScene();
    json["bodies"]["a"] = block({0, 0, 0});
    json["bodies"]["b"] = block({0.2, 0, 0});
    json["bodies"]["b"]["copies"] = {{"counts", {2, 1, 1}}, {"step", {0.2, 0, 0}}};
    change(json);
    return testing::complaintAbout(json);
  };
  EXPECT_EQ(complaint([](Json& j) {
              j["joints"]["w"] = {{"type", "fixed"}, {"between", {"a", "c"}}};
            }),
            "folder/test.json: joints.w.between[1]: value \"c\"; allowed: one of a, b, of copies with "
            "[number]");
  EXPECT_EQ(complaint([](Json& j) {
              j["joints"]["w"] = {{"type", "fixed"}, {"between", {"a", "b[2]"}}};
            }),
            "folder/test.json: joints.w.between[1]: value \"b[2]\"; allowed: \"b[0]\" to \"b[1]\"");
  EXPECT_EQ(complaint([](Json& j) {
              j["bodies"]["b"]["copies"]["counts"] = {2, 0, 1};
            }),
            "folder/test.json: bodies.b.copies.counts[1]: value 0; allowed: a number in [1, 100000]");
  EXPECT_EQ(complaint([](Json& j) {
              j["expect"] = Json::array({{{"meter", "m"}, {"value", "x"}, {"atLeast", 1}}});
            }),
            "folder/test.json: expect[0].meter: value \"m\"; allowed: none, since the scene has no meters");
}

TEST(FlowMeter, MeasuresASteadyStream) {
  // Thirty grains in a row fly through a plane at 2 m/s, 0.05 m apart: 40 of them a second.
  Json json = emptyScene();
  for (int i = 0; i < 30; ++i) {
    json["grains"][std::string("g").append(std::to_string(i))] = {{"shape", "ball"},
                                               {"material", "stone"},
                                               {"position", {-0.025 - 0.05 * i, 0, 0}},
                                               {"velocity", {2, 0, 0}}};
  }
  json["meters"]["plane"] = {{"type", "flow"}, {"point", {0, 0, 0}}, {"direction", {1, 0, 0}}};
  json["ticksPerFrame"] = 10;
  json["duration"] = 1.0;
  json["expect"] = Json::array({{{"meter", "plane"}, {"value", "passedFraction"}, {"atLeast", 1}},
                                {{"meter", "plane"}, {"value", "rate"}, {"atMost", 1e-9}}});
  const FinishedRun run = runScene(read(json), {});
  std::map<std::string, double> values;
  for (const auto& [name, value] : run.result.meters.at(0).values) values[name] = value;
  const double grain = 2000 * 4.0 / 3.0 * 3.14159265358979 * 1e-6;
  EXPECT_NEAR(values.at("passedMass"), 30 * grain, 1e-9);
  // 18 grains pass between the two fractions; the window's ends are known to one grain and one tick.
  EXPECT_NEAR(values.at("rate"), 40 * grain, 0.06 * 40 * grain);
  EXPECT_LT(values.at("rateDeviation"), 0.3);  // a stretch holds three or four grains
  ASSERT_EQ(run.result.expected.size(), 2u);
  EXPECT_TRUE(run.result.expected[0].holds());
  EXPECT_FALSE(run.result.expected[1].holds());
  EXPECT_FALSE(run.result.passed(false));
}

TEST(RingMeter, CountsRingsThreadedOnPoles) {
  Json json = emptyScene();
  const auto ring = [](const Vector3& p, double degrees) -> Json {
    return {{"shape", {{"type", "mesh"}, {"file", "../meshes/ring.obj"}, {"scale", 0.04}}},
            {"motion", "dynamic"},
            {"density", 1000},
            {"material", "stone"},
            {"position", {p.x(), p.y(), p.z()}},
            {"orientation", {{"axis", {1, 0, 0}}, {"degrees", degrees}}}};
  };
  // Drawn round z: lying flat round the pole, tilted round it, upright beside it, flat above its top.
  const Vector3 places[] = {{0, 0.05, 0}, {0, 0.1, 0}, {0.2, 0.05, 0}, {0, 0.3, 0}};
  const double turns[] = {90, 60, 0, 90};
  double onPoles[4];
  for (int i = 0; i < 4; ++i) {
    json["bodies"] = {{"pole",
                       {{"shape", {{"type", "cylinder"}, {"radius", 0.01}, {"height", 0.2}}},
                        {"material", "stone"},
                        {"position", {0, 0.1, 0}}}},
                      {"ring", ring(places[i], turns[i])}};
    json["meters"]["m"] = {{"type", "rings"},  {"rings", "ring"},
                           {"poles", "pole"},  {"holeRadius", 0.03},
                           {"nearPole", 0.06}, {"walls", {{"lower", {-1, 0, -1}}, {"upper", {1, 1, 1}}}},
                           {"nearWall", 0.1}};
    const std::filesystem::path file = std::filesystem::path(GRANULAR_TEST_FOLDER) / "test.json";
    const BuiltScene scene(readScene(json.dump(), file), 1);
    onPoles[i] = makeMeter(scene.def().meters[0], scene)->frame().at(0);
  }
  EXPECT_EQ(onPoles[0], 1);
  EXPECT_EQ(onPoles[1], 1);
  EXPECT_EQ(onPoles[2], 0);
  EXPECT_EQ(onPoles[3], 0);
}

TEST(PushMeter, FindsTheForceThatHoldsAWeight) {
  // A plate that does not move under a block of 2 kg: after the impact has died down, 2 kg times gravity.
  Json json = emptyScene();
  json["gravity"] = {0, -10, 0};
  json["duration"] = 1.0;
  json["materials"]["stone"]["restitution"] = 0.2;
  json["bodies"]["plate"] = block({0, 0, 0});
  json["bodies"]["plate"].erase("density");
  json["bodies"]["plate"]["motion"] = "kinematic";
  json["bodies"]["block"] = block({0, 0.101, 0});
  json["meters"]["plate"] = {
      {"type", "push"}, {"body", "plate"}, {"direction", {0, 1, 0}}, {"distance", 0.1}};
  BuiltScene scene(read(json), 1);
  const auto meter = makeMeter(scene.def().meters[0], scene);
  for (int i = 0; i < 40; ++i) {
    scene.tick();
    meter->tick();
    if (i == 29) meter->frame();
  }
  EXPECT_NEAR(meter->frame().at(0), 20.0, 0.5);
}

}  // namespace
}  // namespace granular_demo
