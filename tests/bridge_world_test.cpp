// SPDX-License-Identifier: MIT
// The world's door: what it refuses, what it leaves alone, what it reports.
#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

/// Text of the std::invalid_argument that an action throws; empty if it throws none.
template <class Action>
std::string refusalOf(Action action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

/// A world with other settings in place of the scene's.
void replaceWorld(SandScene& scene, const bullet_bridge::LayerDef& def) {
  scene.world = std::make_unique<bullet_bridge::GranularDynamicsWorld>(
      &scene.dispatcher, &scene.broadphase, &scene.solver, &scene.configuration, def);
}

template <class World>
std::vector<double> runStack() {
  Scene<World> scene;
  scene.body(0, scene.box(5, 0.5, 5), at(0, -0.5, 0));
  for (int i = 0; i < 5; ++i) scene.body(1, scene.box(0.5, 0.5, 0.5), at(0.03 * i, 0.5 + 1.01 * i, 0));
  scene.body(2, scene.sphere(0.3), at(0.1, 7.0, 0.2));
  std::vector<double> bits;
  for (int i = 0; i < 300; ++i) {
    scene.world->stepSimulation(scalar(1.0 / 60.0), 3, scalar(1.0 / 120.0));
    for (const auto& body : scene.bodies) {
      for (const double v : positionOf(*body)) bits.push_back(v);
      for (const double v : velocityOf(*body)) bits.push_back(v);
      for (const double v : fromBullet(body->getWorldTransform().getBasis()).coeffs()) bits.push_back(v);
    }
  }
  return bits;
}

TEST(GranularDynamicsWorld, WithoutSandTakesTheSameBitsAsBullet) {
  EXPECT_EQ(runStack<bullet_bridge::GranularDynamicsWorld>(), runStack<btDiscreteDynamicsWorld>());
}

TEST(GranularDynamicsWorld, LeavesUncoveredBodiesTheirBitsBesideSand) {
  const auto dropBox = [](bool withSand) {
    SandScene scene;
    scene.body(0, scene.box(5, 0.5, 5), at(0, -0.5, 0));
    btRigidBody& box = scene.body(1, scene.box(0.5, 0.5, 0.5), at(0, 2, 0));
    if (withSand) {
      scene.world->addPile({.region = {{10, 0, 10}, {10.1, 0.1, 10.1}}, .particleRadius = 0.01});
    }
    std::vector<Vector3> positions;
    for (int i = 0; i < 60; ++i) {
      scene.world->stepSimulation(scalar(1.0 / 60.0));
      positions.push_back(positionOf(box));
    }
    return positions;
  };
  EXPECT_EQ(dropBox(true), dropBox(false));
}

TEST(CoverBody, RefusesABodyThatIsCovered) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  EXPECT_NE(refusalOf([&] { scene.world->coverBody(ball, oneParticle(0.1)); }).find("covered already"),
            std::string::npos);
}

TEST(CoverBody, RefusesABodyOfAnotherWorld) {
  SandScene here;
  SandScene there;
  btRigidBody& ball = there.body(1, there.sphere(0.1), at(0, 0, 0));
  EXPECT_NE(refusalOf([&] { here.world->coverBody(ball, oneParticle(0.1)); }).find("not in this world"),
            std::string::npos);
}

TEST(CoverBody, RefusesADynamicBodyWithoutMass) {
  SandScene scene;
  btRigidBody& ball = scene.body(0, scene.sphere(0.1), at(0, 0, 0));
  ball.setCollisionFlags(ball.getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT);
  EXPECT_NE(refusalOf([&] { scene.world->coverBody(ball, oneParticle(0.1)); }).find("inverse mass is 0"),
            std::string::npos);
}

TEST(CoverBody, RefusesATransformThatIsNotFinite) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  ball.getWorldTransform().setOrigin(vec(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  EXPECT_NE(refusalOf([&] { scene.world->coverBody(ball, oneParticle(0.1)); }).find("not finite"),
            std::string::npos);
}

TEST(CoverBody, RefusesInertiaAlongSomeAxesOnly) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  ball.setMassProps(1, vec(1, 0, 1));
  EXPECT_NE(refusalOf([&] { scene.world->coverBody(ball, oneParticle(0.1)); }).find("inverse inertia"),
            std::string::npos);
}

TEST(CoverBody, LeavesNothingBehindWhenItRefuses) {
  SandScene scene;
  btRigidBody& ground = scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0)), at(0, 0, 0));
  EXPECT_NE(refusalOf([&] { scene.world->coverBody(ground); }).find("PlanePatch.size is 0 m"),
            std::string::npos);
  EXPECT_FALSE(scene.world->isCovered(ground));
  EXPECT_EQ(scene.world->grains().bodyCount(), 0);
}

TEST(CoverBody, UsesTheGrainsParticleRadius) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 1, 0));
  scene.world->addPile({.region = {{0, 0, 0}, {0.2, 0.2, 0.2}}, .particleRadius = 0.02});
  const granular::BodyId id = scene.world->coverBody(ball);
  for (const double radius : scene.world->grains().covering(id).radii) EXPECT_EQ(radius, 0.02);
}

TEST(CoverBody, WithoutGrainsTakesItsRadiusFromTheShape) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.5), at(0, 1, 0));
  const granular::BodyId id = scene.world->coverBody(ball);
  // 500 discs of radius r have the area of the sphere: r = 2 R / sqrt(500), and 1 % for the mesh.
  EXPECT_NEAR(scene.world->grains().covering(id).radii[0], 1.0 / std::sqrt(500.0), 0.0005);
}

TEST(CoverBody, KeepsTheParticlesWithinTheShape) {
  SandScene scene;
  btRigidBody& box = scene.body(1, scene.box(0.3, 0.2, 0.1), at(0, 1, 0));
  const auto& covering =
      scene.world->grains().covering(scene.world->coverBody(box, {.particleRadius = 0.02}));
  for (std::size_t i = 0; i < covering.positions.size(); ++i) {
    const Vector3 reach = covering.positions[i].cwiseAbs().array() + covering.radii[i];
    EXPECT_TRUE(((reach - Vector3(0.3, 0.2, 0.1)).array() < 0.02 * 0.02).all()) << reach.transpose();
  }
}

TEST(CoverBody, CoversAPatchOfAPlaneLevelWithIt) {
  SandScene scene;
  btRigidBody& ground =
      scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0.5)), at(0, 0, 0));
  const granular::BodyId id = scene.world->coverBody(
      ground, {.particleRadius = 0.05, .shapeSurface = {.plane = {.center = {1, 0, 0}, .size = 1.0}}});
  const granular::Covering& covering = scene.world->grains().covering(id);
  double top = 0.0;
  for (const Vector3& p : covering.positions) top = std::max(top, p.y() + 0.05);
  EXPECT_NEAR(top, 0.5, 0.05 * 0.02);
  for (const Vector3& p : covering.positions) EXPECT_LT(std::abs(p.x() - 1.0), 0.5);
}

TEST(CoverBody, CoversEveryChildOfACompound) {
  SandScene scene;
  auto& dumbbell = scene.shape<btCompoundShape>();
  dumbbell.addChildShape(at(-0.5, 0, 0), &scene.sphere(0.2));
  dumbbell.addChildShape(at(0.5, 0, 0), &scene.box(0.2, 0.2, 0.2));
  btRigidBody& body = scene.body(1, dumbbell, at(0, 0, 0));
  const auto& covering =
      scene.world->grains().covering(scene.world->coverBody(body, {.particleRadius = 0.04}));
  const auto left = std::count_if(covering.positions.begin(), covering.positions.end(),
                                  [](const Vector3& p) { return p.x() < 0.0; });
  // About D = 0.84 discs a disc area; the surface of the particles' centres is a particle radius smaller.
  EXPECT_GT(left, 0.5 * std::pow(0.16 / 0.04, 2) * 4);
  EXPECT_GT(static_cast<std::ptrdiff_t>(covering.positions.size()) - left,
            0.5 * 6 * std::pow(0.32, 2) / (3.1416 * 0.04 * 0.04));
}

TEST(CoverBody, TakesAMeshInPlaceOfTheShape) {
  SandScene scene;
  btRigidBody& body = scene.body(1, scene.sphere(0.2), at(0, 0, 0));
  bullet_bridge::CoverBodyDef def{.particleRadius = 0.02};
  def.surface = bullet_bridge::shapeSurface(btBoxShape(vec(0.1, 0.1, 0.3)));
  double top = 0.0;
  for (const Vector3& p : scene.world->grains().covering(scene.world->coverBody(body, def)).positions) {
    top = std::max(top, p.z() + 0.02);
  }
  EXPECT_NEAR(top, 0.3, 0.02 * 0.02);
}

TEST(UncoverBody, RefusesABodyThatIsNotCovered) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  EXPECT_FALSE(refusalOf([&] { scene.world->uncoverBody(ball); }).empty());
  EXPECT_FALSE(refusalOf([&] { scene.world->bodyIdOf(ball); }).empty());
}

TEST(UncoverBody, GivesTheBodyBackToBulletInFlight) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  for (int i = 0; i < 10; ++i) scene.world->stepSimulation(scalar(1.0 / 60.0));
  scene.world->uncoverBody(ball);
  const double before = velocityOf(ball).y();
  scene.world->stepSimulation(scalar(1.0 / 60.0));
  EXPECT_NEAR(velocityOf(ball).y(), before - 10.0 / 60.0, 1e-6);  // Bullet's gravity is 10 m/s^2 by default
}

TEST(UncoverBody, HappensWhenTheBodyLeavesTheWorld) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  btRigidBody& other = scene.body(1, scene.sphere(0.1), at(5, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  scene.world->coverBody(other, oneParticle(0.1));
  scene.world->removeRigidBody(&ball);
  EXPECT_FALSE(scene.world->isCovered(ball));
  scene.world->removeCollisionObject(&other);
  EXPECT_FALSE(scene.world->isCovered(other));
  EXPECT_EQ(scene.world->grains().bodyCount(), 0);
  scene.world->stepSimulation(scalar(1.0 / 60.0));
}

TEST(GranularDynamicsWorld, MayGoBeforeItsBodies) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  scene.world->stepSimulation(scalar(1.0 / 60.0));
  scene.world.reset();
  EXPECT_LT(positionOf(ball).y(), 0.0);
}

TEST(GranularDynamicsWorld, MayGoAfterItsBodies) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, oneParticle(0.1));
  scene.world->removeRigidBody(&ball);
  scene.bodies.clear();
  scene.world->stepSimulation(scalar(1.0 / 60.0));
  EXPECT_EQ(scene.world->getNumCollisionObjects(), 0);
}

TEST(AddPile, PutsEveryParticleIntoTheBox) {
  SandScene scene;
  const granular::Box box{{-0.1, 0, -0.1}, {0.1, 0.2, 0.1}};
  for (const auto shape : {bullet_bridge::PileShape::Sphere, bullet_bridge::PileShape::Tetrahedron,
                           bullet_bridge::PileShape::Cube}) {
    SandScene own;
    EXPECT_GT(own.world->addPile({.region = box, .particleRadius = 0.01, .shape = shape}).size(), 20u);
    std::vector<granular::ParticleView> particles;
    own.world->grains().readParticles(particles);
    for (const auto& p : particles) {
      EXPECT_TRUE(((p.position - box.lower).array() > 0.01 * (1 - 1e-9)).all()) << p.position.transpose();
      EXPECT_TRUE(((box.upper - p.position).array() > 0.01 * (1 - 1e-9)).all()) << p.position.transpose();
    }
  }
}

TEST(AddPile, KeepsClearOfWhatIsThere) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.05), at(0, 0.1, 0));
  scene.world->coverBody(ball, {.particleRadius = 0.01, .offset = 0.0});
  const granular::Box box{{-0.1, 0, -0.1}, {0.1, 0.2, 0.1}};
  scene.world->addPile({.region = box, .particleRadius = 0.01});
  EXPECT_EQ(scene.world->grains().measure().contacts, 0);
}

TEST(AddPile, RefusesARadiusThatIsNotPositive) {
  SandScene scene;
  EXPECT_NE(refusalOf([&] {
              scene.world->addPile({.region = {{0, 0, 0}, {1, 1, 1}}});
            }).find("PileDef.particleRadius is 0 m"),
            std::string::npos);
}

TEST(SetGravity, ReachesTheGrainsBeforeTheFirstTick) {
  SandScene scene;
  granular::GranularSystem& sand = scene.world->grains();
  const granular::GrainId grain = sand.addGrain({.shape = sand.addGrainShape(granular::sphereShape(0.05)),
                                                 .material = sand.addMaterial({}),
                                                 .pose = {.position = {0, 2, 0}}});
  scene.world->setGravity(vec(0, -4, 0));
  EXPECT_DOUBLE_EQ(sand.measure().energy.potential, 2.0 * 4.0 * sand.massOf(grain));
}

TEST(SetGravity, RefusesWhatIsNotFinite) {
  SandScene scene;
  const btVector3 before = scene.world->getGravity();
  EXPECT_THROW(scene.world->setGravity(vec(0, std::nan(""), 0)), std::invalid_argument);
  EXPECT_EQ(fromBullet(scene.world->getGravity()), fromBullet(before));
}

TEST(LastStep, AddsUpTheTicksOfOneCall) {
  SandScene scene;
  scene.world->addPile({.region = {{0, 0, 0}, {0.1, 0.1, 0.1}}, .particleRadius = 0.01});
  scene.world->stepSimulation(scalar(3.0 / 64.0), 4, scalar(1.0 / 64.0));
  EXPECT_GE(scene.world->lastStep().subSteps, 3);
  EXPECT_GE(scene.world->lastStep().evaluations, 3);
  EXPECT_NEAR(scene.world->lastStep().time, 3.0 / 64.0, 1e-12);
  scene.world->stepSimulation(scalar(1.0 / 256.0), 4, scalar(1.0 / 64.0));  // too short for a tick
  EXPECT_EQ(scene.world->lastStep().subSteps, 0);
}

class CountingDrawer : public btIDebugDraw {
 public:
  void drawLine(const btVector3&, const btVector3&, const btVector3&) override { ++lines; }
  void drawSphere(btScalar, const btTransform&, const btVector3&) override { ++spheres; }
  void drawSphere(const btVector3&, btScalar, const btVector3&) override { ++spheres; }
  void drawContactPoint(const btVector3&, const btVector3&, btScalar, int, const btVector3&) override {}
  void reportErrorWarning(const char*) override {}
  void draw3dText(const btVector3&, const char*) override {}
  void setDebugMode(int mode) override { mode_ = mode; }
  int getDebugMode() const override { return mode_; }
  int lines = 0;
  int spheres = 0;

 private:
  int mode_ = DBG_DrawWireframe;
};

TEST(DebugDraw, ShowsEachParticleOfASmallScene) {
  SandScene scene;
  CountingDrawer drawer;
  scene.world->setDebugDrawer(&drawer);
  scene.world->addPile({.region = {{0, 0, 0}, {0.1, 0.1, 0.1}}, .particleRadius = 0.01});
  scene.world->debugDrawWorld();
  EXPECT_EQ(drawer.spheres, scene.world->grains().particleCount());
}

TEST(DebugDraw, KeepsToItsLimit) {
  SandScene scene;
  replaceWorld(scene, {.drawnParticleLimit = 10});
  CountingDrawer drawer;
  scene.world->setDebugDrawer(&drawer);
  scene.world->addPile({.region = {{0, 0, 0}, {0.1, 0.1, 0.1}}, .particleRadius = 0.01});
  scene.world->debugDrawWorld();
  EXPECT_GT(drawer.spheres, 0);
  EXPECT_LE(drawer.spheres, 10);
}

TEST(GranularDynamicsWorld, HasItsBudgetForTheWholeStepSimulation) {
  SandScene scene;
  replaceWorld(scene, {.budget = {.evaluations = 200}});
  scene.world->coverBody(scene.body(0, scene.box(0.5, 0.5, 0.5), at(0, -0.5, 0)));
  btRigidBody& cube = scene.body(1000, scene.box(0.5, 0.5, 0.5), at(0, 0.5, 0));
  scene.world->coverBody(cube);
  const double tick = 1.0 / 64.0;
  scene.world->stepSimulation(scalar(8 * tick), 8, scalar(tick));
  const granular::StepReport& report = scene.world->lastStep();
  EXPECT_TRUE(has(report.flags, granular::StepFlag::BudgetExhausted));
  EXPECT_NEAR(report.droppedTime + scene.world->grains().time(), 8 * tick, 1e-12);
  EXPECT_GT(report.droppedTime, 6 * tick) << "a cube at rest takes 600 evaluations a tick";
  EXPECT_LE(report.evaluations, 207) << "a trial of six may end beyond it, and a report takes one";
  EXPECT_NEAR(positionOf(cube).y(), 0.5, 1e-4);
}

/// Where the grains of a poured pile are after a fifth of a second.
std::vector<granular::RigidMotion> pouredPile(const bullet_bridge::LayerDef& def) {
  SandScene scene;
  replaceWorld(scene, def);
  scene.world->coverBody(scene.body(0, scene.box(0.2, 0.02, 0.2), at(0, -0.02, 0)),
                         {.contact = bullet_bridge::SurfaceContact::Exact});
  scene.world->addPile({.region = {{-0.1, 0.0, -0.1}, {0.1, 0.1, 0.1}}, .particleRadius = 0.01});
  for (int i = 0; i < 12; ++i) scene.world->stepSimulation(scalar(1.0 / 60.0), 1, scalar(1.0 / 60.0));
  const auto motions = scene.world->grains().grainMotions();
  return {motions.begin(), motions.end()};
}

// Debian's Bullet has no other scheduler; that it runs in pieces is what counts here.
TEST(TaskSchedulerExecutor, GivesTheBitsOfOneThread) {
  bullet_bridge::TaskSchedulerExecutor executor(*btGetSequentialTaskScheduler());
  const auto alone = pouredPile({}), scheduled = pouredPile({.executor = &executor});
  ASSERT_EQ(alone.size(), scheduled.size());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    ASSERT_EQ(alone[i].pose.position, scheduled[i].pose.position) << i;
    ASSERT_EQ(alone[i].velocity, scheduled[i].velocity) << i;
  }
}

}  // namespace
}  // namespace bridge_test
