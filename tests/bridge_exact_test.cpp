// SPDX-License-Identifier: MIT
// Shapes met as they are, without particles: where their surfaces lie, and who handles which
// pair.
#include <cmath>
#include <functional>
#include <string>

#include "bridge_fixture.h"

namespace bridge_test {
namespace {

using bullet_bridge::CoverBodyDef;
using bullet_bridge::SurfaceContact;

constexpr double kTick = 1.0 / 128.0;

CoverBodyDef exact(std::optional<granular::MaterialId> material = std::nullopt) {
  return {.contact = SurfaceContact::Exact, .material = material};
}

granular::GrainId addBall(granular::GranularSystem& sand, const Vector3& position, double radius,
                          granular::MaterialId material) {
  granular::GrainDef def;
  def.shape = sand.addGrainShape(granular::sphereShape(radius));
  def.material = material;
  def.pose.position = position;
  return sand.addGrain(def);
}

granular::MaterialId elastic(granular::GranularSystem& sand) {
  return sand.addMaterial({.restitution = 1.0, .friction = 0.0});
}

std::string refusalOf(SandScene& scene, btRigidBody& body, const CoverBodyDef& def) {
  try {
    scene.world->coverBody(body, def);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

void makeKinematic(btRigidBody& body) {
  body.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
  body.setActivationState(DISABLE_DEACTIVATION);
}

// ---- planes

struct PlaneCase {
  btVector3 normal;
  double constant;
  btTransform pose;
};

class ExactPlane : public testing::TestWithParam<PlaneCase> {};

TEST_P(ExactPlane, TouchesAGrainByTheDepthThatBulletsPlaneSays) {
  const PlaneCase& c = GetParam();
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ground = scene.body(0, scene.shape<btStaticPlaneShape>(c.normal, scalar(c.constant)), c.pose);
  scene.world->coverBody(ground, exact());
  granular::GranularSystem& sand = scene.world->grains();
  // Bullet's plane: pose (x) with normal . x = constant; the grain sinks 1 mm into it, 0.4 m to the side.
  const Vector3 normal = fromBullet(c.normal.normalized());
  const granular::Pose pose = fromBullet(c.pose);
  const Vector3 aside = 0.4 * normal.unitOrthogonal();
  addBall(sand, pose.toWorld((c.constant + 0.05 - 0.001) * normal + aside), 0.05, sand.addMaterial({}));
  std::vector<granular::ContactView> contacts;
  sand.readContacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  const double rounding = 10.0 * kBulletRounding;
  EXPECT_NEAR(contacts[0].overlap, 0.001, rounding);
  const Vector3 force = contacts[0].ownerKind[0] == granular::OwnerKind::Grain ? contacts[0].force
                                                                               : Vector3(-contacts[0].force);
  EXPECT_LT((force.normalized() - pose.orientation * normal).norm(), rounding);
}

INSTANTIATE_TEST_SUITE_P(AnyNormalConstantAndPose, ExactPlane,
                         testing::Values(PlaneCase{btVector3(0, 1, 0), 0.0, at(0, 0, 0)},
                                         PlaneCase{btVector3(0, -1, 0), 0.3, at(0, 0, 0)},
                                         PlaneCase{btVector3(0, 0, 1), -0.5, at(1, 2, 3)},
                                         PlaneCase{btVector3(scalar(0.6), scalar(0.8), 0), 0.2, at(0, -1, 0)},
                                         PlaneCase{btVector3(1, 2, -3), 0.7,
                                                   btTransform(btQuaternion(btVector3(0, 0, 1), scalar(0.5)),
                                                               vec(0.1, 0, -2))}));

TEST(ExactPlane, MovedByHandIsElsewhereAtOnce) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ground =
      scene.body(0, scene.shape<btStaticPlaneShape>(vec(1, 0, 0), scalar(0.5)), at(0, 0, 0));
  scene.world->coverBody(ground, exact());
  granular::GranularSystem& sand = scene.world->grains();
  addBall(sand, {1.0, 0, 0}, 0.05, sand.addMaterial({}));
  EXPECT_EQ(sand.measure().contacts, 0);
  ground.setWorldTransform(at(0.48, 0, 0));  // its surface to x = 0.98
  scene.world->stepSimulation(scalar(1e-6), 1, scalar(1e-6));
  EXPECT_EQ(sand.measure().contacts, 1);
}

TEST(ExactPlane, PushedIntoAGrainSendsItOffWithTwiceItsSpeed) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btDefaultMotionState state(at(0, 0, 0));
  btRigidBody& wall =
      scene.body(0, scene.shape<btStaticPlaneShape>(vec(1, 0, 0), scalar(0.2)), at(0, 0, 0), &state);
  makeKinematic(wall);
  granular::GranularSystem& sand = scene.world->grains();
  const granular::MaterialId steel = elastic(sand);
  scene.world->coverBody(wall, exact(steel));
  const granular::GrainId grain = addBall(sand, {0.3, 0, 0}, 0.05, steel);
  for (int i = 1; i <= 24; ++i) {
    state.setWorldTransform(at(2.0 * i * kTick, 0, 0));
    scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  }
  EXPECT_NEAR(sand.grainMotions()[grain.index].velocity.x(), 4.0, 0.01);
}

TEST(ExactPlane, ThatTurnsIsAfterEachTickWhereBulletHasIt) {
  SandScene scene;
  btDefaultMotionState state(at(0, 0, 0));
  btRigidBody& wall =
      scene.body(0, scene.shape<btStaticPlaneShape>(vec(1, 0, 0), scalar(0.5)), at(0, 0, 0), &state);
  makeKinematic(wall);
  const granular::BodyId id = scene.world->coverBody(wall, exact());
  const double angle = 0.3;
  state.setWorldTransform(btTransform(btQuaternion(btVector3(0, 0, 1), scalar(angle)), vec(0, 0, 0)));
  scene.world->stepSimulation(scalar(3 * kTick), 3, scalar(kTick));
  const granular::RigidMotion motion = scene.world->grains().bodyMotion(id);
  const Vector3 normal(std::cos(angle), std::sin(angle), 0);
  EXPECT_LT((motion.pose.orientation * Vector3::UnitY() - normal).norm(), 10.0 * kBulletRounding);
  EXPECT_LT((motion.pose.position - 0.5 * normal).norm(), 10.0 * kBulletRounding);
  // In the last tick its foot went along the chord of 0.1 rad on a circle of 0.5 m.
  EXPECT_NEAR(motion.velocity.norm(), 2.0 * 0.5 * std::sin(0.05) / kTick, 1e-4);
}

TEST(ExactPlane, MadeDynamicStandsWhereBulletPutsIt) {
  SandScene scene;
  btRigidBody& wall = scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0.5)), at(0, 0, 0));
  scene.world->coverBody(wall, exact());
  wall.setCollisionFlags(0);
  wall.setMassProps(1, vec(1, 1, 1));
  scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  const auto& sand = scene.world->grains();
  EXPECT_EQ(sand.bodyMotionType(scene.world->bodyIdOf(wall)), granular::BodyMotion::Static);
}

TEST(ExactPlane, IsMetByTheParticlesOfADynamicBody) {
  SandScene scene;
  btRigidBody& ground = scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0)), at(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0.1, 0));
  scene.world->coverBody(ground, exact());
  scene.world->coverBody(ball, oneParticle(0.1));
  for (int i = 0; i < 64; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_EQ(scene.world->grains().measure().contacts, 1);
  EXPECT_NEAR(positionOf(ball).y(), 0.1, 0.001);
}

TEST(ExactPlane, OfADynamicBodyIsRefused) {
  SandScene scene;
  btRigidBody& slab = scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0)), at(0, 0, 0));
  slab.setCollisionFlags(0);
  slab.setMassProps(1, vec(1, 1, 1));
  EXPECT_EQ(refusalOf(scene, slab, exact()),
            "coverBody: the body of an exact plane is dynamic; it must be static or kinematic");
}

// ---- spheres

TEST(ExactSphere, MeetsGrainsAndSharesTheMomentum) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  ball.setLinearVelocity(vec(2, 0, 0));
  granular::GranularSystem& sand = scene.world->grains();
  const granular::MaterialId steel = elastic(sand);
  scene.world->coverBody(ball, exact(steel));
  const granular::GrainId grain = addBall(sand, {0.17, 0, 0}, 0.05, steel);
  for (int i = 0; i < 16; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  // A head-on elastic impact: v1 = (m1 - m2) / (m1 + m2) v, v2 = 2 m1 / (m1 + m2) v.
  const double m = sand.massOf(grain);
  EXPECT_NEAR(velocityOf(ball).x(), (1.0 - m) / (1.0 + m) * 2.0, 1e-3);
  EXPECT_NEAR(sand.grainMotions()[grain.index].velocity.x(), 4.0 / (1.0 + m), 1e-3);
}

TEST(ExactSphere, FallsAsTheCoreSaysAndTakesImpulses) {
  SandScene scene;
  scene.world->setGravity(vec(0, -10, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, exact());
  ball.applyCentralImpulse(vec(3, 0, 0));
  for (int i = 0; i < 64; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_LT((positionOf(ball) - Vector3(1.5, -0.5 * 10 * 0.25, 0)).norm(), 20.0 * kBulletRounding);
}

enum class Partner { ExactSphere, ExactPlane, StaticParticles };

class ExactSpherePair : public testing::TestWithParam<Partner> {};

/// The core has no contact for these pairs: if Bullet's were silenced the ball would fall through.
TEST_P(ExactSpherePair, IsBullets) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0.1, 0));
  scene.world->coverBody(ball, exact());
  switch (GetParam()) {
    case Partner::ExactSphere:
      scene.world->coverBody(scene.body(0, scene.sphere(0.5), at(0, -0.5, 0)), exact());
      break;
    case Partner::ExactPlane:
      scene.world->coverBody(
          scene.body(0, scene.shape<btStaticPlaneShape>(vec(0, 1, 0), scalar(0)), at(0, 0, 0)), exact());
      break;
    case Partner::StaticParticles:
      scene.world->coverBody(scene.body(0, scene.sphere(0.5), at(0, -0.5, 0)), oneParticle(0.5));
      break;
  }
  for (int i = 0; i < 64; ++i) scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  EXPECT_NEAR(positionOf(ball).y(), 0.1, 0.005);
  EXPECT_EQ(scene.world->grains().measure().contacts, 0);
}

INSTANTIATE_TEST_SUITE_P(WithoutMovingParticles, ExactSpherePair,
                         testing::Values(Partner::ExactSphere, Partner::ExactPlane,
                                         Partner::StaticParticles));

TEST(ExactSphere, AndTheParticlesOfADynamicBodyMeetInTheCore) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& a = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  btRigidBody& b = scene.body(1, scene.sphere(0.1), at(0.199, 0, 0));
  scene.world->coverBody(a, exact());
  scene.world->coverBody(b, oneParticle(0.1));
  EXPECT_EQ(scene.world->grains().measure().contacts, 1);
  scene.world->stepSimulation(scalar(1e-4), 1, scalar(1e-4));
  for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i) {
    const btPersistentManifold& manifold = *scene.dispatcher.getManifoldByIndexInternal(i);
    for (int k = 0; k < manifold.getNumContacts(); ++k)
      EXPECT_EQ(manifold.getContactPoint(k).getAppliedImpulse(), 0.0) << "Bullet's solver must not see it";
  }
}

TEST(ExactSphere, KeepsItsSurfaceWhenItsMassChangesToNone) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->coverBody(ball, exact());
  ball.setMassProps(0, vec(0, 0, 0));
  scene.world->stepSimulation(scalar(kTick), 1, scalar(kTick));
  granular::GranularSystem& sand = scene.world->grains();
  addBall(sand, positionOf(ball) + Vector3(0, 0.149, 0), 0.05, sand.addMaterial({}));
  EXPECT_EQ(sand.measure().contacts, 1);
}

// ---- refusals, and what the world hands over

TEST(ExactContact, OfAShapeWithoutAnInsideIsRefusedByNameWithWhatCanBeHad) {
  SandScene scene;
  btTriangleMesh triangle;
  triangle.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0));
  btRigidBody& sheet = scene.body(0, scene.shape<btBvhTriangleMeshShape>(&triangle, true), at(0, 0, 0));
  EXPECT_EQ(
      refusalOf(scene, sheet, exact()),
      "CoverBodyDef.contact is Exact for a collision shape BVHTRIANGLEMESH without an inside; exact contact "
      "is for planes and for shapes of one closed part: give SurfaceContact::Particles");
  EXPECT_FALSE(scene.world->isCovered(sheet));
  btRigidBody& box = scene.body(0, scene.box(1, 1, 1), at(0, 0, 0));
  CoverBodyDef def = exact();
  def.exactSpacing = -1.0;
  EXPECT_THROW(scene.world->coverBody(box, def), std::invalid_argument);
}

/// Where a ball touches each shape, by what Bullet's shape means.
struct ShapeCase {
  const char* name;
  std::function<btCollisionShape&(SandScene&)> make;
  Vector3 point, normal;  // of the surface, in the shape's frame
};

class ExactShapes : public testing::TestWithParam<ShapeCase> {};

TEST_P(ExactShapes, AreTouchedWhereBulletsShapeIs) {
  const ShapeCase& c = GetParam();
  for (const double mass : {0.0, 2.0}) {
    SandScene scene;
    scene.world->setGravity(vec(0, 0, 0));
    btTransform pose = at(1, 2, 3);
    pose.setRotation(btQuaternion(vec(1, 2, 3).normalized(), scalar(0.8)));
    btRigidBody& body = scene.body(mass, c.make(scene), pose);
    CoverBodyDef def = exact();
    def.exactSpacing = 0.02;
    scene.world->coverBody(body, def);
    granular::GranularSystem& sand = scene.world->grains();
    const double radius = 0.05, depth = 0.002;
    addBall(sand, fromBullet(pose).toWorld(c.point + (radius - depth) * c.normal), radius,
            sand.addMaterial({}));
    std::vector<granular::ContactView> contacts;
    sand.readContacts(contacts);
    ASSERT_EQ(contacts.size(), 1u) << c.name;
    EXPECT_NEAR(contacts[0].overlap, depth, 10.0 * kBulletRounding) << c.name;
    const Vector3 force = contacts[0].ownerKind[0] == granular::OwnerKind::Grain
                              ? contacts[0].force
                              : Vector3(-contacts[0].force);
    EXPECT_LT((force.normalized() - fromBullet(pose).orientation * c.normal).norm(), 1e-4) << c.name;
  }
}

btCollisionShape& tetrahedronHull(SandScene& scene) {
  auto& hull = scene.shape<btConvexHullShape>();
  for (const btVector3& corner : {vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1), vec(0, 0, 0)})
    hull.addPoint(corner);
  return hull;
}

const Vector3 kDiagonal = Vector3::Ones().normalized();

INSTANTIATE_TEST_SUITE_P(
    Bullet, ExactShapes,
    testing::Values(ShapeCase{"box face",
                              [](SandScene& s) -> btCollisionShape& { return s.box(0.2, 0.3, 0.4); },
                              {0.1, 0.3, 0.2},
                              Vector3::UnitY()},
                    ShapeCase{"box corner",
                              [](SandScene& s) -> btCollisionShape& { return s.box(0.2, 0.3, 0.4); },
                              {0.2, 0.3, 0.4},
                              kDiagonal},
                    ShapeCase{"capsule along x",
                              [](SandScene& s) -> btCollisionShape& {
                                return s.shape<btCapsuleShapeX>(scalar(0.2), scalar(0.6));
                              },
                              {0.5, 0, 0},
                              Vector3::UnitX()},
                    ShapeCase{"capsule along z, side",
                              [](SandScene& s) -> btCollisionShape& {
                                return s.shape<btCapsuleShapeZ>(scalar(0.2), scalar(0.6));
                              },
                              {0, 0.2, 0.25},
                              Vector3::UnitY()},
                    ShapeCase{"cylinder along z, end",
                              [](SandScene& s) -> btCollisionShape& {
                                return s.shape<btCylinderShapeZ>(vec(0.2, 0.2, 0.5));
                              },
                              {0.1, 0.1, 0.5},
                              Vector3::UnitZ()},
                    ShapeCase{"hull, slope", tetrahedronHull, Vector3::Constant(1.0 / 3.0), kDiagonal}),
    [](const auto& test) {
      std::string name = test.param.name;
      std::erase_if(name, [](char letter) { return letter == ' ' || letter == ','; });
      return name;
    });

TEST(ExactContact, RefusesSettingsOfParticles) {
  SandScene scene;
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  CoverBodyDef def = exact();
  def.particleRadius = 0.01;
  EXPECT_EQ(refusalOf(scene, ball, def),
            "CoverBodyDef.particleRadius is given; it must be left out where CoverBodyDef.contact is Exact");
}

TEST(CoverBody, PassesOnWhatSurfaceEachParticleStandsFor) {
  SandScene scene;
  btRigidBody& box = scene.body(1, scene.box(0.1, 0.1, 0.1), at(0, 0, 0));
  const granular::BodyId id = scene.world->coverBody(box, {.particleRadius = 0.02});
  const granular::Covering& covering = scene.world->grains().covering(id);
  ASSERT_FALSE(covering.pieces.empty());
  // Both sides of a cube of 0.2 m show 2 x 0.04 m^2 along each axis.
  double shown = 0.0;
  for (const granular::SurfacePiece& piece : covering.pieces) shown += std::abs(piece.areaVector().x());
  EXPECT_NEAR(shown, 0.08, 1e-3);
}

}  // namespace
}  // namespace bridge_test
