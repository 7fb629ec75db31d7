// SPDX-License-Identifier: MIT
// What the core makes of the tick, what Bullet's solver adds, and the result written back. Facts about Bullet
// that the code leans on were read from the source of 3.24.
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <chrono>
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
using granular::RigidMotion;
using granular::Vector3;

bool isFinite(const RigidMotion& m) {
  return m.pose.position.allFinite() && m.pose.orientation.coeffs().allFinite() && m.velocity.allFinite() &&
         m.angularVelocity.allFinite();
}

/// What a program sets while running is not refused; numbers that mean nothing are not taken.
bool isUsable(const BodySettings& s) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  return positive(s.mass) && std::all_of(s.principalInertia.begin(), s.principalInertia.end(), positive) &&
         s.linearFactor.allFinite() && s.angularFactor.allFinite();
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
  total.droppedTime += sum.droppedTime;
  total.fellAsleep += sum.fellAsleep;
  total.woken += sum.woken;
  if (sum.subSteps > 0) {
    total.shortestSubStep = std::min(sum.shortestSubStep, tick.shortestSubStep);
    total.longestSubStep = std::max(sum.longestSubStep, tick.longestSubStep);
    total.largestOverlap = std::max(sum.largestOverlap, tick.largestOverlap);
  }
  for (std::size_t i = 0; i < total.stageSeconds.size(); ++i) total.stageSeconds[i] += sum.stageSeconds[i];
  sum = total;
}

}  // namespace

void Layer::switchSweepsOff() {
  for (CoveredBody& covered : bodies_) {
    covered.sweepThreshold = covered.body->getCcdMotionThreshold();
    covered.body->setCcdMotionThreshold(0);
  }
}

void Layer::switchSweepsOn() {
  for (CoveredBody& covered : bodies_) covered.body->setCcdMotionThreshold(covered.sweepThreshold);
}

void Layer::takeJointLoads() {
  for (CoveredBody& covered : bodies_) covered.jointLoad = {};
  jointLoads_.tell([this](const btRigidBody& body, const granular::Wrench& load) {
    const auto slot = slots_.find(&body);
    if (slot == slots_.end()) return;
    granular::Wrench& sum = bodies_[slot->second].jointLoad;
    sum.force += load.force;
    sum.torque += load.torque;
  });
}

void Layer::step(btScalar dt) {
  takeJointLoads();
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion == BodyMotion::Dynamic) prepareDynamic(covered);
  }
  integrate(dt);
  wakeWithCore();
}

/// As much of the tick as the budget of this stepSimulation is enough for. Bullet's solver sees what is left
/// of the motion as the mean of the whole tick, so its impulses stay equal on both sides of a joint or
/// contact; it only takes more ticks to turn the core's velocity round.
void Layer::integrate(double dt) {
  BT_PROFILE("granular: integrate grains and bodies");
  const granular::WorkBudget left{.evaluations = def_.budget.evaluations - report_.evaluations,
                                  .seconds = def_.budget.seconds - secondsSpent_};
  double dropped = dt;
  if (report_.subSteps == 0 || (left.evaluations > 0 && left.seconds > 0.0)) {
    const auto start = std::chrono::steady_clock::now();
    const granular::StepReport tick = system_.step(dt, left);
    secondsSpent_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    dropped = tick.droppedTime;
    lastTick_ = dt - dropped;
    add(report_, tick);
  } else {
    report_.droppedTime += dt;
    report_.flags = report_.flags | granular::StepFlag::BudgetExhausted;
  }
  if (dropped == 0.0) return;
  for (CoveredBody& covered : bodies_) covered.isBehind = true;
}

void Layer::prepareDynamic(CoveredBody& covered) {
  const btRigidBody& body = *covered.body;
  covered.held = !body.isActive();
  covered.sleepsInCore = body.getActivationState() == ISLAND_SLEEPING && !system_.isAwake(covered.id);
  RigidMotion motion = system_.bodyMotion(covered.id);
  covered.startPose = motion.pose;
  if (covered.held && !(motion.velocity.isZero(0.0) && motion.angularVelocity.isZero(0.0))) {
    system_.setBodyMotion(covered.id, {.pose = motion.pose});
  }
  const BodySettings settings = settingsOf(covered, covered.held && !covered.sleepsInCore);
  if (!(settings == covered.settings) && isUsable(settings)) {
    system_.setBodyMass(covered.id, settings.mass, settings.principalInertia);
    system_.setBodyFactors(covered.id, settings.linearFactor, settings.angularFactor);
    covered.settings = settings;
  }
  applyLoad(covered);
}

/// Bullet's total force holds gravity, added once per stepSimulation in Bullet's arithmetic
/// (btRigidBody::applyGravity). The core has gravity as an acceleration of its own; the load is the rest,
/// exactly zero if there is none. It acts where the program said, Bullet's origin of the body being its
/// centre.
void Layer::applyLoad(CoveredBody& covered) {
  const btRigidBody& body = *covered.body;
  const btVector3 gravityForce =
      body.getGravity() * (btScalar(1) / body.getInvMass()) * body.getLinearFactor();
  granular::Wrench load;
  if (!covered.held) {
    const Vector3 lever = covered.startPose.orientation * leverOf(covered);
    load.force = fromBullet(body.getTotalForce()) - fromBullet(gravityForce);
    load.torque = fromBullet(body.getTotalTorque()) - lever.cross(load.force) + covered.jointLoad.torque;
    load.force += covered.jointLoad.force;
  }
  const Vector3 gravity = fromBullet(body.getGravity());
  if (!gravity.allFinite() || !load.force.allFinite() || !load.torque.allFinite()) return;
  system_.setBodyGravity(covered.id, gravity);
  system_.setBodyLoad(covered.id, load);
}

Pose Layer::midwayPose(const CoveredBody& covered) const {
  const Pose& start = covered.startPose;
  const Pose end = system_.bodyMotion(covered.id).pose;
  return {0.5 * (start.position + end.position),
          turnBy(0.5 * turnBetween(start.orientation, end.orientation)) * start.orientation};
}

/// About its true centre of mass, each body as it was at the start of the tick; one that joints hold as it is
/// in the middle of it. A pin that holds a turning body moves it along the chord of its arc, at right angles
/// to the lever in mid-tick: with the lever of the tick's start, as Bullet has it, it would leave the arc by
/// r w^2 dt^2 / 2 in every tick.
void Layer::showMassFrames() {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    if (!covered.momentsPerMass && !covered.isShownMidway) continue;
    massFrames_.show(*covered.body, covered.startPose,
                     covered.isShownMidway ? midwayPose(covered) : covered.startPose,
                     toBullet(covered.settings.inverseInertia));
  }
  massFrames_.showContacts(*world_.getDispatcher());
  massFrames_.showJoints(world_, [this](const btRigidBody& body) -> const Pose* {
    const CoveredBody* covered = find(&body);
    const bool shown = covered && covered->make.motion == BodyMotion::Dynamic && covered->momentsPerMass;
    return shown ? &covered->coreFrame : nullptr;
  });
}

/// Gives Bullet's solver the velocity that, with what the solver itself adds for the total force, is the mean
/// one, less what joints have been given in advance: it finds their whole impulses, so that joints break and
/// report as in Bullet. The gyroscopic term is in the core; Bullet would count it again (its flag is on by
/// default).
void Layer::offerMeanMotion(btScalar dt) {
  showMassFrames();
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    btRigidBody& body = *covered.body;
    const btVector3 added = forceImpulse(body, dt);
    const btVector3 turned = torqueImpulse(body, dt);
    covered.meanAngularVelocity.setZero();
    covered.jointImpulse.setZero();
    covered.jointTurn.setZero();
    if (!covered.held) {
      covered.jointImpulse = toBullet(covered.jointLoad.force) * body.getInvMass() * dt;
      covered.jointTurn = body.getInvInertiaTensorWorld() * toBullet(covered.jointLoad.torque) * dt;
      const Pose end = system_.bodyMotion(covered.id).pose;
      covered.meanAngularVelocity = turnBetween(covered.startPose.orientation, end.orientation) / double(dt);
      body.setLinearVelocity(toBullet(Vector3((end.position - covered.startPose.position) / double(dt))) -
                             added - covered.jointImpulse);
      body.setAngularVelocity(toBullet(covered.meanAngularVelocity) - turned - covered.jointTurn);
    }
    covered.flags = body.getFlags();
    body.setFlags(covered.flags &
                  ~(BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT | BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD |
                    BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY));
    covered.offered = stateOf(body);
    covered.expectedVelocity = covered.offered.velocity + added;
    covered.expectedAngularVelocity = covered.offered.angularVelocity + turned;
  }
  jointLoads_.listen(world_, [this](const btRigidBody& body) { return isCovered(body); });
}

void Layer::takeCorrections() {
  jointLoads_.follow();
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
    covered.velocityCorrection =
        changeOf(now.velocity, covered.expectedVelocity, offered.velocity) - fromBullet(covered.jointImpulse);
    covered.angularVelocityCorrection =
        changeOf(now.angularVelocity, covered.expectedAngularVelocity, offered.angularVelocity) -
        fromBullet(covered.jointTurn);
    if (isSame(now.transform, offered.transform)) continue;
    const Pose before = fromBullet(offered.transform);
    const Pose after = fromBullet(now.transform);
    covered.push = {.position = after.position - before.position,
                    .orientation = (after.orientation * before.orientation.conjugate()).normalized()};
  }
  massFrames_.hide();
  noteSolved();
}

/// Bullet's frame again, for what reads and changes velocities before `store`: actions of the program.
void Layer::noteSolved() {
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    btRigidBody& body = *covered.body;
    const bool wasShown = !covered.held || body.isActive();  // a sleeper's velocity is still its owner's
    if (covered.momentsPerMass && wasShown) {
      const Vector3 lever = covered.startPose.orientation * leverOf(covered);
      body.setLinearVelocity(toBullet(Vector3(fromBullet(body.getLinearVelocity()) -
                                              fromBullet(body.getAngularVelocity()).cross(lever))));
    }
    covered.solved = stateOf(body);
  }
}

/// Impulses that actions gave after the solver: Bullet makes them part of the next tick's motion.
bool Layer::addActions(const CoveredBody& covered, RigidMotion& motion) const {
  const BulletState now = stateOf(*covered.body);
  const bool sameVelocity = isSame(now.velocity, covered.solved.velocity);
  const bool sameSpin = isSame(now.angularVelocity, covered.solved.angularVelocity);
  if ((sameVelocity && sameSpin) || !isFinite(now)) return false;
  RigidMotion frame = bulletMotion(covered, motion);
  frame.velocity += fromBullet(now.velocity) - fromBullet(covered.solved.velocity);
  frame.angularVelocity += fromBullet(now.angularVelocity) - fromBullet(covered.solved.angularVelocity);
  motion = coreMotion(covered, frame);
  return true;
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
  BT_PROFILE("granular: store");
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    const bool active = covered.body->isActive();
    if (covered.held && !active) continue;
    RigidMotion motion = system_.bodyMotion(covered.id);
    const bool corrected = isCorrected(covered);
    if (corrected) motion = correctedMotion(covered, dt);
    const bool pushed = addActions(covered, motion);
    if (!active) motion.velocity = motion.angularVelocity = Vector3::Zero();  // fell asleep in this tick
    if (!isFinite(motion)) motion = {.pose = covered.startPose};
    if (corrected || !active || pushed) system_.setBodyMotion(covered.id, motion);
    write(covered, motion);
  }
}

/// Transform last: it copies the velocities into what motion states are extrapolated from.
void Layer::write(CoveredBody& covered, const RigidMotion& core) {
  const RigidMotion motion = bulletMotion(covered, core);
  btRigidBody& body = *covered.body;
  body.setLinearVelocity(toBullet(motion.velocity));
  body.setAngularVelocity(toBullet(motion.angularVelocity));
  body.setCenterOfMassTransform(toBullet(motion.pose));
  covered.written = stateOf(body);
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
