// SPDX-License-Identifier: MIT
// A layer that joins a world which is there: the worlds it joins, what it leaves as it was, what it notices.
// The coupling itself is tested through both doors (bridge_tests.cmake).
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <LinearMath/btThreads.h>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

using bullet_bridge::GranularLayer;

constexpr double kTick = 1.0 / 64.0;

template <class World>
void run(World& world, int ticks) {
  for (int i = 0; i < ticks; ++i) world.stepSimulation(scalar(kTick), 1, scalar(kTick));
}

/// A covered ball of 0.1 m and 1 kg falls from 1 m onto a covered slab whose top is y = 0.
template <class World>
struct Drop {
  World& world;
  btBoxShape slabShape{vec(0.5, 0.1, 0.5)};
  btSphereShape ballShape{scalar(0.1)};
  btRigidBody slab{{0, nullptr, &slabShape}};
  btRigidBody ball{{1, nullptr, &ballShape, vec(0.004, 0.004, 0.004)}};
  GranularLayer layer{world};

  explicit Drop(World& into) : world(into) {
    slab.setWorldTransform(at(0, -0.1, 0));
    ball.setWorldTransform(at(0, 0.5, 0));
    world.addRigidBody(&slab);
    world.addRigidBody(&ball);
    layer.coverBody(slab, {.particleRadius = 0.03});
    layer.coverBody(ball, {.particleRadius = 0.03});
  }
  ~Drop() {
    world.removeRigidBody(&ball);
    world.removeRigidBody(&slab);
  }

  /// It lies on the slab: level with it, or lower by what its particles sink between those of the slab, which
  /// is less than a diameter of 0.06 m as they would be through then.
  void expectAtRest() const {
    EXPECT_LT(positionOf(ball).y(), 0.101);
    EXPECT_GT(positionOf(ball).y(), 0.1 - 0.06);
    EXPECT_LT(velocityOf(ball).norm(), 0.1);
    EXPECT_GT(layer.lastStep().evaluations, 0);
  }
};

TEST(GranularLayer, JoinsADiscreteWorld) {
  BulletScene scene;
  Drop drop(*scene.world);
  run(*scene.world, 128);
  drop.expectAtRest();
}

TEST(GranularLayer, JoinsAMultiBodyWorldWhoseMultiBodiesStayBullets) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btMultiBody base(0, 1, vec(1, 1, 1), false, false);
  base.setBasePos(vec(5, 0, 0));
  base.finalizeMultiDof();
  world.addMultiBody(&base);
  {
    Drop drop(world);
    run(world, 128);
    drop.expectAtRest();
  }
  EXPECT_EQ(world.getConstraintSolver(), &solver);
  // Two seconds of free fall in ticks: g t (t + tick) / 2, less its damping of 4 % each second.
  EXPECT_LT(base.getBasePos().y(), -15.0);
  world.removeMultiBody(&base);
}

TEST(GranularLayer, JoinsASoftRigidWorldWhoseSoftBodiesStayBullets) {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  btSoftBody* rope = btSoftBodyHelpers::CreateRope(world.getWorldInfo(), vec(5, 0, 0), vec(6, 0, 0), 4,
                                                   1 /* one end fixed */);
  world.addSoftBody(rope);
  {
    Drop drop(world);
    run(world, 128);
    drop.expectAtRest();
  }
  EXPECT_LT(rope->m_nodes[5].m_x.y(), -0.1) << "the rope swings";
  world.removeSoftBody(rope);
  delete rope;
}

TEST(GranularLayer, JoinsAMultiThreadedWorld) {
  btITaskScheduler* before = btGetTaskScheduler();
  btSetTaskScheduler(btGetSequentialTaskScheduler());
  {
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btConstraintSolverPoolMt pool(2);
    btDiscreteDynamicsWorldMt world(&dispatcher, &broadphase, &pool, nullptr, &configuration);
    Drop drop(world);
    run(world, 128);
    drop.expectAtRest();
  }
  btSetTaskScheduler(before);
}

TEST(GranularLayer, MovesTheBallAsGranularDynamicsWorldDoes) {
  Scene<bullet_bridge::GranularDynamicsWorld> whole;
  btRigidBody& slab = whole.body(0, whole.box(0.5, 0.1, 0.5), at(0, -0.1, 0));
  btRigidBody& ball = whole.body(1, whole.sphere(0.1), at(0, 0.5, 0));
  whole.world->coverBody(slab, {.particleRadius = 0.03});
  whole.world->coverBody(ball, {.particleRadius = 0.03});
  BulletScene scene;
  Drop drop(*scene.world);
  for (int i = 0; i < 40; ++i) {  // past the first impact at 0.28 s
    run(*whole.world, 1);
    run(*scene.world, 1);
    EXPECT_LT((positionOf(ball) - positionOf(drop.ball)).norm(), 100 * kBulletRounding) << "tick " << i;
  }
}

TEST(GranularLayer, TakesAnyNumberOfSubStepsAsSingleTicks) {
  BulletScene one;
  BulletScene many;
  Drop single(*one.world);
  Drop frames(*many.world);
  for (int i = 0; i < 16; ++i) {
    run(*one.world, 4);
    many.world->stepSimulation(scalar(4 * kTick), 4, scalar(kTick));
    EXPECT_EQ(positionOf(single.ball), positionOf(frames.ball));
  }
}

std::vector<double> stackBits(bool withLayer) {
  BulletScene scene;
  std::optional<GranularLayer> layer;
  if (withLayer) layer.emplace(*scene.world);
  scene.body(0, scene.box(5, 0.5, 5), at(0, -0.5, 0));
  for (int i = 0; i < 5; ++i) scene.body(1, scene.box(0.5, 0.5, 0.5), at(0.03 * i, 0.5 + 1.01 * i, 0));
  std::vector<double> bits;
  for (int i = 0; i < 120; ++i) {
    run(*scene.world, 1);
    for (const auto& body : scene.bodies) {
      for (const double v : positionOf(*body)) bits.push_back(v);
    }
  }
  layer.reset();  // before the world
  return bits;
}

TEST(GranularLayer, WithoutSandLeavesBulletItsBits) {
  EXPECT_EQ(stackBits(true), stackBits(false));
}

TEST(GranularLayer, LeavesEverythingAsItWas) {
  BulletScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  ball.setCcdMotionThreshold(scalar(0.05));
  ball.setUserPointer(&scene);
  ball.setUserIndex(7);
  const int flags = ball.getFlags();
  const btVector3 inertia = ball.getInvInertiaDiagLocal();
  {
    GranularLayer layer(*scene.world);
    layer.coverBody(ball, {.particleRadius = 0.02});
    EXPECT_NE(scene.world->getConstraintSolver(), &scene.solver);
    run(*scene.world, 10);
  }
  EXPECT_EQ(scene.world->getConstraintSolver(), &scene.solver);
  EXPECT_EQ(ball.getCcdMotionThreshold(), scalar(0.05));
  EXPECT_EQ(ball.getUserPointer(), &scene);
  EXPECT_EQ(ball.getUserIndex(), 7);
  EXPECT_EQ(ball.getFlags(), flags);
  EXPECT_EQ(fromBullet(ball.getInvInertiaDiagLocal()), fromBullet(inertia));
  // From now on Bullet's own, in flight.
  const double speed = velocityOf(ball).y();
  run(*scene.world, 1);
  EXPECT_NEAR(velocityOf(ball).y(), speed - 10.0 * kTick, 1e-5);
}

TEST(GranularLayer, LeavesAWorldItsOwnSolver) {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, nullptr, &configuration);
  btConstraintSolver* solver = world.getConstraintSolver();
  {
    Drop drop(world);
    run(world, 32);
  }
  EXPECT_EQ(world.getConstraintSolver(), solver);
  run(world, 2);  // it is alive
}

TEST(GranularLayer, NoticesThatABodyHasGone) {
  BulletScene scene;
  GranularLayer layer(*scene.world);
  auto ball = std::make_unique<btRigidBody>(1, nullptr, &scene.sphere(0.1), vec(1, 1, 1));
  scene.world->addRigidBody(ball.get());
  layer.coverBody(*ball, oneParticle(0.1));
  run(*scene.world, 1);
  scene.world->removeRigidBody(ball.get());
  ball.reset();
  run(*scene.world, 1);
  EXPECT_EQ(layer.grains().bodyCount(), 0);
}

TEST(GranularLayer, TakesABodyThatWasAddedAgainForAnother) {
  BulletScene scene;
  GranularLayer layer(*scene.world);
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  layer.coverBody(ball, oneParticle(0.1));
  scene.world->removeRigidBody(&ball);
  scene.world->addRigidBody(&ball);
  run(*scene.world, 1);
  EXPECT_FALSE(layer.isCovered(ball));
}

TEST(GranularLayer, StandsBeforeASolverThatTheProgramPutThere) {
  BulletScene scene;
  btSequentialImpulseConstraintSolver other;
  {
    Drop drop(*scene.world);
    run(*scene.world, 8);
    scene.world->setConstraintSolver(&other);
    run(*scene.world, 1);
    EXPECT_EQ(drop.layer.solverChanges(), 1);
    run(*scene.world, 119);
    EXPECT_EQ(drop.layer.solverChanges(), 1);
    drop.expectAtRest();
  }
  EXPECT_EQ(scene.world->getConstraintSolver(), &other);
}

TEST(GranularLayer, IsOneForEachWorld) {
  BulletScene scene;
  GranularLayer layer(*scene.world);
  EXPECT_THROW(GranularLayer second(*scene.world), std::invalid_argument);
  Scene<bullet_bridge::GranularDynamicsWorld> whole;
  EXPECT_THROW(GranularLayer second(*whole.world), std::invalid_argument);
  EXPECT_EQ(whole.world->getConstraintSolver(), &whole.solver);
}

/// An action that was there before the layer's pushes at 3 N s each tick.
TEST(GranularLayer, KeepsTheImpulsesOfActionsBeforeIt) {
  struct Pusher : btActionInterface {
    btRigidBody* body = nullptr;
    void updateAction(btCollisionWorld*, btScalar) override { body->applyCentralImpulse(vec(3, 0, 0)); }
    void debugDraw(btIDebugDraw*) override {}
  } pusher;
  BulletScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(2, scene.sphere(0.1), at(0, 0, 0));
  pusher.body = &ball;
  scene.world->addAction(&pusher);
  {
    GranularLayer layer(*scene.world);
    layer.coverBody(ball, oneParticle(0.1));
    run(*scene.world, 10);
    EXPECT_NEAR(velocityOf(ball).x(), 10 * 3.0 / 2.0, 1e-5);
    // Each push moves it from the next tick on: 1.5 (0 + 1 + ... + 9) ticks.
    EXPECT_NEAR(positionOf(ball).x(), 1.5 * 45 * kTick, 1e-5);
  }
  scene.world->removeAction(&pusher);
}

}  // namespace
}  // namespace bridge_test
