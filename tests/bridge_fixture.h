// SPDX-License-Identifier: MIT
// A Bullet world with sand for the bridge's tests, and bodies that live as long as it needs them.
#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <vector>

#include "bullet_bridge/bullet_bridge.h"
#include "bullet_bridge/convert.h"

namespace bridge_test {

using bullet_bridge::fromBullet;
using granular::Vector3;

/// Relative rounding of what Bullet stores.
constexpr double kBulletRounding = std::numeric_limits<btScalar>::epsilon();

inline btScalar scalar(double value) {
  return static_cast<btScalar>(value);
}
inline btVector3 vec(double x, double y, double z) {
  return {scalar(x), scalar(y), scalar(z)};
}

inline btTransform at(double x, double y, double z) {
  return btTransform(btQuaternion::getIdentity(), vec(x, y, z));
}

/// Bullet's parts in the order it wants them, and a world of any kind.
template <class World>
struct Scene {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btMotionState>> motionStates;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  std::vector<std::unique_ptr<btTypedConstraint>> joints;
  std::unique_ptr<World> world = std::make_unique<World>(&dispatcher, &broadphase, &solver, &configuration);

  ~Scene() {
    for (auto& joint : joints) world->removeConstraint(joint.get());
  }

  template <class Shape, class... Arguments>
  Shape& shape(Arguments&&... arguments) {
    auto owned = std::make_unique<Shape>(std::forward<Arguments>(arguments)...);
    Shape& result = *owned;
    shapes.push_back(std::move(owned));
    return result;
  }

  btBoxShape& box(double halfX, double halfY, double halfZ) {
    return shape<btBoxShape>(vec(halfX, halfY, halfZ));
  }
  btSphereShape& sphere(double radius) { return shape<btSphereShape>(scalar(radius)); }

  /// Mass 0: static. In the world already.
  btRigidBody& body(double mass, btCollisionShape& form, const btTransform& pose,
                    btMotionState* state = nullptr) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) form.calculateLocalInertia(scalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(scalar(mass), state, &form, inertia);
    info.m_startWorldTransform = pose;
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world->addRigidBody(bodies.back().get());
    return *bodies.back();
  }
};

#ifdef BRIDGE_TEST_ATTACHED
/// Bullet's own world that a GranularLayer has joined, with the layer's calls at hand: the tests of the
/// coupling run through either door.
class AttachedWorld : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  template <class... Arguments>
  granular::BodyId coverBody(btRigidBody& body, Arguments&&... arguments) {
    return sand_.coverBody(body, std::forward<Arguments>(arguments)...);
  }
  granular::BodyId coverBody(btRigidBody& body, const bullet_bridge::CoverBodyDef& def) {
    return sand_.coverBody(body, def);
  }
  std::vector<granular::GrainId> addPile(const bullet_bridge::PileDef& def) { return sand_.addPile(def); }
  void uncoverBody(btRigidBody& body) { sand_.uncoverBody(body); }
  bool isCovered(const btRigidBody& body) const { return sand_.isCovered(body); }
  granular::BodyId bodyIdOf(const btRigidBody& body) const { return sand_.bodyIdOf(body); }
  granular::Pose massFrameOf(const btRigidBody& body) const { return sand_.massFrameOf(body); }
  void setPairOwner(const btRigidBody& a, const btRigidBody& b, bullet_bridge::PairOwner owner) {
    sand_.setPairOwner(a, b, owner);
  }
  void readContacts(std::vector<bullet_bridge::BodyContact>& contacts) { sand_.readContacts(contacts); }
  void setContactListener(bullet_bridge::ContactListener listener) {
    sand_.setContactListener(std::move(listener));
  }
  granular::Wrench contactForce(const btRigidBody& body) { return sand_.contactForce(body); }
  std::optional<bullet_bridge::GrainHit> castRay(const Vector3& from, const Vector3& to) const {
    return sand_.castRay(from, to);
  }
  void readGrainPoses(std::vector<granular::Pose>& poses) const { sand_.readGrainPoses(poses); }
  void showGrainsToQueries() { sand_.showGrainsToQueries(); }
  void hideGrainsFromQueries() { sand_.hideGrainsFromQueries(); }
  std::optional<granular::GrainId> grainOf(const btCollisionObject* object, int childIndex) const {
    return sand_.grainOf(object, childIndex);
  }
  granular::GranularSystem& grains() { return sand_.grains(); }
  const granular::StepReport& lastStep() const { return sand_.lastStep(); }
  void setBudget(const granular::WorkBudget& budget) { sand_.setBudget(budget); }

 private:
  bullet_bridge::GranularLayer sand_{*this};
};
using SandScene = Scene<AttachedWorld>;
#else
using SandScene = Scene<bullet_bridge::GranularDynamicsWorld>;
#endif
using BulletScene = Scene<btDiscreteDynamicsWorld>;

/// One particle at the body's centre: contact at a single point, with a known answer.
inline bullet_bridge::CoverBodyDef oneParticle(double radius) {
  granular::Covering covering;
  covering.positions = {Vector3::Zero()};
  covering.radii = {radius};
  return {.covering = covering};
}

inline Vector3 positionOf(const btRigidBody& body) {
  return fromBullet(body.getWorldTransform().getOrigin());
}
inline Vector3 velocityOf(const btRigidBody& body) {
  return fromBullet(body.getLinearVelocity());
}

}  // namespace bridge_test
