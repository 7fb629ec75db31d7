// SPDX-License-Identifier: MIT
// What the program changed, taken over into the core before each tick. Facts about Bullet that the code leans
// on were read from the source of 3.24.
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/layer.h"
#include "bullet_bridge/pose_algebra.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

using granular::BodyMotion;
using granular::Pose;
using granular::Quaternion;
using granular::RigidMotion;
using granular::Vector3;

BodySettings settingsOf(const CoveredBody& covered, bool held) {
  const btRigidBody& body = *covered.body;
  BodySettings settings{.mass = 1.0 / double(body.getInvMass())};
  const Vector3 inverse = fromBullet(body.getInvInertiaDiagLocal());
  const bool turns = (inverse.array() > 0.0).all();
  if (!turns) {
    settings.principalInertia = Vector3::Constant(settings.mass);
  } else if (covered.momentsPerMass) {
    settings.principalInertia = settings.mass * *covered.momentsPerMass;
  } else {
    settings.principalInertia = inverse.cwiseInverse();
  }
  settings.inverseInertia = turns ? Vector3(settings.principalInertia.cwiseInverse()) : Vector3::Zero();
  if (!held) settings.linearFactor = fromBullet(body.getLinearFactor());
  if (!held && turns) settings.angularFactor = fromBullet(body.getAngularFactor());
  return settings;
}

bool meetInCore(const CoveredBody& a, const CoveredBody& b) {
  const auto movesParticles = [](const CoveredBody& covered) {
    return covered.make.motion == BodyMotion::Dynamic && covered.hasParticles();
  };
  return movesParticles(a) || movesParticles(b);
}

// ---- the two frames of a body

/// From Bullet's origin of the body to the core's, body axes of the core.
Vector3 leverOf(const CoveredBody& covered) {
  return covered.coreFrame.orientation.conjugate() * covered.coreFrame.position;
}

RigidMotion bulletMotion(const CoveredBody& covered, const RigidMotion& core) {
  RigidMotion motion = core;
  motion.pose = composed(core.pose, inverse(covered.coreFrame));
  motion.velocity -= core.angularVelocity.cross(core.pose.orientation * leverOf(covered));
  return motion;
}

RigidMotion coreMotion(const CoveredBody& covered, const RigidMotion& bullet) {
  RigidMotion motion = bullet;
  motion.pose = composed(bullet.pose, covered.coreFrame);
  motion.velocity += bullet.angularVelocity.cross(bullet.pose.orientation * covered.coreFrame.position);
  return motion;
}

// ---- a stepSimulation begins

void Layer::beginFrame() {
  report_.flags = granular::StepFlag::None;
  report_.subSteps = report_.rejectedTrials = report_.evaluations = report_.listRebuilds =
      report_.quarantined = 0;
  report_.largestOverlap = report_.droppedTime = secondsSpent_ = 0.0;
  report_.stageSeconds.fill(0.0);
}

/// Bullet has just read the poses that kinematic bodies shall have at the END of all ticks of this
/// stepSimulation.
void Layer::beginKinematicFrame(btScalar frameTime) {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Kinematic || !covered.body->isKinematicObject()) continue;
    if (!isFinite(stateOf(*covered.body))) continue;
    if (covered.body->getActivationState() == ISLAND_SLEEPING) continue;  // not read by Bullet either
    runKinematicTo(covered, fromBullet(covered.body->getWorldTransform()), frameTime);
  }
}

// ---- what the program did

void Layer::takeChanges(btScalar dt) {
  BT_PROFILE("granular: take changes");
  const Vector3 gravity = fromBullet(world_.getGravity());
  if (gravity.allFinite()) system_.setGravity(gravity);
  noteJoints(dt);
  for (CoveredBody& covered : bodies_) {
    remakeIfChanged(covered);
    switch (covered.make.motion) {
      case BodyMotion::Static:
        takeStaticPose(covered);
        break;
      case BodyMotion::Kinematic:
        takeKinematicPose(covered, dt);
        break;
      case BodyMotion::Dynamic:
        takeDynamicState(covered, dt);
        break;
    }
  }
  updateExclusions();
}

/// Which bodies Bullet's joints hold in this tick.
void Layer::noteJoints(btScalar dt) {
  for (CoveredBody& covered : bodies_) {
    covered.jointTick = 0.0;
    covered.isShownMidway = false;
  }
  for (int i = 0; i < world_.getNumConstraints(); ++i) {
    const btTypedConstraint& joint = *world_.getConstraint(i);
    if (!joint.isEnabled()) continue;
    for (const btRigidBody* body : {&joint.getRigidBodyA(), &joint.getRigidBodyB()}) {
      const auto found = slots_.find(body);
      if (found == slots_.end()) continue;
      bodies_[found->second].jointTick = dt;
      bodies_[found->second].isShownMidway = true;
    }
  }
  noteForeignJoints();
}

/// Bullet shows its own bodies to joints as they are at the start of the tick, or kinematic ones at its end:
/// what hangs together with such a one, be it through others, is shown at the start too.
void Layer::noteForeignJoints() {
  for (bool isSettled = false; !isSettled;) {
    isSettled = true;
    for (int i = 0; i < world_.getNumConstraints(); ++i) {
      const btTypedConstraint& joint = *world_.getConstraint(i);
      if (!joint.isEnabled()) continue;
      const btRigidBody* ends[2] = {&joint.getRigidBodyA(), &joint.getRigidBodyB()};
      if (!movesOutside(*ends[0]) && !movesOutside(*ends[1])) continue;
      for (const btRigidBody* body : ends) {
        const auto found = slots_.find(body);
        if (found == slots_.end() || !bodies_[found->second].isShownMidway) continue;
        bodies_[found->second].isShownMidway = isSettled = false;
      }
    }
  }
}

/// Whether it moves, and is not shown to joints in the middle of the tick.
bool Layer::movesOutside(const btRigidBody& body) const {
  if (body.isKinematicObject()) return true;
  if (body.isStaticObject() || body.getInvMass() == btScalar(0)) return false;
  const CoveredBody* covered = find(&body);
  return !covered || !covered->isShownMidway;
}

/// A static body moved by hand is somewhere else at once: it had no velocity.
void Layer::takeStaticPose(CoveredBody& covered) {
  const BulletState now = stateOf(*covered.body);
  if (isSame(now.transform, covered.written.transform) || !isFinite(now)) return;
  covered.written = now;
  covered.frameEnd = fromBullet(now.transform);
  system_.setBodyMotion(covered.id, {.pose = composed(covered.frameEnd, covered.coreFrame)});
  wakeAll_ = true;
}

/// Where the core has the body, as Bullet's frame of it stands.
Pose Layer::bulletPose(const CoveredBody& covered) const {
  return composed(system_.bodyMotion(covered.id).pose, inverse(covered.coreFrame));
}

/// From where the core has the body now to `end` within `duration` seconds.
void Layer::runKinematicTo(CoveredBody& covered, const Pose& end, double duration) {
  const Pose start = bulletPose(covered);
  covered.written = stateOf(*covered.body);
  covered.frameEnd = end;
  covered.frameTimeLeft = duration;
  covered.frameVelocity = (end.position - start.position) / duration;
  covered.frameAngularVelocity = turnBetween(start.orientation, end.orientation) / duration;
  const double speed =
      std::max(covered.frameVelocity.norm(), covered.frameAngularVelocity.norm() * covered.boundingRadius);
  if (speed > def_.kinematicSpeedLimit) {
    covered.frameVelocity.setZero();
    covered.frameAngularVelocity.setZero();
  }
}

/// Time in which a body goes from the pose last seen to where it is now. If no door told when a
/// stepSimulation began, it follows from the velocity that Bullet worked out from the two, (x_now - x_old) /
/// time, over a whole number of ticks; a pose set within a stepSimulation comes without, and is reached
/// within this tick.
double Layer::kinematicTime(const CoveredBody& covered, const BulletState& now, double dt) const {
  if (framesAreTold_) return dt;
  Vector3 way = fromBullet(now.transform.getOrigin()) - fromBullet(covered.written.transform.getOrigin());
  Vector3 speed = fromBullet(now.velocity);
  if (way.isZero(0.0)) {
    way =
        turnBetween(fromBullet(covered.written.transform).orientation, fromBullet(now.transform).orientation);
    speed = fromBullet(now.angularVelocity);
  }
  if (speed.isZero(0.0)) return dt;
  const double ticks = way.dot(speed) / speed.squaredNorm() / dt;
  const double whole = std::round(ticks);
  constexpr double kRounding = 0.05;  // of ways of a few thousand roundings of a float position
  return whole >= 1.0 && std::abs(ticks - whole) < kRounding * whole ? whole * dt : dt;
}

/// x(t) = x_end - v (t_end - t): Bullet holds the end pose in every tick of a frame, the core gets the one
/// between. A pose set within the frame (a tick callback) is reached within this tick. What the core fell
/// behind, as time was dropped, it makes up for in the rest of the frame.
void Layer::takeKinematicPose(CoveredBody& covered, double dt) {
  const BulletState now = stateOf(*covered.body);
  if (!isSame(now.transform, covered.written.transform) && isFinite(now)) {
    runKinematicTo(covered, fromBullet(now.transform), kinematicTime(covered, now, dt));
  } else if (covered.isBehind) {
    runKinematicTo(covered, covered.frameEnd, std::max(covered.frameTimeLeft, dt));
  }
  covered.isBehind = false;
  RigidMotion motion{.pose = covered.frameEnd};
  if (covered.frameTimeLeft > 0.5 * dt) {  // half a tick: the countdown rounds
    motion.angularVelocity = covered.frameAngularVelocity;
    motion.pose.position -= covered.frameVelocity * covered.frameTimeLeft;
    motion.pose.orientation =
        turnBy(-covered.frameAngularVelocity * covered.frameTimeLeft) * covered.frameEnd.orientation;
    // The core moves its origin in a straight line: from where it is on Bullet's arc to where it then is.
    const Vector3 arm = motion.pose.orientation * covered.coreFrame.position;
    motion.velocity = covered.frameVelocity + (turnBy(covered.frameAngularVelocity * dt) * arm - arm) / dt;
  }
  motion.pose = composed(motion.pose, covered.coreFrame);
  covered.frameTimeLeft -= dt;
  system_.setBodyMotion(covered.id, motion);
}

/// A velocity that Bullet has damped and nothing else changed (btRigidBody::applyDamping) loses what the
/// damping took, so the core's double stands; any other is what the program set.
void takeVelocity(Vector3& core, const btVector3& now, const btVector3& old, btScalar damping, btScalar dt) {
  const bool isDamped = isSame(now, old * btPow(btScalar(1) - damping, dt));
  core = isDamped ? Vector3(core + fromBullet(now) - fromBullet(old)) : fromBullet(now);
}

/// The core's doubles stand unless Bullet's numbers are not those last written. A state that is not finite is
/// not taken.
void Layer::takeDynamicState(CoveredBody& covered, btScalar dt) {
  const BulletState now = stateOf(*covered.body);
  const BulletState& old = covered.written;
  RigidMotion motion = system_.bodyMotion(covered.id);
  if (!isFinite(now)) {
    write(covered, motion);
    return;
  }
  const bool samePlace = isSame(now.transform.getOrigin(), old.transform.getOrigin());
  const bool sameTurn = isSame(now.transform.getBasis(), old.transform.getBasis());
  const bool sameVelocity = isSame(now.velocity, old.velocity);
  const bool sameSpin = isSame(now.angularVelocity, old.angularVelocity);
  if (!(samePlace && sameTurn && sameVelocity && sameSpin)) {
    RigidMotion frame = bulletMotion(covered, motion);
    if (!samePlace) frame.pose.position = fromBullet(now.transform.getOrigin());
    if (!sameTurn) frame.pose.orientation = fromBullet(now.transform.getBasis());
    const btRigidBody& body = *covered.body;
    if (!sameVelocity) takeVelocity(frame.velocity, now.velocity, old.velocity, body.getLinearDamping(), dt);
    if (!sameSpin) {
      takeVelocity(frame.angularVelocity, now.angularVelocity, old.angularVelocity, body.getAngularDamping(),
                   dt);
    }
    system_.setBodyMotion(covered.id, coreMotion(covered, frame));
  }
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
