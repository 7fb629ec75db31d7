// SPDX-License-Identifier: MIT
// Scenes come alive as their files say: masses, places, scripts, checks of places.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "demos/built_scene.h"
#include "demos/motion_script.h"
#include "demos/place_checks.h"
#include "demos/scene_catalog.h"
#include "scene_fixture.h"

namespace granular_demo {
namespace {

using testing::read;
using testing::smallScene;
using testing::withValue;

/// The small scene without its fill: a ball, a plate and one grain.
Json sparseScene() {
  Json scene = smallScene();
  scene.erase("fills");
  scene["scales"] = Json::object();
  return scene;
}

TEST(BuiltScene, WeighsASphereByItsDensity) {
  const BuiltScene scene(read(sparseScene()), 1);
  const double expected = 7800.0 * 4.0 / 3.0 * std::numbers::pi * std::pow(0.05, 3);
  EXPECT_NEAR(1.0 / scene.body("ball").body->getInvMass(), expected, 1e-12 * expected);
}

TEST(BuiltScene, PlacesAConesCentreOfMassAQuarterUp) {
  Json json = sparseScene();
  json["bodies"]["ball"]["shape"] = {{"type", "cone"}, {"radius", 0.1}, {"height", 0.4}};
  const BuiltScene scene(read(json), 1);
  // The file places the middle of the height at y = 1; a quarter up the height is 0.1 below it.
  EXPECT_NEAR(scene.body("ball").pose().position.y(), 0.9, 1e-4);
}

TEST(BuiltScene, AddsUpTheMassesOfACompound) {
  Json json = sparseScene();
  const Json box = {{"type", "box"}, {"size", {0.1, 0.2, 0.1}}};
  json["bodies"]["ball"]["shape"] = {
      {"type", "compound"},
      {"children",
       {{{"shape", box}, {"position", {-0.2, 0, 0}}}, {{"shape", box}, {"position", {0.2, 0, 0}}}}}};
  const BuiltScene scene(read(json), 1);
  EXPECT_NEAR(1.0 / scene.body("ball").body->getInvMass(), 7800.0 * 2 * 0.002, 1e-9);
  EXPECT_LT((scene.body("ball").pose().position - Vector3(0, 1, 0)).norm(), 1e-12);
}

TEST(BuiltScene, CoversTheBodiesThatAskForItAlone) {
  const BuiltScene scene(read(sparseScene()), 1);
  EXPECT_GT(scene.body("ball").covering.covering.positions.size(), 10u);
  EXPECT_TRUE(scene.body("plate").covering.covering.positions.empty());
}

TEST(BuiltScene, GivesGrainsTheirVelocity) {
  BuiltScene scene(read(sparseScene()), 1);
  const granular::RigidMotion motion = scene.grains().grainMotions()[scene.grain("first").index];
  EXPECT_EQ(motion.velocity, Vector3(1, 2, 3));
  EXPECT_EQ(motion.angularVelocity, Vector3(0, 5, 0));
}

TEST(BuiltScene, FillsKeepClearOfCoveredBodies) {
  Json json = smallScene();
  json["bodies"]["ball"]["position"] = {0, 0.06, 0};
  json["fills"]["heap"]["scale"] = {1, 1};
  BuiltScene scene(read(json), 1);
  std::vector<granular::ParticleView> particles;
  scene.grains().readParticles(particles);
  for (const auto& a : particles) {
    if (a.ownerKind != granular::OwnerKind::Grain) continue;
    for (const auto& b : particles) {
      if (b.ownerKind == granular::OwnerKind::Grain && b.ownerIndex == a.ownerIndex) continue;
      EXPECT_GT((a.position - b.position).norm(), a.radius + b.radius);
    }
  }
}

TEST(BuiltScene, ScriptedBodiesAreWhereTheScriptSaysAfterEveryTick) {
  BuiltScene scene(read(sparseScene()), 1);
  for (int i = 0; i < 8; ++i) {
    scene.tick();
    const Pose expected =
        poseAt(scene.def().scripts.at("wobble"), {{0, -0.05, 0}, Quaternion::Identity()}, scene.time());
    EXPECT_LT((scene.body("plate").pose().position - expected.position).norm(), 1e-12);
  }
}

TEST(BuiltScene, SaysWhichFillHasNoRoom) {
  try {
    BuiltScene scene(read(withValue("/fills/heap/count", 100000)), 1);
    FAIL() << "100,000 grains do not fit";
  } catch (const SceneError& error) {
    EXPECT_TRUE(
        std::string(error.what()).starts_with("folder/test.json: fills.heap: FillDef.count is 100000; only "))
        << error.what();
  }
}

TEST(BuiltScene, OfAnotherSeedHasOtherGrains) {
  const BuiltScene a(read(withValue("/seed", 1)), 1);
  const BuiltScene b(read(withValue("/seed", 2)), 1);
  EXPECT_NE(a.stateHash(), b.stateHash());
}

TEST(MotionScript, GoesStraightBetweenThePointsOfItsPath) {
  const ScriptDef script = {.path = {{1.0, {0, 0, 0}}, {3.0, {4, 0, 0}}}, .shake = {}, .turn = {}};
  const Pose start = {{1, 1, 1}, Quaternion::Identity()};
  EXPECT_EQ(poseAt(script, start, 0.5).position, Vector3(1, 1, 1));
  EXPECT_EQ(poseAt(script, start, 1.5).position, Vector3(2, 1, 1));
  EXPECT_EQ(poseAt(script, start, 9.0).position, Vector3(5, 1, 1));
}

TEST(MotionScript, ShakesAsASine) {
  const ScriptDef script = {.path = {}, .shake = ScriptShake{{0, 2, 0}, 0.5, 0, 1, 10}, .turn = {}};
  EXPECT_EQ(poseAt(script, {}, 0.9).position.y(), 0.0);
  // Half a second after the start at 0.5 Hz is a quarter period: the crest.
  EXPECT_NEAR(poseAt(script, {}, 1.5).position.y(), 2.0, 1e-12);
}

TEST(MotionScript, TurnsAtItsRateBetweenItsTimes) {
  const ScriptDef script = {.path = {}, .shake = {}, .turn = ScriptTurn{{0, 0, 1}, std::numbers::pi, 1, 1.5}};
  EXPECT_LT((poseAt(script, {}, 4.0).orientation * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-12);
}

TEST(PlaceChecks, CountParticlesDeepInsideABody) {
  Json json = sparseScene();
  json["grains"]["first"]["position"] = {0, 1, 0};  // the ball's centre; both particles are within its 5 cm
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(PlaceChecks(scene).count().insideBodies, 2);
}

TEST(PlaceChecks, DoNotCountAParticleThatOnlyTouchesTheSurface) {
  Json json = sparseScene();
  json["grains"]["first"]["position"] = {0, 1.05, 0};  // on the ball's surface
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(PlaceChecks(scene).count().insideBodies, 0);
}

TEST(PlaceChecks, SeeTheInsideOfAMesh) {
  Json json = sparseScene();
  json["bodies"]["ball"]["shape"] = {{"type", "cylinder"}, {"radius", 0.05}, {"height", 0.2}};
  json["grains"]["first"]["position"] = {0, 1.05, 0};  // above a ball of that radius, within the cylinder
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(PlaceChecks(scene).count().insideBodies, 2);
}

TEST(PlaceChecks, CountGrainsOutsideTheContainer) {
  Json json = sparseScene();
  json["grains"]["first"]["position"] = {1.5, 1, 0};
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(PlaceChecks(scene).count().outside, 1);
}

TEST(PlaceChecks, CountParticlesBelowTheGround) {
  Json json = sparseScene();
  json["grains"]["first"]["position"] = {0, -0.2, 0};
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(PlaceChecks(scene).count().belowGround, 2);
}

TEST(ReplaceByMesh, KeepsBoundingSizeAndPlace) {
  SceneDef def = read(sparseScene());
  replaceByMesh(def, sceneFolder() / "../../meshes/star.obj");
  const Box bounds = boundsOf(def.bodies.at(0).shape);
  EXPECT_NEAR(bounds.size().norm(), 0.1 * std::sqrt(3.0),
              1e-3);  // the ball's box, 10 cm wide, inscribed mesh
  EXPECT_LT(bounds.center().norm(), 1e-6);
}

TEST(ReplaceByMesh, SaysWhenNoBodyIsMarked) {
  SceneDef def = read(withValue("/bodies/ball/replaceableByMesh", false));
  EXPECT_THROW(replaceByMesh(def, sceneFolder() / "../../meshes/star.obj"), SceneError);
}

// ---- the scenes that come with the program

struct ShippedScene {
  std::string name;
  std::string scale;
};

std::vector<ShippedScene> shippedScenes() {
  std::vector<ShippedScene> all;
  for (const std::string& name : sceneNames()) {
    for (const std::string& scale : scalesOf(findScene(name))) all.push_back({name, scale});
  }
  return all;
}

class ShippedScenes : public ::testing::TestWithParam<ShippedScene> {};

TEST_P(ShippedScenes, BuildWithoutOverlapOfGrains) {
  BuiltScene scene(readSceneFile(findScene(GetParam().name), GetParam().scale), 2);
  EXPECT_GT(scene.grains().grainCount(), 50);
  const granular::StepReport state = scene.grains().measure();
  // Bodies may be placed on one another; grains start free of contact, so nothing is stored in them.
  EXPECT_EQ(state.energy.elastic, 0.0);
}

TEST_P(ShippedScenes, AreNamedAfterTheirFiles) {
  EXPECT_EQ(readSceneFile(findScene(GetParam().name), GetParam().scale).name, GetParam().name);
}

TEST_P(ShippedScenes, HavePaperDefaultAndSmallScales) {
  EXPECT_EQ(scalesOf(findScene(GetParam().name)), (std::vector<std::string>{"small", "default", "paper"}));
}

void PrintTo(const ShippedScene& scene, std::ostream* out) {
  *out << scene.name << " at scale " << scene.scale;
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenes, ::testing::ValuesIn(shippedScenes()),
                         [](const auto& scene) { return scene.param.name + "_" + scene.param.scale; });

TEST(ShippedSplash, AtPaperScaleHasThePapersGrains) {
  EXPECT_EQ(readSceneFile(findScene("splash"), "paper").fills.at(0).fill.count, 45494);
}

}  // namespace
}  // namespace granular_demo
