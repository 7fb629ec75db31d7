// SPDX-License-Identifier: MIT
// Scenes come alive as their files say: masses, places, scripts, checks of places.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "bullet_bridge/convert.h"
#include "demos/runner/place_checks.h"
#include "demos/scene/scene_catalog.h"
#include "demos/world/built_scene.h"
#include "demos/world/motion_script.h"
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
  EXPECT_GT(scene.body("ball").covering->covering.positions.size(), 10u);
  EXPECT_TRUE(scene.body("plate").covering->covering.positions.empty());
}

TEST(BuiltScene, GivesGrainsTheirVelocity) {
  BuiltScene scene(read(sparseScene()), 1);
  const granular::RigidMotion motion = scene.grains().grainMotions()[scene.grain("first").index];
  EXPECT_EQ(motion.velocity, Vector3(1, 2, 3));
  EXPECT_EQ(motion.angularVelocity, Vector3(0, 5, 0));
}

TEST(BuiltScene, GivesBodiesTheirSpin) {
  Json json = sparseScene();
  json["bodies"]["ball"]["spin"] = {1, 2, 3};
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(bullet_bridge::fromBullet(scene.body("ball").body->getAngularVelocity()), Vector3(1, 2, 3));
}

TEST(BuiltScene, GivesABodyTheMomentsOfTheFileAboutTheAxesItIsDrawnIn) {
  Json json = sparseScene();
  // Its own moments would order the axes the other way round.
  json["bodies"]["ball"]["shape"] = {{"type", "box"}, {"size", {0.3, 0.2, 0.1}}};
  json["bodies"]["ball"].erase("density");
  json["bodies"]["ball"]["mass"] = 2;
  json["bodies"]["ball"]["inertia"] = {0.5, 0.6, 0.7};
  const BuiltScene scene(read(json), 1);
  const btRigidBody& body = *scene.body("ball").body;
  const Vector3 inverse = bullet_bridge::fromBullet(body.getInvInertiaDiagLocal());
  EXPECT_LT((inverse.cwiseInverse() - Vector3(0.5, 0.6, 0.7)).norm(), 1e-6);
  EXPECT_LT(scene.body("ball").pose().orientation.vec().norm(), 1e-6);
  EXPECT_NEAR(1.0 / body.getInvMass(), 2.0, 1e-12);
}

/// The sparse scene on a half-space through y = -0.1 in place of the plate.
Json halfSpaceScene() {
  Json json = sparseScene();
  json["bodies"]["plate"] = {
      {"shape", {{"type", "halfSpace"}, {"height", -0.1}}}, {"material", "steel"}, {"contact", "exact"}};
  return json;
}

TEST(BuiltScene, PutsGrainsOnAHalfSpaceThatTheyMeetExactly) {
  Json json = halfSpaceScene();
  json["shapes"]["one"] = {{"type", "sphere"}, {"particleRadius", 0.01}};
  json["grains"]["first"] = {{"shape", "one"}, {"material", "sand"}, {"position", {0.7, -0.0905, 0}}};
  BuiltScene scene(read(json), 1);
  std::vector<granular::ContactView> contacts;
  scene.grains().readContacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].overlap, 0.0005, 1e-8);
}

TEST(BuiltScene, FillsKeepOffWhatIsMetExactly) {
  Json json = smallScene();
  json["bodies"]["plate"] = {{"shape", {{"type", "halfSpace"}, {"normal", {1, 3, 0}}, {"height", 0.03}}},
                             {"material", "steel"},
                             {"contact", "exact"}};
  json["bodies"]["ball"].erase("covering");
  json["bodies"]["ball"]["contact"] = "exact";
  json["bodies"]["ball"]["position"] = {0.05, 0.06, 0};
  json["bodies"]["block"] = {{"shape", {{"type", "box"}, {"size", {0.03, 0.04, 0.02}}}},
                             {"material", "steel"},
                             {"contact", "exact"},
                             {"position", {-0.03, 0.06, 0.01}}};
  BuiltScene scene(read(json), 1);
  EXPECT_EQ(scene.grains().measure().contacts, 0);
  EXPECT_EQ(PlaceChecks(scene).count().insideBodies, 0);
}

TEST(BuiltScene, PassesOnWhatSurfaceEachParticleStandsFor) {
  const BuiltScene scene(read(sparseScene()), 1);
  const granular::Covering& covering = scene.body("ball").covering->covering;
  EXPECT_GE(covering.pieces.size(), covering.positions.size());
}

TEST(BuiltScene, KnowsItsGravityBeforeTheFirstTick) {
  Json json = sparseScene();
  json["gravity"] = {0, -2, 0};
  BuiltScene scene(read(json), 1);
  EXPECT_NEAR(scene.grains().gravity().y(), -2.0, 0.0);
}

// ---- advice

TEST(ImpactSpeed, IsTheLargestSpeedAtTheStartWhereThatIsMore) {
  Json json = sparseScene();
  json["grains"]["first"]["velocity"] = {0, 0, 30};
  const BuiltScene scene(read(json), 1);
  EXPECT_EQ(scene.impactSpeed().speed, 30.0);
  EXPECT_EQ(scene.impactSpeed().reason, "the largest speed at the start");
}

TEST(ImpactSpeed, IsElseThatOfAFallThroughTheScene) {
  Json json = halfSpaceScene();
  json["grains"]["first"]["velocity"] = {0, 0, 0};
  json["bodies"]["ball"].erase("velocity");
  json["bodies"]["ball"].erase("covering");
  json["bodies"]["ball"]["contact"] = "exact";  // its top is at 1.05, the ground at -0.1
  const BuiltScene scene(read(json), 1);
  EXPECT_NEAR(scene.impactSpeed().speed, std::sqrt(2 * 9.81 * 1.15), 1e-6);
  EXPECT_EQ(scene.impactSpeed().reason, "a fall through the scene's height, 1.15 m");
}

TEST(BuiltScene, AdvisesOnItsMaterialsByName) {
  const BuiltScene scene(read(withValue("/materials/sand/youngsModulus", 1e5)), 1);
  const auto& advice = scene.advice();
  EXPECT_TRUE(std::any_of(advice.begin(), advice.end(), [](const std::string& line) {
    return line.starts_with("sand on sand: impacts at ") && line.find("youngsModulus of sand") != line.npos;
  }));
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

TEST(PlaceChecks, SeeTheInsideOfAHalfSpace) {
  Json json = halfSpaceScene();
  json["grains"]["first"]["position"] = {5, -0.2, 0};
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
    if (!readTitle(findScene(name)).continues.empty()) continue;  // begins with another's end
    for (const std::string& scale : scalesOf(findScene(name))) all.push_back({name, scale});
  }
  return all;
}

class ShippedScenes : public ::testing::TestWithParam<ShippedScene> {};

TEST_P(ShippedScenes, BuildWithoutOverlapOfGrains) {
  if (GetParam().scale == "paper") return;  // a minute of coverings: the bulk tests build those
  BuiltScene scene(readSceneFile(findScene(GetParam().name), GetParam().scale), 2);
  EXPECT_GT(scene.grains().particleCount(), 0);
  const granular::StepReport state = scene.grains().measure();
  // Grains start free of contact, so nothing is stored in them. Bodies that are drawn face to face may touch
  // by a rounding of their positions, 1e-16 m: some 1e-34 J.
  EXPECT_LT(state.energy.elastic, 1e-30);
}

TEST_P(ShippedScenes, AreNamedAfterTheirFiles) {
  EXPECT_EQ(readSceneFile(findScene(GetParam().name), GetParam().scale).name, GetParam().name);
}

TEST_P(ShippedScenes, HavePaperDefaultAndSmallScales) {
  const std::vector<std::string> scales = scalesOf(findScene(GetParam().name));
  for (const char* scale : {"small", "default", "paper"})
    EXPECT_NE(std::find(scales.begin(), scales.end(), scale), scales.end()) << scale;
}

void PrintTo(const ShippedScene& scene, std::ostream* out) {
  *out << scene.name << " at scale " << scene.scale;
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScenes, ::testing::ValuesIn(shippedScenes()),
                         [](const auto& scene) { return scene.param.name + "_" + scene.param.scale; });

TEST(ShippedHourglass, AtPaperScaleHasThePapersGrains) {
  const SceneDef scene = readSceneFile(findScene("hourglass"), "paper");
  EXPECT_EQ(*scene.fills.at(0).fill.count + *scene.fills.at(1).fill.count, 27427);
}

TEST(ShippedRings, AreAsManyAsThePapersOnAsManyPoles) {
  const SceneDef scene = readSceneFile(findScene("rings"), "paper");
  std::map<std::string, int> counts;
  for (const BodyPart& body : scene.bodies) counts[body.name] = body.copies ? body.copies->total() : 1;
  EXPECT_EQ(counts["ring"], 1000);
  EXPECT_EQ(counts["pole"], 25);
}

// The paper's rings have about 110 particles each.
TEST(ShippedRings, HaveAsManyParticlesAsThePapers) {
  const BuiltScene scene(readSceneFile(findScene("rings"), "small"), 1);
  EXPECT_NEAR(static_cast<double>(scene.body("ring[0]").covering->covering.positions.size()), 110.0, 6.0);
}

TEST(ShippedSplash, AtPaperScaleHasThePapersGrains) {
  EXPECT_EQ(readSceneFile(findScene("splash"), "paper").fills.at(0).fill.count, 45494);
}

}  // namespace
}  // namespace granular_demo
