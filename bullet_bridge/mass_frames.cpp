// SPDX-License-Identifier: MIT
#include "bullet_bridge/mass_frames.h"

#include "bullet_bridge/convert.h"
#include "bullet_bridge/pose_algebra.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

using granular::Pose;

btTransform seen(const Pose* frame, const btTransform& inBody) {
  return frame ? toBullet(composed(inverse(*frame), fromBullet(inBody))) : inBody;
}
btVector3 seenPoint(const Pose* frame, const btVector3& inBody) {
  return frame ? toBullet(frame->toOwn(fromBullet(inBody))) : inBody;
}
btVector3 seenDirection(const Pose* frame, const btVector3& inBody) {
  return frame ? toBullet(granular::Vector3(frame->orientation.conjugate() * fromBullet(inBody))) : inBody;
}

using Undo = std::function<void()>;

/// Joints that hand out their frames.
template <class Joint>
Undo showFrames(btTypedConstraint& constraint, const Pose* a, const Pose* b) {
  auto& joint = static_cast<Joint&>(constraint);
  const btTransform frameA = joint.getFrameOffsetA();
  const btTransform frameB = joint.getFrameOffsetB();
  joint.getFrameOffsetA() = seen(a, frameA);
  joint.getFrameOffsetB() = seen(b, frameB);
  return [&joint, frameA, frameB] {
    joint.getFrameOffsetA() = frameA;
    joint.getFrameOffsetB() = frameB;
  };
}

Undo showConeTwist(btConeTwistConstraint& joint, const Pose* a, const Pose* b) {
  const btTransform frameA = joint.getAFrame();
  const btTransform frameB = joint.getBFrame();
  joint.setFrames(seen(a, frameA), seen(b, frameB));
  return [&joint, frameA, frameB] { joint.setFrames(frameA, frameB); };
}

Undo showPoints(btPoint2PointConstraint& joint, const Pose* a, const Pose* b) {
  const btVector3 pivotA = joint.getPivotInA();
  const btVector3 pivotB = joint.getPivotInB();
  joint.setPivotA(seenPoint(a, pivotA));
  joint.setPivotB(seenPoint(b, pivotB));
  return [&joint, pivotA, pivotB] {
    joint.setPivotA(pivotA);
    joint.setPivotB(pivotB);
  };
}

Undo showGear(btGearConstraint& joint, const Pose* a, const Pose* b) {
  btVector3 axisA = joint.getAxisA();
  btVector3 axisB = joint.getAxisB();
  btVector3 seenA = seenDirection(a, axisA);
  btVector3 seenB = seenDirection(b, axisB);
  joint.setAxisA(seenA);
  joint.setAxisB(seenB);
  return [&joint, axisA, axisB]() mutable {
    joint.setAxisA(axisA);
    joint.setAxisB(axisB);
  };
}

Undo showJoint(btTypedConstraint& joint, const Pose* a, const Pose* b) {
  switch (joint.getConstraintType()) {
    case POINT2POINT_CONSTRAINT_TYPE:
      return showPoints(static_cast<btPoint2PointConstraint&>(joint), a, b);
    case HINGE_CONSTRAINT_TYPE:
      return showFrames<btHingeConstraint>(joint, a, b);
    case CONETWIST_CONSTRAINT_TYPE:
      return showConeTwist(static_cast<btConeTwistConstraint&>(joint), a, b);
    case D6_CONSTRAINT_TYPE:
    case D6_SPRING_CONSTRAINT_TYPE:
      return showFrames<btGeneric6DofConstraint>(joint, a, b);
    case SLIDER_CONSTRAINT_TYPE:
      return showFrames<btSliderConstraint>(joint, a, b);
    case GEAR_CONSTRAINT_TYPE:
      return showGear(static_cast<btGearConstraint&>(joint), a, b);
    case FIXED_CONSTRAINT_TYPE:
    case D6_SPRING_2_CONSTRAINT_TYPE:
      return showFrames<btGeneric6DofSpring2Constraint>(joint, a, b);
    default:
      return [] {};
  }
}

}  // namespace

void MassFrames::show(btRigidBody& body, const Pose& start, const Pose& worldPose,
                      const btVector3& inverseInertia) {
  const btVector3 shift = toBullet(granular::Vector3(worldPose.position - start.position));
  if (!shift.isZero()) shifts_[&body] = shift;
  bodies_.push_back({.body = &body,
                     .transform = body.getWorldTransform(),
                     .inverseInertia = body.getInvInertiaDiagLocal()});
  body.setWorldTransform(toBullet(worldPose));
  body.setInvInertiaDiagLocal(inverseInertia);
  body.updateInertiaTensor();
}

btVector3 MassFrames::shiftOf(const btCollisionObject* body) const {
  const auto found = shifts_.find(body);
  return found == shifts_.end() ? btVector3(0, 0, 0) : found->second;
}

void MassFrames::showContacts(btDispatcher& dispatcher) {
  if (shifts_.empty()) return;
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(i);
    const btVector3 shiftA = shiftOf(manifold.getBody0()), shiftB = shiftOf(manifold.getBody1());
    if (shiftA.isZero() && shiftB.isZero()) continue;
    for (int c = 0; c < manifold.getNumContacts(); ++c) {
      btManifoldPoint& point = manifold.getContactPoint(c);
      points_.push_back({.point = &point, .onA = point.m_positionWorldOnA, .onB = point.m_positionWorldOnB});
      point.m_positionWorldOnA += shiftA;
      point.m_positionWorldOnB += shiftB;
    }
  }
}

void MassFrames::showJoints(btDiscreteDynamicsWorld& world, const FrameOf& frameOf) {
  if (bodies_.empty()) return;
  for (int i = 0; i < world.getNumConstraints(); ++i) {
    btTypedConstraint& joint = *world.getConstraint(i);
    const Pose* a = frameOf(joint.getRigidBodyA());
    const Pose* b = frameOf(joint.getRigidBodyB());
    if (a || b) undoJoints_.push_back(showJoint(joint, a, b));
  }
}

void MassFrames::hide() {
  for (const Undo& undo : undoJoints_) undo();
  undoJoints_.clear();
  for (const ShiftedPoint& shifted : points_) {
    shifted.point->m_positionWorldOnA = shifted.onA;
    shifted.point->m_positionWorldOnB = shifted.onB;
  }
  points_.clear();
  shifts_.clear();
  for (const Shown& shown : bodies_) {
    shown.body->setWorldTransform(shown.transform);
    shown.body->setInvInertiaDiagLocal(shown.inverseInertia);
    shown.body->updateInertiaTensor();
  }
  bodies_.clear();
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
