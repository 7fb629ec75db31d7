// SPDX-License-Identifier: MIT
// Motion across the border, in the order of a tick: what the program changed, what the core made of it, what
// Bullet's solver adds, and back. Facts about Bullet that the code leans on were read from the source
// of 3.24.
#include <algorithm>
#include <cmath>
#include <limits>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/layer.h"
#include "bullet_bridge/pose_algebra.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

using granular::BodyMotion;
using granular::Pose;
using granular::Quaternion;
using granular::RigidMotion;
using granular::Vector3;

bool isFinite(const btVector3& v) {
  return fromBullet(v).allFinite();
}

bool isFinite(const RigidMotion& m) {
  return m.pose.position.allFinite() && m.pose.orientation.coeffs().allFinite() && m.velocity.allFinite() &&
         m.angularVelocity.allFinite();
}

/// Bit for bit in all that counts (the fourth component of a btVector3 is padding).
bool isSame(const btVector3& a, const btVector3& b) {
  return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}

bool isSame(const btMatrix3x3& a, const btMatrix3x3& b) {
  return isSame(a[0], b[0]) && isSame(a[1], b[1]) && isSame(a[2], b[2]);
}

bool isSame(const btTransform& a, const btTransform& b) {
  return isSame(a.getOrigin(), b.getOrigin()) && isSame(a.getBasis(), b.getBasis());
}

/// The turn from one orientation to another, the short way round, as axis times angle, world frame, rad.
Vector3 turnBetween(const Quaternion& from, const Quaternion& to) {
  Quaternion turn = to * from.conjugate();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  if (sine == 0.0) return Vector3::Zero();
  return turn.vec() * (2.0 * std::atan2(sine, turn.w()) / sine);
}

Quaternion turnBy(const Vector3& turn) {
  const double angle = turn.norm();
  if (angle == 0.0) return Quaternion::Identity();
  return Quaternion(Eigen::AngleAxisd(angle, turn / angle));
}

/// What Bullet's solver adds to the velocity for the total force and torque (initSolverBody), in its own
/// arithmetic.
btVector3 forceImpulse(const btRigidBody& body, btScalar dt) {
  return body.getTotalForce() * body.getInvMass() * dt;
}
btVector3 torqueImpulse(const btRigidBody& body, btScalar dt) {
  return body.getTotalTorque() * body.getInvInertiaTensorWorld() * dt;
}

/// now - expected, or zero where the two differ by rounding alone: a Bullet compiled with fused multiply-add
/// need not give the bits that we expect of it.
Vector3 changeOf(const btVector3& now, const btVector3& expected, const btVector3& added) {
  const double noise =
      8.0 * std::numeric_limits<btScalar>::epsilon() * double(expected.length() + added.length());
  const Vector3 change = fromBullet(now) - fromBullet(expected);
  return change.norm() <= noise ? Vector3::Zero() : change;
}

void add(granular::StepReport& sum, const granular::StepReport& tick) {
  granular::StepReport total = tick;
  total.flags = sum.flags | tick.flags;
  total.subSteps += sum.subSteps;
  total.rejectedTrials += sum.rejectedTrials;
  total.evaluations += sum.evaluations;
  total.listRebuilds += sum.listRebuilds;
  total.quarantined += sum.quarantined;
  if (sum.subSteps > 0) {
    total.shortestSubStep = std::min(sum.shortestSubStep, tick.shortestSubStep);
    total.longestSubStep = std::max(sum.longestSubStep, tick.longestSubStep);
    total.largestOverlap = std::max(sum.largestOverlap, tick.largestOverlap);
  }
  for (std::size_t i = 0; i < total.stageSeconds.size(); ++i) total.stageSeconds[i] += sum.stageSeconds[i];
  sum = total;
}

}  // namespace

bool isFinite(const BulletState& s) {
  const btMatrix3x3& basis = s.transform.getBasis();
  return isFinite(s.transform.getOrigin()) && isFinite(basis[0]) && isFinite(basis[1]) &&
         isFinite(basis[2]) && isFinite(s.velocity) && isFinite(s.angularVelocity);
}

BulletState stateOf(const btRigidBody& body) {
  return {body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity()};
}

BodySettings settingsOf(const btRigidBody& body, bool held) {
  BodySettings settings{.mass = 1.0 / double(body.getInvMass())};
  const Vector3 inverse = fromBullet(body.getInvInertiaDiagLocal());
  const bool turns = (inverse.array() > 0.0).all();
  settings.principalInertia = turns ? Vector3(inverse.cwiseInverse()) : Vector3::Constant(settings.mass);
  if (!held) settings.linearFactor = fromBullet(body.getLinearFactor());
  if (!held && turns) settings.angularFactor = fromBullet(body.getAngularFactor());
  return settings;
}

bool meetInCore(const CoveredBody& a, const CoveredBody& b) {
  const auto movesParticles = [](const CoveredBody& covered) {
    return covered.make.motion == BodyMotion::Dynamic && !covered.exact;
  };
  return movesParticles(a) || movesParticles(b);
}

// ---- a stepSimulation begins

void Layer::beginFrame() {
  report_.flags = granular::StepFlag::None;
  report_.subSteps = report_.rejectedTrials = report_.evaluations = report_.listRebuilds =
      report_.quarantined = 0;
  report_.largestOverlap = 0.0;
  report_.stageSeconds.fill(0.0);
  for (CoveredBody& covered : bodies_) covered.hasGravityForce = false;
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

void Layer::noteGravity() {
  for (CoveredBody& covered : bodies_) covered.hasGravityForce = covered.body->isActive();
}

// ---- what the program did

void Layer::takeChanges(btScalar dt) {
  system_.setGravity(fromBullet(world_.getGravity()));
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
        takeDynamicState(covered);
        break;
    }
  }
  updateExclusions();
}

/// A static body moved by hand is somewhere else at once: it had no velocity.
void Layer::takeStaticPose(CoveredBody& covered) {
  const BulletState now = stateOf(*covered.body);
  if (isSame(now.transform, covered.written.transform) || !isFinite(now)) return;
  covered.written = now;
  covered.frameEnd = fromBullet(now.transform);
  system_.setBodyMotion(covered.id, {.pose = composed(covered.frameEnd, covered.surfaceFrame)});
  wakeAll_ = true;
}

/// Where the core has the body, as Bullet's frame of it stands.
Pose Layer::bulletPose(const CoveredBody& covered) const {
  return composed(system_.bodyMotion(covered.id).pose, inverse(covered.surfaceFrame));
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

/// x(t) = x_end - v (t_end - t): Bullet holds the end pose in every tick of a frame, the core gets the one
/// between. A pose set within the frame (a tick callback) is reached within this tick.
void Layer::takeKinematicPose(CoveredBody& covered, double dt) {
  const BulletState now = stateOf(*covered.body);
  if (!isSame(now.transform, covered.written.transform) && isFinite(now)) {
    runKinematicTo(covered, fromBullet(now.transform), dt);
  }
  RigidMotion motion{.pose = covered.frameEnd};
  if (covered.frameTimeLeft > 0.5 * dt) {  // half a tick: the countdown rounds
    motion.angularVelocity = covered.frameAngularVelocity;
    motion.pose.position -= covered.frameVelocity * covered.frameTimeLeft;
    motion.pose.orientation =
        turnBy(-covered.frameAngularVelocity * covered.frameTimeLeft) * covered.frameEnd.orientation;
    // The core moves its origin in a straight line: from where it is on Bullet's arc to where it then is.
    const Vector3 arm = motion.pose.orientation * covered.surfaceFrame.position;
    motion.velocity = covered.frameVelocity + (turnBy(covered.frameAngularVelocity * dt) * arm - arm) / dt;
  }
  motion.pose = composed(motion.pose, covered.surfaceFrame);
  covered.frameTimeLeft -= dt;
  system_.setBodyMotion(covered.id, motion);
}

/// The core's doubles stand unless Bullet's numbers are not those last written. A state that is not finite is
/// not taken.
void Layer::takeDynamicState(CoveredBody& covered) {
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
  if (!samePlace) motion.pose.position = fromBullet(now.transform.getOrigin());
  if (!sameTurn) motion.pose.orientation = fromBullet(now.transform.getBasis());
  if (!sameVelocity) motion.velocity = fromBullet(now.velocity);
  if (!sameSpin) motion.angularVelocity = fromBullet(now.angularVelocity);
  if (!(samePlace && sameTurn && sameVelocity && sameSpin)) system_.setBodyMotion(covered.id, motion);
  covered.velocityBeforeDamping = now.velocity;
  covered.angularVelocityBeforeDamping = now.angularVelocity;
}

/// Bullet damps in its own precision; the core takes the difference, so nothing is lost where there is no
/// damping.
void Layer::takeDamping() {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    const btRigidBody& body = *covered.body;
    const Vector3 change = fromBullet(body.getLinearVelocity()) - fromBullet(covered.velocityBeforeDamping);
    const Vector3 turn =
        fromBullet(body.getAngularVelocity()) - fromBullet(covered.angularVelocityBeforeDamping);
    if (change.isZero(0.0) && turn.isZero(0.0)) continue;
    RigidMotion motion = system_.bodyMotion(covered.id);
    motion.velocity += change;
    motion.angularVelocity += turn;
    system_.setBodyMotion(covered.id, motion);
  }
}

// ---- sleep

/// A body stays awake while grains are near it: they are in none of Bullet's islands, so Bullet would let it
/// hang in the air when they flow away. A sleeping one is woken by covered bodies that move near it (their
/// particles may reach beyond the boxes by which Bullet makes islands) and when something covered is taken
/// away or put elsewhere.
void Layer::keepAwake(btScalar dt) {
  const bool anyDynamic = std::any_of(bodies_.begin(), bodies_.end(), [](const CoveredBody& covered) {
    return covered.make.motion == BodyMotion::Dynamic;
  });
  if (!anyDynamic) return;
  const double grainRadius = largestGrainRadius();
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    const bool asleep = covered.body->getActivationState() == ISLAND_SLEEPING;
    if (wakeAll_ || isNearGrains(covered, grainRadius, dt) || (asleep && isNearMovingBody(covered, dt)))
      wake(covered);
  }
  wakeAll_ = false;
}

bool Layer::isNearGrains(const CoveredBody& covered, double largestGrainRadius, double dt) const {
  const RigidMotion body = system_.bodyMotion(covered.id);
  const auto grains = system_.grainMotions();
  for (std::size_t i = 0; i < grains.size(); ++i) {
    const double reach =
        covered.boundingRadius + 2.0 * largestGrainRadius + (grains[i].velocity - body.velocity).norm() * dt;
    if ((grains[i].pose.position - body.pose.position).squaredNorm() > reach * reach) continue;
    if (system_.grainAt(static_cast<std::int32_t>(i)).index >= 0) return true;
  }
  return false;
}

bool Layer::isNearMovingBody(const CoveredBody& covered, double dt) const {
  const Vector3 here = system_.bodyMotion(covered.id).pose.position;
  return std::any_of(bodies_.begin(), bodies_.end(), [&](const CoveredBody& other) {
    if (&other == &covered || other.make.motion == BodyMotion::Static || !other.body->isActive())
      return false;
    const RigidMotion motion = system_.bodyMotion(other.id);
    const Vector3 away = here - motion.pose.position;
    const double lever = other.isPlane() ? away.norm() : other.boundingRadius;
    const double speed = motion.velocity.norm() + motion.angularVelocity.norm() * lever;
    const bool kinematic = other.make.motion == BodyMotion::Kinematic;
    if (speed <= (kinematic ? 0.0 : double(other.body->getLinearSleepingThreshold()))) return false;
    const double gap = other.isPlane() ? away.dot(motion.pose.orientation * Vector3::UnitY())
                                       : away.norm() - other.boundingRadius;
    return gap < covered.boundingRadius + speed * dt;
  });
}

/// Also resets the time after which Bullet puts a resting body to sleep. A body that slept when this
/// stepSimulation began has missed its gravity.
void Layer::wake(CoveredBody& covered) {
  btRigidBody& body = *covered.body;
  body.activate();
  if (covered.hasGravityForce || !body.isActive()) return;
  if ((body.getFlags() & BT_DISABLE_WORLD_GRAVITY) == 0) body.setGravity(world_.getGravity());
  body.applyGravity();
  covered.hasGravityForce = true;
}

// ---- the core's step, and Bullet's share

void Layer::switchSweepsOff() {
  for (CoveredBody& covered : bodies_) {
    covered.sweepThreshold = covered.body->getCcdMotionThreshold();
    covered.body->setCcdMotionThreshold(0);
  }
}

void Layer::switchSweepsOn() {
  for (CoveredBody& covered : bodies_) covered.body->setCcdMotionThreshold(covered.sweepThreshold);
}

void Layer::step(btScalar dt) {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion == BodyMotion::Dynamic) prepareDynamic(covered);
  }
  add(report_, system_.step(dt));
}

void Layer::prepareDynamic(CoveredBody& covered) {
  const btRigidBody& body = *covered.body;
  covered.held = !body.isActive();
  RigidMotion motion = system_.bodyMotion(covered.id);
  covered.startPose = motion.pose;
  if (covered.held && !(motion.velocity.isZero(0.0) && motion.angularVelocity.isZero(0.0))) {
    system_.setBodyMotion(covered.id, {.pose = motion.pose});
  }
  const BodySettings settings = settingsOf(body, covered.held);
  if (!(settings == covered.settings)) {
    system_.setBodyMass(covered.id, settings.mass, settings.principalInertia);
    system_.setBodyFactors(covered.id, settings.linearFactor, settings.angularFactor);
    covered.settings = settings;
  }
  applyLoad(covered);
}

/// Bullet's total force holds gravity, added once per stepSimulation in Bullet's arithmetic
/// (btRigidBody::applyGravity). The core has gravity as an acceleration of its own; the load is the rest,
/// exactly zero if there is none.
void Layer::applyLoad(CoveredBody& covered) {
  const btRigidBody& body = *covered.body;
  const btVector3 gravityForce =
      body.getGravity() * (btScalar(1) / body.getInvMass()) * body.getLinearFactor();
  granular::Wrench load;
  if (!covered.held) {
    load.force = fromBullet(body.getTotalForce()) - fromBullet(gravityForce);
    load.torque = fromBullet(body.getTotalTorque());
  }
  system_.setBodyGravity(covered.id, fromBullet(body.getGravity()));
  system_.setBodyLoad(covered.id, load);
}

/// Gives Bullet's solver the velocity that, with what the solver itself adds for the total force, is the mean
/// one. The gyroscopic term is in the core; Bullet would count it again (its flag is on by default).
void Layer::offerMeanMotion(btScalar dt) {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    btRigidBody& body = *covered.body;
    const btVector3 added = forceImpulse(body, dt);
    const btVector3 turned = torqueImpulse(body, dt);
    covered.meanAngularVelocity.setZero();
    if (!covered.held) {
      const Pose end = system_.bodyMotion(covered.id).pose;
      covered.meanAngularVelocity = turnBetween(covered.startPose.orientation, end.orientation) / double(dt);
      body.setLinearVelocity(toBullet(Vector3((end.position - covered.startPose.position) / double(dt))) -
                             added);
      body.setAngularVelocity(toBullet(covered.meanAngularVelocity) - turned);
    }
    covered.flags = body.getFlags();
    body.setFlags(covered.flags &
                  ~(BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT | BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD |
                    BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY));
    covered.offered = stateOf(body);
    covered.expectedVelocity = covered.offered.velocity + added;
    covered.expectedAngularVelocity = covered.offered.angularVelocity + turned;
  }
}

void Layer::takeCorrections() {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    btRigidBody& body = *covered.body;
    body.setFlags(covered.flags);
    covered.velocityCorrection.setZero();
    covered.angularVelocityCorrection.setZero();
    covered.push = {};
    if (!body.isActive()) continue;  // its island sleeps: Bullet solved nothing
    const BulletState now = stateOf(body);
    const BulletState& offered = covered.offered;
    covered.velocityCorrection = changeOf(now.velocity, covered.expectedVelocity, offered.velocity);
    covered.angularVelocityCorrection =
        changeOf(now.angularVelocity, covered.expectedAngularVelocity, offered.angularVelocity);
    if (isSame(now.transform, offered.transform)) continue;
    const Pose before = fromBullet(offered.transform);
    const Pose after = fromBullet(now.transform);
    covered.push = {.position = after.position - before.position,
                    .orientation = (after.orientation * before.orientation.conjugate()).normalized()};
  }
}

bool isCorrected(const CoveredBody& covered) {
  return !(covered.velocityCorrection.isZero(0.0) && covered.angularVelocityCorrection.isZero(0.0) &&
           covered.push.position.isZero(0.0) && covered.push.orientation.vec().isZero(0.0));
}

/// (x1, v1) of the core plus what Bullet's joints and foreign contacts added; the turn from x0 is made in
/// double and without Bullet's limit of an eighth of a turn per tick.
RigidMotion Layer::correctedMotion(const CoveredBody& covered, double dt) const {
  RigidMotion motion = system_.bodyMotion(covered.id);
  const Vector3& dv = covered.velocityCorrection;
  const Vector3& dw = covered.angularVelocityCorrection;
  motion.pose.position += dv * dt + covered.push.position;
  motion.velocity += dv;
  motion.angularVelocity += dw;
  motion.pose.orientation = (turnBy((covered.meanAngularVelocity + dw) * dt) * covered.push.orientation *
                             covered.startPose.orientation)
                                .normalized();
  return motion;
}

void Layer::store(btScalar dt) {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    const bool active = covered.body->isActive();
    if (covered.held && !active) continue;
    RigidMotion motion = system_.bodyMotion(covered.id);
    const bool corrected = isCorrected(covered);
    if (corrected) motion = correctedMotion(covered, dt);
    if (!active) motion.velocity = motion.angularVelocity = Vector3::Zero();  // fell asleep in this tick
    if (!isFinite(motion)) motion = {.pose = covered.startPose};
    if (corrected || !active) system_.setBodyMotion(covered.id, motion);
    write(covered, motion);
  }
}

/// Transform last: it copies the velocities into what motion states are extrapolated from.
void Layer::write(CoveredBody& covered, const RigidMotion& motion) {
  btRigidBody& body = *covered.body;
  body.setLinearVelocity(toBullet(motion.velocity));
  body.setAngularVelocity(toBullet(motion.angularVelocity));
  body.setCenterOfMassTransform(toBullet(motion.pose));
  covered.written = stateOf(body);
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
