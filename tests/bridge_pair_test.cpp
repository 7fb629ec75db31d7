// SPDX-License-Identifier: MIT
// Who meets whom. Two balls of radius 0.1 at a distance of 0.15 in free space: if anybody handles their
// contact they fly apart, else they stay. The particles' push and Bullet's differ: Bullet's leaves no
// velocity behind worth naming (its split impulse), the particles' overlap is elastic energy, let go no
// faster than the damper of the elastic foundation allows.
#include "bridge_fixture.h"

namespace bridge_test {
namespace {

struct Overlapping {
  SandScene scene;
  btRigidBody& a = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  btRigidBody& b = scene.body(1, scene.sphere(0.1), at(0.15, 0, 0));

  Overlapping() { scene.world->setGravity(vec(0, 0, 0)); }

  void cover() {
    scene.world->coverBody(a, oneParticle(0.1));
    scene.world->coverBody(b, oneParticle(0.1));
  }
  double run() {
    for (int i = 0; i < 4; ++i) scene.world->stepSimulation(scalar(1.0 / 64.0), 1, scalar(1.0 / 64.0));
    return (positionOf(b) - positionOf(a)).norm();
  }
  std::int64_t contactsInCore() { return scene.world->grains().measure().contacts; }
  int bulletContacts() {
    int count = 0;
    for (int i = 0; i < scene.dispatcher.getNumManifolds(); ++i) {
      count += scene.dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
    }
    return count;
  }
};

TEST(Pair, OfCoveredBodiesMeetsThroughParticles) {
  Overlapping pair;
  pair.cover();
  EXPECT_EQ(pair.contactsInCore(), 1);
  EXPECT_GT(pair.run(), 0.151);
}

TEST(Pair, OfCoveredBodiesStillShowsItsManifold) {
  Overlapping pair;
  pair.cover();
  pair.scene.world->stepSimulation(scalar(1.0 / 1024.0), 1, scalar(1.0 / 1024.0));
  EXPECT_EQ(pair.bulletContacts(), 1);
  for (int i = 0; i < pair.scene.dispatcher.getNumManifolds(); ++i) {
    EXPECT_EQ(pair.scene.dispatcher.getManifoldByIndexInternal(i)->getContactPoint(0).getAppliedImpulse(),
              0.0)
        << "Bullet's solver must not have seen it";
  }
}

TEST(Pair, OfACoveredAndAnUncoveredBodyIsBullets) {
  Overlapping pair;
  pair.scene.world->coverBody(pair.a, oneParticle(0.1));
  pair.a.setLinearVelocity(vec(1, 0, 0));
  pair.run();
  EXPECT_GT(velocityOf(pair.b).x(), 0.3) << "Bullet's contact carries the momentum over";
  EXPECT_NEAR(velocityOf(pair.a).x() + velocityOf(pair.b).x(), 1.0, 1e-5);
}

TEST(Pair, GivenToBulletIsBullets) {
  Overlapping pair;
  pair.cover();
  pair.scene.world->setPairOwner(pair.a, pair.b, bullet_bridge::PairOwner::Bullet);
  pair.a.setLinearVelocity(vec(1, 0, 0));
  pair.run();
  EXPECT_EQ(pair.scene.world->grains().contactImpulse(pair.scene.world->bodyIdOf(pair.a)).force,
            Vector3::Zero());
  EXPECT_GT(velocityOf(pair.b).x(), 0.3);
}

TEST(Pair, OnAnIgnoreListDoesNotMeet) {
  Overlapping pair;
  pair.cover();
  pair.a.setIgnoreCollisionCheck(&pair.b, true);
  EXPECT_EQ(pair.run(), double(scalar(0.15)));
  pair.a.setIgnoreCollisionCheck(&pair.b, false);
  EXPECT_GT(pair.run(), 0.151) << "off the list it meets again";
}

TEST(Pair, OfLinkedBodiesDoesNotMeet) {
  Overlapping pair;
  pair.cover();
  pair.scene.joints.push_back(
      std::make_unique<btPoint2PointConstraint>(pair.a, pair.b, vec(0.075, 0, 0), vec(-0.075, 0, 0)));
  pair.scene.world->addConstraint(pair.scene.joints[0].get(), true);
  EXPECT_NEAR(pair.run(), 0.15, 1e-6);
  EXPECT_EQ(pair.contactsInCore(), 0);
}

TEST(Pair, OfMasksThatExcludeEachOtherDoesNotMeet) {
  Overlapping pair;
  pair.scene.world->removeRigidBody(&pair.b);
  pair.scene.world->addRigidBody(&pair.b, 64, ~1);
  pair.cover();
  EXPECT_EQ(pair.run(), double(scalar(0.15)));
}

TEST(Pair, FilteredByTheProgramDoesNotMeet) {
  struct Nobody : btOverlapFilterCallback {
    bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override { return false; }
  } nobody;
  Overlapping pair;
  pair.scene.world->getPairCache()->setOverlapFilterCallback(&nobody);
  pair.cover();
  EXPECT_EQ(pair.run(), double(scalar(0.15)));
}

TEST(Pair, WithASensorDoesNotMeet) {
  Overlapping pair;
  pair.cover();
  pair.b.setCollisionFlags(pair.b.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
  EXPECT_EQ(pair.run(), double(scalar(0.15)));
}

TEST(Grains, ObeyBulletsMasks) {
  SandScene scene;
  scene.world->setGravity(vec(0, 0, 0));
  btRigidBody& ball = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  scene.world->removeRigidBody(&ball);
  scene.world->addRigidBody(&ball, 64, 64);  // does not want group 1, which grains are in
  granular::GranularSystem& sand = scene.world->grains();
  granular::GrainDef def;
  def.shape = sand.addGrainShape(granular::sphereShape(0.05));
  def.material = sand.addMaterial({});
  sand.addGrain(def);
  scene.world->coverBody(ball, oneParticle(0.1));
  EXPECT_EQ(sand.measure().contacts, 0);
}

TEST(Pair, OwnerNeedsTwoCoveredBodies) {
  Overlapping pair;
  EXPECT_THROW(pair.scene.world->setPairOwner(pair.a, pair.b, bullet_bridge::PairOwner::Bullet),
               std::invalid_argument);
}

}  // namespace
}  // namespace bridge_test
