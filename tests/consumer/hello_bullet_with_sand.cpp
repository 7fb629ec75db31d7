// SPDX-License-Identifier: MIT
// A ball falls onto a slab with sand on it: after. Five lines are new.
#include <btBulletDynamicsCommon.h>

#include <cstdio>

#include "bullet_bridge/bullet_bridge.h"

int main() {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

  btBoxShape slabShape(btVector3(btScalar(0.3), btScalar(0.1), btScalar(0.3)));
  btRigidBody slab(0, nullptr, &slabShape);
  slab.getWorldTransform().setOrigin(btVector3(0, btScalar(-0.1), 0));
  world.addRigidBody(&slab);

  btSphereShape ballShape(btScalar(0.05));
  btVector3 inertia;
  ballShape.calculateLocalInertia(1, inertia);
  btRigidBody ball(1, nullptr, &ballShape, inertia);
  ball.getWorldTransform().setOrigin(btVector3(0, btScalar(0.3), 0));
  world.addRigidBody(&ball);

  bullet_bridge::GranularLayer sand(world);
  sand.addPile({.region = {{-0.1, 0.01, -0.1}, {0.1, 0.08, 0.1}}, .particleRadius = 0.01});
  sand.coverBody(slab);
  sand.coverBody(ball);

  for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(1) / 60);
  std::printf("%.4f\n", double(ball.getWorldTransform().getOrigin().y()));
  world.removeRigidBody(&ball);
  world.removeRigidBody(&slab);
}
