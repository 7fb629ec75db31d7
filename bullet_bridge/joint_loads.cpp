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

constexpr double kFollow = 0.6;      // of the difference, a tick
constexpr double kMostGrowth = 2.0;  // of what is followed, from a tick to the next

/// A blow is not followed: it will not come again, and the load would strike back.
granular::Vector3 steadyPart(const granular::Vector3& now, const granular::Vector3& before) {
  const double size = now.norm(), most = kMostGrowth * before.norm();
  return size > most ? granular::Vector3(most / size * now) : now;
}

void follow(granular::Wrench& load, granular::Wrench& before, const btVector3& force,
            const btVector3& torque) {
  const granular::Wrench now = {.force = fromBullet(force), .torque = fromBullet(torque)};
  if (!now.force.allFinite() || !now.torque.allFinite()) return;
  load.force += kFollow * (steadyPart(now.force, before.force) - load.force);
  load.torque += kFollow * (steadyPart(now.torque, before.torque) - load.torque);
  before = now;
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
  if (found == joints_.end()) return joint;
  std::ranges::copy(found->loads, joint.loads);
  std::ranges::copy(found->before, joint.before);
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
    detail::follow(joint.loads[0], joint.before[0], feedback.m_appliedForceBodyA,
                   feedback.m_appliedTorqueBodyA);
    detail::follow(joint.loads[1], joint.before[1], feedback.m_appliedForceBodyB,
                   feedback.m_appliedTorqueBodyB);
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
