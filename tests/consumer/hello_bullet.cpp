// SPDX-License-Identifier: MIT
// A ball falls onto a slab, in plain Bullet: before.
#include <btBulletDynamicsCommon.h>

#include <cstdio>

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

  for (int i = 0; i < 60; ++i) world.stepSimulation(btScalar(1) / 60);
  std::printf("%.4f\n", double(ball.getWorldTransform().getOrigin().y()));
  world.removeRigidBody(&ball);
  world.removeRigidBody(&slab);
}
