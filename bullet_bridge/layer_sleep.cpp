// SPDX-License-Identifier: MIT
// Who stays awake, and who is woken: grains are in none of Bullet's islands.
#include <algorithm>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/layer.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

using granular::BodyMotion;
using granular::RigidMotion;
using granular::Vector3;

/// A body stays awake while grains are near it: they are in none of Bullet's islands, so Bullet would let it
/// hang in the air when they flow away. A sleeping one is woken by covered bodies that move near it (their
/// particles may reach beyond the boxes by which Bullet makes islands) and when something covered is taken
/// away or put elsewhere. What sleeps in the core needs none of this: there it rests on what carries it, and
/// wakes when it no longer does. Bullet may put it to sleep in its own time; it wakes with the core.
void Layer::keepAwake(btScalar dt) {
  const bool anyDynamic = std::any_of(bodies_.begin(), bodies_.end(), [](const CoveredBody& covered) {
    return covered.make.motion == BodyMotion::Dynamic;
  });
  if (!anyDynamic) return;
  const double grainRadius = largestGrainRadius();
  for (CoveredBody& covered : bodies_) {
    if (covered.make.motion != BodyMotion::Dynamic) continue;
    const bool restsInCore = !system_.isAwake(covered.id);
    const bool asleep = covered.body->getActivationState() == ISLAND_SLEEPING;
    if (wakeAll_ || (!restsInCore &&
                     (isNearGrains(covered, grainRadius, dt) || (asleep && isNearMovingBody(covered, dt)))))
      wake(covered);
  }
  wakeAll_ = false;
}

/// After the core's step: what slept in both and was woken there has moved, and goes on awake.
void Layer::wakeWithCore() {
  for (CoveredBody& covered : bodies_) {
    if (!covered.sleepsInCore || !system_.isAwake(covered.id)) continue;
    covered.held = covered.sleepsInCore = false;
    wake(covered);
  }
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
/// stepSimulation began has missed its gravity, which Bullet adds to total forces then.
void Layer::wake(CoveredBody& covered) {
  btRigidBody& body = *covered.body;
  const bool slept = !body.isActive();
  body.activate();
  if (!slept || !body.isActive() || !body.getTotalForce().isZero()) return;
  if ((body.getFlags() & BT_DISABLE_WORLD_GRAVITY) == 0) body.setGravity(world_.getGravity());
  body.applyGravity();
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
