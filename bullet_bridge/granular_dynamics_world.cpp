// SPDX-License-Identifier: MIT
// The world's tick is Bullet's own list of stages (btDiscreteDynamicsWorld.cpp,
// internalSingleStepSimulation, 3.24) with the layer's stages set between them.
#include "bullet_bridge/granular_dynamics_world.h"

#include "bullet_bridge/convert.h"
#include "bullet_bridge/debug_draw.h"
#include "bullet_bridge/layer.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

GranularDynamicsWorld::GranularDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* pairCache,
                                             btConstraintSolver* constraintSolver,
                                             btCollisionConfiguration* collisionConfiguration,
                                             const LayerDef& def)
    : btDiscreteDynamicsWorld(dispatcher, pairCache, constraintSolver, collisionConfiguration),
      LayerDoor(std::make_unique<detail::Layer>(*this, def, true)) {}

GranularDynamicsWorld::~GranularDynamicsWorld() {
  layer_->hideGrainsFromQueries();
}

int GranularDynamicsWorld::stepSimulation(btScalar timeStep, int maxSubSteps, btScalar fixedTimeStep) {
  layer_->beginFrame();
  return btDiscreteDynamicsWorld::stepSimulation(timeStep, maxSubSteps, fixedTimeStep);
}

void GranularDynamicsWorld::setGravity(const btVector3& gravity) {
  layer_->system().setGravity(fromBullet(gravity));  // first: it refuses what is not finite
  btDiscreteDynamicsWorld::setGravity(gravity);
}

void GranularDynamicsWorld::removeRigidBody(btRigidBody* body) {
  if (layer_->isCovered(*body)) layer_->uncover(*body);
  btDiscreteDynamicsWorld::removeRigidBody(body);
}

void GranularDynamicsWorld::saveKinematicState(btScalar timeStep) {
  btDiscreteDynamicsWorld::saveKinematicState(timeStep);
  layer_->beginKinematicFrame(timeStep);
}

void GranularDynamicsWorld::internalSingleStepSimulation(btScalar timeStep) {
  if (layer_->isIdle()) {
    btDiscreteDynamicsWorld::internalSingleStepSimulation(timeStep);
    return;
  }
  if (m_internalPreTickCallback) (*m_internalPreTickCallback)(this, timeStep);

  predictUnconstraintMotion(timeStep);  // Bullet: damping
  layer_->takeChanges(timeStep);        // what the program did to covered bodies since the last tick
  layer_->keepAwake(timeStep);          // nothing sleeps above moving sand

  btDispatcherInfo& info = getDispatchInfo();
  info.m_timeStep = timeStep;
  info.m_stepCount = 0;
  info.m_debugDraw = getDebugDrawer();
  layer_->switchSweepsOff();  // continuous collision would cut the core's motion short
  createPredictiveContacts(timeStep);
  performDiscreteCollisionDetection();
  calculateSimulationIslands();

  layer_->step(timeStep);             // grains and covered bodies together, from (x0, v0) to (x1, v1)
  layer_->offerMeanMotion(timeStep);  // so that joints and foreign contacts see (x1 - x0) / dt
  layer_->silenceOwnPairs();
  getSolverInfo().m_timeStep = timeStep;
  solveConstraints(getSolverInfo());
  layer_->unsilenceOwnPairs();
  layer_->takeCorrections();  // what joints and foreign contacts changed
  integrateTransforms(timeStep);
  layer_->switchSweepsOn();
  layer_->store(timeStep);  // covered bodies: (x1, v1) plus the corrections, not Bullet's integration
  layer_->tellWhatCame();

  updateActions(timeStep);
  updateActivationState(timeStep);
  if (m_internalTickCallback) (*m_internalTickCallback)(this, timeStep);
}

void GranularDynamicsWorld::debugDrawWorld() {
  if (btIDebugDraw* drawer = getDebugDrawer())
    drawSand(*drawer, layer_->system(), layer_->drawnParticleLimit());
  btDiscreteDynamicsWorld::debugDrawWorld();  // flushes the drawer
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
