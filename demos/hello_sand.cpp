// SPDX-License-Identifier: MIT
// The smallest program with sand: an ordinary Bullet program, and five lines. The README shows the text
// between the two marks, and tests/hello_sand_test.cpp runs it. [hello_sand]
#include <algorithm>
#include <cstdio>

#include "bullet_bridge/bullet_bridge.h"

int main() {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;

  btBoxShape slabShape(btVector3(0.375, 0.0625, 0.375));
  btRigidBody slab(0, nullptr, &slabShape);  // its upper face is at a height of 0.0625 m
  btSphereShape ballShape(0.0625);
  btVector3 inertia;
  ballShape.calculateLocalInertia(1, inertia);
  btDefaultMotionState start(btTransform(btQuaternion::getIdentity(), btVector3(0, 0.5, 0)));
  btRigidBody ball(1, &start, &ballShape, inertia);

  bullet_bridge::GranularDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.addRigidBody(&slab);
  world.addRigidBody(&ball);

  world.addPile({.region = {{-0.15, 0.0625, -0.15}, {0.15, 0.1625, 0.15}}, .particleRadius = 0.01});
  world.coverBody(slab);  // static: nothing is pushed back
  world.coverBody(ball);  // dynamic: grains push it, it pushes grains

  for (int i = 0; i < 120; ++i) world.stepSimulation(btScalar(1) / 60);

  double lowest = 1.0;
  for (const granular::RigidMotion& grain : world.grains().grainMotions())
    lowest = std::min(lowest, grain.pose.position.y());
  std::printf("ball at %.4f m, lowest grain at %.4f m\n", double(ball.getWorldTransform().getOrigin().y()),
              lowest);
  return 0;
}
// [hello_sand]
