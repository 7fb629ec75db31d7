// SPDX-License-Identifier: MIT
// What joints pull on covered bodies with while the core moves them. Bullet's solver comes once a tick, after
// the core: what a joint carries all the time (a weight that hangs on it) would be missing within the tick,
// the body would fall freely and be put back, and where contacts stand against that, they would be hit anew
// in every tick. So the force and torque of each joint, as the solver found them, act on in the next tick as
// a steady load, and the solver finds the difference.
//
// How fast: under a steady force F, with v = relative velocity at the end of a tick and P = load,
// v' = (F + P) dt / 2m and P' = P - b (v m / dt + (F + P) / 2). At b = 0.6 errors fade by sqrt(b / 2) = 0.55
// a tick (the solver's error reduction left out, which sees bodies in mid-tick and helps a little). A slower
// load turns behind a joint that swings (0.34: a pendulum at 97 ticks a period is slow by 0.6 %), a faster
// one rings. A blow is no steady force: what is followed at most doubles from tick to tick, else a joint that
// stops two bodies would push them at one another in the tick after.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <vector>

#include "bullet_bridge/precision.h"
#include "granular/dynamics/rigid_motion.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

class JointLoads {
 public:
  /// Called with a body and what one of its joints does to it: N and N m about its centre of mass, world.
  using Taker = std::function<void(const btRigidBody&, const granular::Wrench&)>;

  /// Asks joints of these bodies what they do. Before the solver.
  void listen(btDiscreteDynamicsWorld& world, const std::function<bool(const btRigidBody&)>& isCovered);
  /// Follows what the solver found; a joint that broke or left the world bears nothing any more. After it.
  void follow();
  /// As it stands for the next tick.
  void tell(const Taker& take) const;

 private:
  struct Joint {
    btTypedConstraint* constraint = nullptr;
    const btRigidBody* bodies[2] = {nullptr, nullptr};
    granular::Wrench loads[2] = {};
    granular::Wrench before[2] = {};  // what the solver found in the last tick
    btJointFeedback feedback = {};    // where the program has none of its own
  };
  Joint asBefore(btTypedConstraint& constraint, std::size_t place) const;

  std::vector<Joint> joints_;  // in the world's order
};

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
