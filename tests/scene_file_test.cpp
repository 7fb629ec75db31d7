// SPDX-License-Identifier: MIT
// The scene loader: what it reads, and that every mistake is told in one line with file and key path.
#include "demos/scene/scene_file.h"

#include <gtest/gtest.h>

#include "scene_fixture.h"

namespace granular_demo {
namespace {

using testing::complaintAbout;
using testing::complaintAboutText;
using testing::read;
using testing::smallScene;
using testing::withValue;

// ---- what is read

TEST(SceneFile, ReadsTimes) {
  const SceneDef scene = read(smallScene());
  EXPECT_EQ(scene.duration, 0.5);
  EXPECT_EQ(scene.frameCount(), 10);
  EXPECT_EQ(scene.ticksPerFrame, 2);
}

TEST(SceneFile, CountsAStartedFrameAsAWholeOne) {
  EXPECT_EQ(read(withValue("/duration", 0.51)).frameCount(), 11);
}

TEST(SceneFile, ReadsLawsOfAPair) {
  const SceneDef scene = read(smallScene());
  ASSERT_EQ(scene.pairs.size(), 1u);
  EXPECT_EQ(scene.pairs[0].materials[0], "sand");
  EXPECT_EQ(scene.pairs[0].materials[1], "steel");
  EXPECT_EQ(scene.pairs[0].law.restitution, 0.6);
  EXPECT_EQ(scene.pairs[0].law.restitutionSpeed, 2.0);
  EXPECT_EQ(scene.pairs[0].law.friction, 0.3);
  EXPECT_EQ(scene.pairs[0].law.shear.viscosity, 5.0);
}

TEST(SceneFile, ReadsAListOfParticlesAsAShape) {
  const SceneDef scene = read(smallScene());
  ASSERT_EQ(scene.shapes.size(), 2u);
  EXPECT_EQ(scene.shapes[1].name, "pair");
  EXPECT_EQ(scene.shapes[1].particles[1].position, Vector3(0.02, 0, 0));
  EXPECT_EQ(scene.shapes[1].particles[1].radius, 0.012);
}

TEST(SceneFile, NormalisesQuaternionsGivenAsWxyz) {
  const Pose pose = read(smallScene()).grains.at(0).pose;
  // w = z: a quarter turn about z, which takes x to y.
  EXPECT_LT((pose.orientation * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-15);
}

TEST(SceneFile, ReadsOrientationsAsAxisAndDegrees) {
  const Json turn = {{"axis", {0, 0, 2}}, {"degrees", 90}};
  const Pose pose = read(withValue("/grains/first/orientation", turn)).grains.at(0).pose;
  EXPECT_LT((pose.orientation * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-15);
}

TEST(SceneFile, ReadsBodies) {
  const SceneDef scene = read(smallScene());
  ASSERT_EQ(scene.bodies.size(), 2u);
  const BodyPart& ball = scene.bodies[0];
  EXPECT_EQ(ball.name, "ball");
  EXPECT_EQ(std::get<SphereShape>(ball.shape).radius, 0.05);
  EXPECT_EQ(ball.motion, BodyKind::dynamic);
  EXPECT_EQ(ball.velocity, Vector3(0, -3, 0));
  EXPECT_TRUE(ball.replaceableByMesh);
  EXPECT_EQ(scene.bodies[1].script, "wobble");
}

TEST(SceneFile, PutsMeshesInTheFolderOfTheSceneFile) {
  const Json shape = {{"type", "mesh"}, {"file", "nothing_here.obj"}};
  EXPECT_EQ(complaintAbout(withValue("/bodies/ball/shape", shape)),
            "folder/test.json: bodies.ball.shape.file: value \"nothing_here.obj\"; allowed: a mesh file, "
            "relative to "
            "the scene file");
}

// ---- scales

TEST(SceneScales, PatchOneValueAndKeepTheRest) {
  const FillPart small = read(smallScene(), "small").fills.at(0);
  EXPECT_EQ(small.fill.count, 5);
  EXPECT_EQ(small.fill.maxScale, 1.1);
}

TEST(SceneScales, RemoveAValueByNull) {
  EXPECT_EQ(read(smallScene(), "still").bodies.at(0).velocity, Vector3(0, 0, 0));
}

TEST(SceneScales, DefaultNeedNotBeWritten) {
  EXPECT_EQ(read(smallScene(), "default").fills.at(0).fill.count, 20);
}

TEST(SceneScales, UnknownOnesAreRefusedWithThoseThereAre) {
  EXPECT_EQ(complaintAbout(smallScene(), "huge"),
            "folder/test.json: scales: value \"huge\"; allowed: one of small, still, default");
}

TEST(SceneScales, ComplaintsAboutAPatchNameTheScale) {
  EXPECT_EQ(complaintAbout(withValue("/scales/small/fills/heap/count", 0), "small"),
            "folder/test.json: scales.small.fills.heap.count: value 0; allowed: an integer >= 1");
}

TEST(SceneScales, ComplaintsAboutTheRestDoNotNameTheScale) {
  EXPECT_EQ(complaintAbout(withValue("/fills/heap/gap", -1), "small"),
            "folder/test.json: fills.heap.gap: value -1; allowed: a number >= 0");
}

// ---- complaints

struct Mistake {
  const char* pointer;  // where
  Json value;           // what stands there
  const char* message;  // after "folder/test.json: "
};

class SceneMistake : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneMistake, IsToldWithFileAndKeyPath) {
  EXPECT_EQ(complaintAbout(withValue(GetParam().pointer, GetParam().value)),
            std::string("folder/test.json: ") + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    All, SceneMistake,
    ::testing::Values(
        Mistake{"/duration", -1, "duration: value -1; allowed: a number > 0"},
        Mistake{"/duration", "long", "duration: value \"long\"; allowed: a number > 0"},
        Mistake{"/frameRate", 0, "frameRate: value 0; allowed: a number > 0"},
        Mistake{"/ticksPerFrame", 2.5, "ticksPerFrame: value 2.5; allowed: an integer in [1, 1000000]"},
        Mistake{"/seed", -4, "seed: value -4; allowed: an integer >= 0"},
        Mistake{"/gravity", {0, -9.81}, "gravity: value [0,-9.81]; allowed: three numbers [x, y, z]"},
        Mistake{"/gravity", {0, "g", 0}, "gravity[1]: value \"g\"; allowed: a number"},
        Mistake{"/integrator/stepper", "euler",
                "integrator.stepper: value \"euler\"; allowed: one of rkf45, leapfrog, "
                "verlet, semiImplicitEuler, bogackiShampine"},
        Mistake{"/integrator/tolerance", 0, "integrator.tolerance: value 0; allowed: a number > 0"},
        Mistake{"/integrator/contactTimeFraction", 0.5,
                "integrator.contactTimeFraction: value 0.5; allowed: a number in (0, 0.3]"},
        Mistake{"/integrator/speed", 1,
                "integrator.speed: unknown key; allowed here: stepper, fixedSubStep, tolerance, "
                "contactTimeFraction, eventFraction, eventContacts, precision, turnSpheres, smallestSubStep, "
                "trialLimit"},
        Mistake{"/integrator/eventFraction", 2,
                "integrator.eventFraction: value 2; allowed: a number in (0, 1]"},
        Mistake{"/integrator/eventContacts", -1,
                "integrator.eventContacts: value -1; allowed: an integer in [0, 2147483647]"},
        Mistake{"/integrator/trialLimit", 0,
                "integrator.trialLimit: value 0; allowed: an integer in [1, 2147483647]"},
        Mistake{"/materials", Json::object(), "materials: value {}; allowed: at least one material"},
        Mistake{"/materials/sand/restitution", 1.2,
                "materials.sand.restitution: value 1.2; allowed: a number in [0.01, 1]"},
        Mistake{"/materials/sand/poissonRatio", 0.6,
                "materials.sand.poissonRatio: value 0.6; allowed: a number in (-1, 0.5]"},
        Mistake{"/materials/sand/youngsModulus", nullptr,
                "materials.sand.youngsModulus: value null; allowed: a number > 0"},
        Mistake{"/pairs/0/between",
                {"sand"},
                "pairs[0].between: value [\"sand\"]; allowed: two names of materials"},
        Mistake{"/pairs/0/between/1", "snow",
                "pairs[0].between[1]: value \"snow\"; allowed: one of sand, steel"},
        Mistake{"/pairs/0/normal/law", "spring",
                "pairs[0].normal.law: value \"spring\"; allowed: one of hertz-viscoelastic, hertz-tsuji, "
                "hertz-constant-damping, linear-spring"},
        Mistake{"/pairs/0/shear/viscosity", -5, "pairs[0].shear.viscosity: value -5; allowed: a number >= 0"},
        Mistake{
            "/shapes/tetra/type", "octahedron",
            "shapes.tetra.type: value \"octahedron\"; allowed: one of sphere, tetrahedron, cube, particles"},
        Mistake{"/shapes/tetra/particleRadius", 0,
                "shapes.tetra.particleRadius: value 0; allowed: a number > 0"},
        Mistake{"/shapes/pair/particles/1/radius", -0.1,
                "shapes.pair.particles[1].radius: value -0.1; allowed: a number > 0"},
        Mistake{"/shapes/pair/particles", Json::array(),
                "shapes.pair.particles: value []; allowed: at least one particle"},
        Mistake{
            "/fills/heap/region/type", "torus",
            "fills.heap.region.type: value \"torus\"; allowed: one of box, cylinder, cone, frustum, ball, "
            "slope, mesh"},
        Mistake{"/fills/heap/region/radius", 0, "fills.heap.region.radius: value 0; allowed: a number > 0"},
        Mistake{"/fills/heap/shape", "cube", "fills.heap.shape: value \"cube\"; allowed: one of tetra, pair"},
        Mistake{"/fills/heap/material", 7, "fills.heap.material: value 7; allowed: one of sand, steel"},
        Mistake{"/fills/heap/scale", {1.1, 0.9}, "fills.heap.scale[1]: value 0.9; allowed: a number >= 1.1"},
        Mistake{"/fills/heap/solidFraction", 0.9,
                "fills.heap.solidFraction: value 0.9; allowed: a number in (0, 0.7]"},
        Mistake{"/fills/heap/look/coloring", "red",
                "fills.heap.look.coloring: value \"red\"; allowed: one of sand, owner, speed, fixed"},
        Mistake{
            "/grains/first/orientation",
            {0, 0, 0, 0},
            "grains.first.orientation: value [0,0,0,0]; allowed: four numbers [w, x, y, z], not all zero"},
        Mistake{"/grains/first/velocity", 3,
                "grains.first.velocity: value 3; allowed: three numbers [x, y, z]"},
        Mistake{"/scripts/wobble/path/1/time", 0,
                "scripts.wobble.path[1].time: value 0; allowed: a number > 0"},
        Mistake{"/scripts/wobble/turn/axis",
                {0, 0, 0},
                "scripts.wobble.turn.axis: value [0,0,0]; allowed: a direction, not zero"},
        Mistake{"/bodies/ball/shape/type", "egg",
                "bodies.ball.shape.type: value \"egg\"; allowed: one of mesh, box, sphere, capsule, "
                "cylinder, cone, "
                "planePatch, halfSpace, compound"},
        Mistake{
            "/bodies/ball/shape",
            {{"type", "halfSpace"}},
            "bodies.ball.motion: value \"dynamic\"; allowed: \"static\" or \"kinematic\" for a planePatch or "
            "halfSpace"},
        Mistake{"/bodies/ball/shape",
                {{"type", "halfSpace"}, {"normal", {0, 0, 0}}},
                "bodies.ball.shape.normal: value [0,0,0]; allowed: a direction, not zero"},
        Mistake{"/bodies/ball/contact", "soft",
                "bodies.ball.contact: value \"soft\"; allowed: one of particles, exact"},
        Mistake{
            "/bodies/plate",
            {{"shape", {{"type", "planePatch"}, {"sizeX", 1}, {"sizeZ", 1}}},
             {"material", "steel"},
             {"contact", "exact"}},
            "bodies.plate.contact: value \"exact\"; allowed: \"particles\" for a planePatch or a compound"},
        Mistake{"/bodies/ball/contact", "exact",
                "bodies.ball.covering: value {\"particleRadius\":0.01}; allowed: none, since \"contact\" is "
                "\"exact\""},
        Mistake{"/bodies/ball/inertia",
                {1, 1, 1},
                "bodies.ball.inertia: value [1,1,1]; allowed: only together with \"mass\""},
        Mistake{"/bodies/ball/shape/radius", -1, "bodies.ball.shape.radius: value -1; allowed: a number > 0"},
        Mistake{"/bodies/plate/shape/size",
                {1, 0, 1},
                "bodies.plate.shape.size: value [1,0,1]; allowed: three numbers > 0"},
        Mistake{"/bodies/ball/motion", "flying",
                "bodies.ball.motion: value \"flying\"; allowed: one of static, kinematic, dynamic"},
        Mistake{"/bodies/ball/mass", 2,
                "bodies.ball.density: value 7800; allowed: none, since \"mass\" is given too"},
        Mistake{"/bodies/plate/mass", 2,
                "bodies.plate.mass: value 2; allowed: only for \"motion\": \"dynamic\""},
        Mistake{"/bodies/ball/script", "wobble",
                "bodies.ball.script: value \"wobble\"; allowed: only for \"motion\": \"kinematic\""},
        Mistake{"/bodies/plate/script", "dance",
                "bodies.plate.script: value \"dance\"; allowed: one of wobble"},
        Mistake{"/bodies/plate/velocity",
                {1, 0, 0},
                "bodies.plate.velocity: value [1,0,0]; allowed: only for \"motion\": \"dynamic\""},
        Mistake{
            "/bodies/ball/covering/radius", 1,
            "bodies.ball.covering.radius: unknown key; allowed here: particleRadius, density, offset, seed, "
            "roughness"},
        Mistake{"/bodies/ball/look/color",
                {2, 0, 0},
                "bodies.ball.look.color: value [2,0,0]; allowed: three numbers in [0, 1]: red, green, blue"},
        Mistake{"/container/upper",
                {1, -2, 1},
                "container.upper: value [1,-2,1]; allowed: greater than \"lower\" in x, y and z"},
        Mistake{"/container/closed", 1, "container.closed: value 1; allowed: true or false"},
        Mistake{"/cameras/front/target",
                {0, 5, 3},
                "cameras.front.target: value [0,5,3]; allowed: a point off the line through \"eye\" along "
                "\"up\""},
        Mistake{"/outputs/width", 321, "outputs.width: value 321; allowed: an even number"},
        Mistake{"/outputs/trajectories/bodies/0", "bell",
                "outputs.trajectories.bodies[0]: value \"bell\"; allowed: one of ball, plate"},
        Mistake{"/windSpeed", 3,
                "windSpeed: unknown key; allowed here: name, description, continues, gravity, duration, "
                "frameRate, "
                "ticksPerFrame, seed, integrator, sleep, materials, pairs, shapes, fills, grains, scripts, "
                "bodies, "
                "emitters, joints, meters, expect, largestStartOverlap, container, "
                "groundHeight, cameras, look, outputs"}));

TEST(SceneFile, NamesAKeyThatIsMissing) {
  Json scene = smallScene();
  scene["bodies"]["ball"].erase("material");
  EXPECT_EQ(complaintAbout(scene), "folder/test.json: bodies.ball.material: is missing");
}

TEST(SceneFile, ReadsEveryFieldOfTheIntegrator) {
  const granular::IntegratorDef def = read(withValue("/integrator", {{"tolerance", 1e-6},
                                                                     {"contactTimeFraction", 0.2},
                                                                     {"eventFraction", 0.01},
                                                                     {"eventContacts", 5},
                                                                     {"precision", "mixed"},
                                                                     {"turnSpheres", false},
                                                                     {"smallestSubStep", 1e-12},
                                                                     {"trialLimit", 77}}))
                                          .integrator;
  EXPECT_EQ(def.tolerance, 1e-6);
  EXPECT_EQ(def.contactTimeFraction, 0.2);
  EXPECT_EQ(def.eventFraction, 0.01);
  EXPECT_EQ(def.eventContacts, 5);
  EXPECT_EQ(def.precision, granular::ContactPrecision::Mixed);
  EXPECT_FALSE(def.turnSpheres);
  EXPECT_EQ(def.smallestSubStep, 1e-12);
  EXPECT_EQ(def.trialLimit, 77);
}

TEST(SceneFile, ReadsAHalfSpaceMetExactly) {
  Json scene = smallScene();
  scene["bodies"]["floor"] = {{"shape", {{"type", "halfSpace"}, {"normal", {0, 3, 4}}, {"height", -0.2}}},
                              {"material", "steel"},
                              {"contact", "exact"}};
  const BodyPart floor = read(scene).bodies.back();
  EXPECT_EQ(floor.contact, BodyContact::exact);
  EXPECT_TRUE(floor.meetsGrains());
  EXPECT_LT((std::get<HalfSpaceShape>(floor.shape).normal - Vector3(0, 0.6, 0.8)).norm(), 1e-15);
  EXPECT_EQ(std::get<HalfSpaceShape>(floor.shape).height, -0.2);
}

TEST(SceneFile, RefusesAHalfSpaceWithinACompound) {
  Json scene = smallScene();
  scene["bodies"]["plate"]["shape"] = {{"type", "compound"},
                                       {"children", {{{"shape", {{"type", "halfSpace"}}}}}}};
  EXPECT_EQ(
      complaintAbout(scene),
      "folder/test.json: bodies.plate.shape.children[0].shape: value {\"type\":\"halfSpace\"}; allowed: "
      "any shape but a halfSpace, which has no end");
}

TEST(SceneFile, RefusesMomentsThatNoSolidHas) {
  Json scene = smallScene();
  scene["bodies"]["ball"].erase("density");
  scene["bodies"]["ball"]["mass"] = 2;
  scene["bodies"]["ball"]["inertia"] = {1, 1, 2.5};
  EXPECT_EQ(complaintAbout(scene),
            "folder/test.json: bodies.ball.inertia: value [1,1,2.5]; allowed: three "
            "numbers of which none exceeds the sum of the other two");
  scene["bodies"]["ball"]["inertia"] = {1, 1, 2};
  EXPECT_EQ(complaintAbout(scene), "");
}

TEST(SceneFile, RefusesANumberTooLargeForADouble) {
  std::string text = smallScene().dump();
  const std::string number = "\"duration\":0.5";
  text.replace(text.find(number), number.size(), "\"duration\":1e999");
  EXPECT_EQ(complaintAboutText(text), "folder/test.json: holds a number too large for a double");
}

// ---- every number of the physics, negative or zero

struct NumberKey {
  const char* pointer;
  bool zeroIsAllowed;
};

class SceneNumber : public ::testing::TestWithParam<NumberKey> {};

/// The complaint about a value at the key begins with the key's path.
bool isRefused(const char* pointer, const Json& value) {
  std::string path;
  for (const char* c = pointer + 1; *c != 0; ++c) path += *c == '/' ? '.' : *c;
  for (const char* list : {"pairs.0", "particles.0"}) {  // places in lists are written [0]
    const std::size_t at = path.find(list);
    if (at != std::string::npos) path.replace(path.find('.', at), 2, "[0]");
  }
  return complaintAbout(withValue(pointer, value)).starts_with("folder/test.json: " + path + ": value ");
}

TEST_P(SceneNumber, IsRefusedWhereItMeansNothing) {
  EXPECT_TRUE(isRefused(GetParam().pointer, -1e-9));
  EXPECT_TRUE(isRefused(GetParam().pointer, "a lot"));
  EXPECT_TRUE(isRefused(GetParam().pointer, nullptr));
  EXPECT_EQ(isRefused(GetParam().pointer, 0), !GetParam().zeroIsAllowed);
}

INSTANTIATE_TEST_SUITE_P(
    All, SceneNumber,
    ::testing::Values(
        NumberKey{"/duration", false}, NumberKey{"/frameRate", false},
        NumberKey{"/integrator/tolerance", false}, NumberKey{"/integrator/contactTimeFraction", false},
        NumberKey{"/integrator/eventFraction", false}, NumberKey{"/integrator/smallestSubStep", false},
        NumberKey{"/materials/sand/density", false}, NumberKey{"/materials/sand/youngsModulus", false},
        NumberKey{"/materials/sand/restitution", false}, NumberKey{"/materials/sand/friction", true},
        NumberKey{"/pairs/0/normal/restitution", false}, NumberKey{"/pairs/0/normal/atSpeed", false},
        NumberKey{"/pairs/0/normal/contactTime", false}, NumberKey{"/pairs/0/normal/stiffness", false},
        NumberKey{"/pairs/0/normal/damping", true}, NumberKey{"/pairs/0/bodyNormal/stiffness", false},
        NumberKey{"/pairs/0/bodyNormal/damping", true}, NumberKey{"/pairs/0/shear/friction", true},
        NumberKey{"/pairs/0/shear/viscosity", true}, NumberKey{"/pairs/0/shear/stiffness", false},
        NumberKey{"/pairs/0/shear/dampingRatio", true}, NumberKey{"/shapes/tetra/particleRadius", false},
        NumberKey{"/shapes/pair/particles/0/radius", false}, NumberKey{"/grains/first/scale", false},
        NumberKey{"/bodies/ball/shape/radius", false}, NumberKey{"/bodies/ball/density", false},
        NumberKey{"/bodies/ball/covering/particleRadius", false},
        NumberKey{"/bodies/ball/covering/density", false}, NumberKey{"/fills/heap/gap", true}));

TEST(SceneFile, WantsAMassOrADensityForADynamicBody) {
  Json scene = smallScene();
  scene["bodies"]["ball"].erase("density");
  const std::string complaint = complaintAbout(scene);
  EXPECT_TRUE(complaint.starts_with("folder/test.json: bodies.ball: value {")) << complaint;
  EXPECT_TRUE(complaint.ends_with("allowed: with \"mass\" or \"density\", since it is dynamic")) << complaint;
}

TEST(SceneFile, NamesLineAndColumnOfASyntaxError) {
  const std::string complaint = complaintAboutText("{\n  \"name\": \"x\",\n  \"duration\": oops\n}");
  EXPECT_TRUE(complaint.starts_with("folder/test.json: line 3, column 15: not JSON: ")) << complaint;
  EXPECT_EQ(complaint.find('\n'), std::string::npos);
}

TEST(SceneFile, RefusesAKeyGivenTwice) {
  EXPECT_EQ(complaintAboutText("{\"name\": \"x\", \"duration\": 1, \"name\": \"y\"}"),
            "folder/test.json: key \"name\" is given twice in one object");
}

TEST(SceneFile, RefusesAFileThatIsNotAnObject) {
  EXPECT_EQ(complaintAboutText("[1, 2]"), "folder/test.json: the file: value [1,2]; allowed: an object");
}

TEST(SceneFile, NamesAFileThatCannotBeOpened) {
  try {
    readSceneFile("no/such/scene.json");
    FAIL() << "a missing file went unnoticed";
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(), "no/such/scene.json: cannot be opened");
  }
}

}  // namespace
}  // namespace granular_demo
