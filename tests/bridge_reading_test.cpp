// SPDX-License-Identifier: MIT
// What a program can know of the sand: rays, contact tests, contacts, forces, drawing, profile, poses between
// ticks.
#include <LinearMath/btIDebugDraw.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

using bullet_bridge::BodyContact;
using bullet_bridge::GrainHit;

constexpr double kTick = 1.0 / 128.0;

granular::GrainId addBall(granular::GranularSystem& sand, const Vector3& position, double radius) {
  const auto shape = sand.addGrainShape(granular::sphereShape(radius));
  return sand.addGrain({.shape = shape, .material = sand.addMaterial({}), .pose = {.position = position}});
}

/// Two grains of radius 0.1 on the x axis, no gravity.
struct TwoGrains {
  SandScene scene;
  granular::GrainId near;
  granular::GrainId far;

  TwoGrains() {
    scene.world->setGravity(vec(0, 0, 0));
    near = addBall(scene.world->grains(), {1, 0, 0}, 0.1);
    far = addBall(scene.world->grains(), {2, 0, 0}, 0.1);
  }
};

TEST(CastRay, MeetsTheFirstGrainAtItsSurface) {
  TwoGrains two;
  const auto hit = two.scene.world->castRay({0, 0.06, 0}, {4, 0.06, 0});
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->grain, two.near);
  EXPECT_NEAR(hit->point.x(), 1.0 - 0.08, 1e-12);  // 0.06, 0.08, 0.1
  EXPECT_NEAR(hit->fraction, 0.92 / 4.0, 1e-12);
  EXPECT_LT((hit->normal - Vector3(-0.8, 0.6, 0)).norm(), 1e-12);
}

TEST(CastRay, MissesWhatIsBesideBehindOrBeyond) {
  TwoGrains two;
  EXPECT_FALSE(two.scene.world->castRay({0, 0.11, 0}, {4, 0.11, 0}));
  EXPECT_FALSE(two.scene.world->castRay({0, 0, 0}, {-4, 0, 0}));
  EXPECT_FALSE(two.scene.world->castRay({0, 0, 0}, {0.89, 0, 0}));
  EXPECT_THROW(two.scene.world->castRay({0, 0, 0}, {std::nan(""), 0, 0}), std::invalid_argument);
}

/// Bullet's convex cast ends after 32 iterations, in float also at a squared distance of 1e-4 m^2
/// (btConvexCast::CastResult).
constexpr double kCastReach = sizeof(btScalar) == sizeof(float) ? 0.01 : 1e-3;

/// Keeps which child was hit.
struct ChildRay : btCollisionWorld::ClosestRayResultCallback {
  using ClosestRayResultCallback::ClosestRayResultCallback;
  int child = -1;
  btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool inWorldSpace) override {
    if (result.m_localShapeInfo) child = result.m_localShapeInfo->m_triangleIndex;
    return ClosestRayResultCallback::addSingleResult(result, inWorldSpace);
  }
};

TEST(GrainQueries, LetBulletsRayTestMeetTheGrainThatTheOwnRayMeets) {
  TwoGrains two;
  two.scene.world->showGrainsToQueries();
  ChildRay ray(vec(0, 0.06, 0), vec(4, 0.06, 0));
  two.scene.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
  ASSERT_TRUE(ray.hasHit());
  EXPECT_NEAR(ray.m_hitPointWorld.x(), 0.92, kCastReach);
  EXPECT_EQ(two.scene.world->grainOf(ray.m_collisionObject, ray.child), two.near);
}

TEST(GrainQueries, FollowGrainsThatMoveComeAndGo) {
  TwoGrains two;
  two.scene.world->showGrainsToQueries();
  granular::GranularSystem& sand = two.scene.world->grains();
  const auto hitX = [&] {
    ChildRay ray(vec(0, 0, 0), vec(4, 0, 0));
    two.scene.world->rayTest(ray.m_rayFromWorld, ray.m_rayToWorld, ray);
    return ray.hasHit() ? double(ray.m_hitPointWorld.x()) : -1.0;
  };
  granular::RigidMotion moved = sand.grainMotions()[two.near.index];
  moved.pose.position.x() = 0.5;
  sand.setGrainMotion(two.near, moved);
  two.scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_NEAR(hitX(), 0.4, kCastReach);
  sand.removeGrain(two.near);
  two.scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_NEAR(hitX(), 1.9, kCastReach);
  two.scene.world->hideGrainsFromQueries();
  EXPECT_EQ(hitX(), -1.0);
  EXPECT_EQ(two.scene.world->getNumCollisionObjects(), 0);
}

TEST(GrainQueries, LetBulletsContactTestMeetGrains) {
  TwoGrains two;
  two.scene.world->showGrainsToQueries();
  struct Counter : btCollisionWorld::ContactResultCallback {
    std::set<int> children;
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* a, int, int indexA,
                             const btCollisionObjectWrapper*, int, int indexB) override {
      if (point.getDistance() <= 0)
        children.insert(a->getCollisionObject()->isStaticObject() ? indexA : indexB);
      return 0;
    }
  } counter;
  btSphereShape probe(scalar(0.2));
  btCollisionObject object;
  object.setCollisionShape(&probe);
  object.setWorldTransform(at(0.75, 0, 0));  // reaches 0.05 into the near grain
  two.scene.world->contactTest(&object, counter);
  EXPECT_EQ(counter.children.size(), 1u);
}

TEST(GrainQueries, CollideWithNothing) {
  SandScene with;
  SandScene without;
  std::vector<Vector3> ends;
  for (SandScene* scene : {&with, &without}) {
    addBall(scene->world->grains(), {0, -1, 0}, 0.4);
    btRigidBody& box = scene->body(1, scene->box(0.2, 0.2, 0.2), at(0, 0, 0));
    if (scene == &with) scene->world->showGrainsToQueries();
    for (int i = 0; i < 64; ++i) scene->world->stepSimulation(scalar(kTick), 1, scalar(kTick));
    ends.push_back(positionOf(box));
  }
  EXPECT_EQ(ends[0], ends[1]);
}

/// A chassis of 400 kg on four ray-cast wheels, each over a grain of 0.7 m on the ground.
TEST(GrainQueries, CarryARaycastVehicle) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ground = scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0)), at(0, 0, 0));
  scene.world->coverBody(ground, {.contact = bullet_bridge::SurfaceContact::Exact});
  btRigidBody& chassis = scene.body(400, scene.box(0.8, 0.2, 1.5), at(0, 1.6, 0));
  chassis.setActivationState(DISABLE_DEACTIVATION);
  btRaycastVehicle::btVehicleTuning tuning;
  tuning.m_suspensionStiffness = 50;
  tuning.m_suspensionDamping = scalar(2.3);
  tuning.m_suspensionCompression = scalar(4.4);
  btDefaultVehicleRaycaster raycaster(scene.world.get());
  btRaycastVehicle vehicle(tuning, &chassis, &raycaster);
  vehicle.setCoordinateSystem(0, 1, 2);
  for (const double x : {-0.7, 0.7}) {
    for (const double z : {-1.2, 1.2}) {
      addBall(scene.world->grains(), {x, 0.35, z}, 0.35);
      vehicle.addWheel(vec(x, -0.1, z), vec(0, -1, 0), vec(-1, 0, 0), scalar(0.5), scalar(0.3), tuning,
                       z > 0);
    }
  }
  scene.world->addAction(&vehicle);
  scene.world->showGrainsToQueries();
  for (int i = 0; i < 256; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  // Grain 0.7, wheel 0.3, spring 0.5 less 4000 N / (4 x 50 x 400 N/m) = 0.05, connection 0.1 below the
  // middle.
  EXPECT_NEAR(positionOf(chassis).y(), 0.7 + 0.3 + 0.45 + 0.1, 0.03);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(vehicle.getWheelInfo(i).m_raycastInfo.m_isInContact);
  scene.world->removeAction(&vehicle);
}

/// A ball of 2 kg at rest on a covered slab: one particle each, so one contact.
struct BallOnParticle {
  SandScene scene;
  btRigidBody& slab = scene.body(0, scene.sphere(0.1), at(0, 0, 0));
  btRigidBody& ball = scene.body(2, scene.sphere(0.1), at(0, 0.2, 0));

  BallOnParticle() {
    scene.world->setGravity(vec(0, -10, 0));
    scene.world->coverBody(slab, oneParticle(0.1));
    scene.world->coverBody(ball, oneParticle(0.1));
    for (int i = 0; i < 256; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  }
};

TEST(ContactForce, CarriesTheWeight) {
  BallOnParticle pair;
  EXPECT_NEAR(pair.scene.world->contactForce(pair.ball).force.y(), 20.0, 0.02);
  EXPECT_NEAR(pair.scene.world->contactForce(pair.slab).force.y(), -20.0, 0.02);
  btRigidBody& other = pair.scene.body(1, pair.scene.sphere(0.1), at(5, 0, 0));
  EXPECT_THROW(pair.scene.world->contactForce(other), std::invalid_argument);
}

TEST(ReadContacts, NamesTheBodiesAndTheForce) {
  BallOnParticle pair;
  std::vector<BodyContact> contacts;
  pair.scene.world->readContacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  const bool ballFirst = contacts[0].body == &pair.ball;
  EXPECT_EQ(contacts[0].other, ballFirst ? &pair.slab : &pair.ball);
  EXPECT_EQ(contacts[0].grain.index, -1);
  EXPECT_NEAR(contacts[0].force.y(), ballFirst ? 20.0 : -20.0, 0.02);
  EXPECT_NEAR(contacts[0].point.y(), 0.1, 1e-3);
}

TEST(ContactListener, IsToldAfterEachTick) {
  BallOnParticle pair;
  int calls = 0;
  std::size_t contacts = 0;
  pair.scene.world->setContactListener([&](std::span<const BodyContact> told) {
    ++calls;
    contacts += told.size();
  });
  pair.scene.world->stepSimulation(scalar(3 * kTick), 3, scalar(kTick));
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(contacts, 3u);
  pair.scene.world->setContactListener({});
  pair.scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_EQ(calls, 3);
}

/// One tick is made of 1.5 asked for. Bullet shows a tick late by default, else half a tick ahead of the
/// last.
TEST(ReadGrainPoses, AreOfTheMomentThatMotionStatesAreToldFor) {
  for (const bool latency : {true, false}) {
    TwoGrains two;
    two.scene.world->setLatencyMotionStateInterpolation(latency);
    granular::GranularSystem& sand = two.scene.world->grains();
    granular::RigidMotion motion = sand.grainMotions()[two.near.index];
    motion.velocity = {0, 3, 0};
    sand.setGrainMotion(two.near, motion);
    two.scene.world->stepSimulation(scalar(1.5 * kTick), 4, scalar(kTick));
    std::vector<granular::Pose> poses;
    two.scene.world->readGrainPoses(poses);
    ASSERT_EQ(poses.size(), 2u);
    EXPECT_NEAR(poses[0].position.y(), 3.0 * (latency ? 0.5 : 1.5) * kTick, 1e-6);
  }
}

class ContactDrawer : public btIDebugDraw {
 public:
  void drawLine(const btVector3&, const btVector3&, const btVector3&) override {}
  void drawContactPoint(const btVector3& point, const btVector3& normal, btScalar, int,
                        const btVector3&) override {
    points.push_back(fromBullet(point));
    normals.push_back(fromBullet(normal));
  }
  void reportErrorWarning(const char*) override {}
  void draw3dText(const btVector3&, const char*) override {}
  void setDebugMode(int mode) override { mode_ = mode; }
  int getDebugMode() const override { return mode_; }
  std::vector<Vector3> points;
  std::vector<Vector3> normals;

 private:
  int mode_ = DBG_DrawContactPoints | DBG_DrawAabb;
};

TEST(DebugDraw, ShowsContactsWithTheirNormals) {
  BallOnParticle pair;
  ContactDrawer drawer;
  pair.scene.world->setDebugDrawer(&drawer);
  pair.scene.world->debugDrawWorld();
  // Bullet draws its own manifold of the two as well.
  const auto ours = std::count_if(drawer.points.begin(), drawer.points.end(),
                                  [](const Vector3& p) { return std::abs(p.y() - 0.1) < 1e-3; });
  EXPECT_GE(ours, 1);
  for (const Vector3& normal : drawer.normals) EXPECT_NEAR(std::abs(normal.y()), 1.0, 1e-6);
  pair.scene.world->setDebugDrawer(nullptr);
}

std::set<std::string>& zones() {
  static std::set<std::string> names;
  return names;
}

TEST(Profile, ShowsTheStagesOfTheSandInBulletsProfiler) {
  btEnterProfileZoneFunc* enter = btGetCurrentEnterProfileZoneFunc();
  btSetCustomEnterProfileZoneFunc([](const char* name) { zones().insert(name); });
  TwoGrains two;
  two.scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  btSetCustomEnterProfileZoneFunc(enter);
  EXPECT_TRUE(zones().contains("granular: integrate grains and bodies"));
  EXPECT_TRUE(zones().contains("granular: store"));
}

}  // namespace
}  // namespace bridge_test
