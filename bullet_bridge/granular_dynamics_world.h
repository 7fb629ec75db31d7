// SPDX-License-Identifier: MIT
// A btDiscreteDynamicsWorld with sand in it. Bodies that are covered with particles are integrated together
// with the grains by granular::GranularSystem, which takes the place of Bullet's contact solver for them;
// everything else stays Bullet's: uncovered bodies, joints, motors, vehicles, ray casts, callbacks, motion
// states, sleeping. How a tick runs, and who owns which pair of bodies: bullet_bridge/README.md.
#pragma once

#include "bullet_bridge/layer_door.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

class GranularDynamicsWorld : public btDiscreteDynamicsWorld, public LayerDoor {
 public:
  /// As btDiscreteDynamicsWorld's; owns none of the four. The solver may be null, as there.
  GranularDynamicsWorld(btDispatcher* dispatcher, btBroadphaseInterface* pairCache,
                        btConstraintSolver* constraintSolver,
                        btCollisionConfiguration* collisionConfiguration, const LayerDef& def = {});
  /// May run before or after the bodies are deleted: it touches none of them.
  ~GranularDynamicsWorld() override;

  // ---- what is overridden of Bullet
  /// Grains feel it at once. Throws std::invalid_argument if it is not finite.
  void setGravity(const btVector3& gravity) override;
  int stepSimulation(btScalar timeStep, int maxSubSteps = 1,
                     btScalar fixedTimeStep = btScalar(1.) / btScalar(60.)) override;
  /// Uncovers it as well.
  void removeRigidBody(btRigidBody* body) override;
  void debugDrawWorld() override;

 protected:
  void saveKinematicState(btScalar timeStep) override;
  void internalSingleStepSimulation(btScalar timeStep) override;
};

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
