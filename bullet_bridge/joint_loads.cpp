// SPDX-License-Identifier: MIT
#include "bullet_bridge/joint_loads.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bullet_bridge/convert.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

constexpr double kFollow = 0.6;  // of the difference, a tick

void follow(granular::Wrench& load, const btVector3& force, const btVector3& torque) {
  const granular::Vector3 f = fromBullet(force), t = fromBullet(torque);
  if (!f.allFinite() || !t.allFinite()) return;
  load.force += kFollow * (f - load.force);
  load.torque += kFollow * (t - load.torque);
}

}  // namespace

/// With the loads of the last tick, if it was there: most likely at the same place.
JointLoads::Joint JointLoads::asBefore(btTypedConstraint& constraint, std::size_t place) const {
  Joint joint = {.constraint = &constraint,
                 .bodies = {&constraint.getRigidBodyA(), &constraint.getRigidBodyB()}};
  const auto isIt = [&](const Joint& known) {
    return known.constraint == &constraint && std::ranges::equal(known.bodies, joint.bodies);
  };
  auto found = joints_.begin() + static_cast<std::ptrdiff_t>(std::min(place, joints_.size()));
  if (found == joints_.end() || !isIt(*found)) found = std::find_if(joints_.begin(), joints_.end(), isIt);
  if (found != joints_.end()) std::ranges::copy(found->loads, joint.loads);
  return joint;
}

void JointLoads::listen(btDiscreteDynamicsWorld& world,
                        const std::function<bool(const btRigidBody&)>& isCovered) {
  std::vector<Joint> joints;
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& constraint = *world.getConstraint(i);
    if (!constraint.isEnabled()) continue;
    if (!isCovered(constraint.getRigidBodyA()) && !isCovered(constraint.getRigidBodyB())) continue;
    joints.push_back(asBefore(constraint, joints.size()));
  }
  joints_ = std::move(joints);
  for (Joint& joint : joints_) {
    if (!joint.constraint->getJointFeedback()) joint.constraint->setJointFeedback(&joint.feedback);
  }
}

void JointLoads::follow() {
  for (Joint& joint : joints_) {
    const btJointFeedback& feedback = *joint.constraint->getJointFeedback();
    detail::follow(joint.loads[0], feedback.m_appliedForceBodyA, feedback.m_appliedTorqueBodyA);
    detail::follow(joint.loads[1], feedback.m_appliedForceBodyB, feedback.m_appliedTorqueBodyB);
    if (&feedback == &joint.feedback) joint.constraint->setJointFeedback(nullptr);
  }
  std::erase_if(joints_, [](const Joint& joint) { return !joint.constraint->isEnabled(); });
}

void JointLoads::tell(const Taker& take) const {
  for (const Joint& joint : joints_) {
    for (int side = 0; side < 2; ++side) take(*joint.bodies[side], joint.loads[side]);
  }
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
