// SPDX-License-Identifier: MIT
// What a program may know of the sand: contacts, forces, rays, poses between ticks, and grains in Bullet's
// queries.
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bullet_bridge/layer.h"
#include "bullet_bridge/pose_algebra.h"
#include "granular/base/require.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

using granular::OwnerKind;
using granular::Vector3;

/// How far motion states are carried on beyond the last tick (btDiscreteDynamicsWorld::
/// synchronizeSingleMotionState); a tick back where the program asks for latency.
struct WorldTime : btDiscreteDynamicsWorld {
  static double aheadOf(const btDiscreteDynamicsWorld& world) {
    const btScalar time = world.*&WorldTime::m_localTime;
    const btScalar tick = world.*&WorldTime::m_fixedTimeStep;
    return world.getLatencyMotionStateInterpolation() && tick != 0 ? time - tick : time;
  }
};

/// Where a ray p + s (q - p), 0 <= s <= 1, enters a ball; 0 if it begins within, more than 1 if it misses.
double entry(const Vector3& from, const Vector3& way, const Vector3& center, double radius) {
  constexpr double kMiss = 2.0;
  const Vector3 away = from - center;
  const double a = way.squaredNorm();
  const double b = way.dot(away);
  const double c = away.squaredNorm() - radius * radius;
  if (c <= 0.0) return 0.0;
  const double under = b * b - a * c;
  if (b >= 0.0 || under < 0.0) return kMiss;
  return (-b - std::sqrt(under)) / a;
}

}  // namespace

void Layer::readContacts(std::vector<BodyContact>& contacts) {
  contacts.clear();
  if (bodies_.empty()) return;
  std::vector<const btRigidBody*> bodyAt;  // by BodyId::index
  for (const CoveredBody& covered : bodies_) {
    const auto index = static_cast<std::size_t>(covered.id.index);
    if (bodyAt.size() <= index) bodyAt.resize(index + 1, nullptr);
    bodyAt[index] = covered.body;
  }
  const auto bodyOf = [&](OwnerKind kind, std::int32_t index) -> const btRigidBody* {
    const auto place = static_cast<std::size_t>(index);
    return kind == OwnerKind::Body && place < bodyAt.size() ? bodyAt[place] : nullptr;
  };
  std::vector<granular::ContactView> views;
  system_.readContacts(views);
  for (const granular::ContactView& view : views) {
    const btRigidBody* first = bodyOf(view.ownerKind[0], view.ownerIndex[0]);
    const btRigidBody* second = bodyOf(view.ownerKind[1], view.ownerIndex[1]);
    if (!first && !second) continue;
    const int side = first ? 0 : 1;
    BodyContact contact{.body = first ? first : second,
                        .other = first ? second : nullptr,
                        .grain = {},
                        .point = view.point,
                        .force = side == 0 ? view.force : Vector3(-view.force),
                        .overlap = view.overlap};
    if (view.ownerKind[1 - side] == OwnerKind::Grain)
      contact.grain = system_.grainAt(view.ownerIndex[1 - side]);
    contacts.push_back(contact);
  }
}

granular::Wrench Layer::contactForce(const btRigidBody& body) {
  const CoveredBody* covered = find(&body);
  if (!covered) throw std::invalid_argument("contactForce: the body is not covered");
  if (covered->make.motion == granular::BodyMotion::Static) return system_.contactWrench(covered->id);
  if (lastTick_ == 0.0) return {};
  const granular::Wrench impulse = system_.contactImpulse(covered->id);
  return {.force = impulse.force / lastTick_, .torque = impulse.torque / lastTick_};
}

std::optional<GrainHit> Layer::castRay(const Vector3& from, const Vector3& to) const {
  granular::requireFinite(from, "castRay: from", "m");
  granular::requireFinite(to, "castRay: to", "m");
  std::vector<granular::ParticleView> particles;
  system_.readParticles(particles);
  std::optional<GrainHit> best;
  for (const granular::ParticleView& particle : particles) {
    if (particle.ownerKind != OwnerKind::Grain) break;  // grains come first
    const double fraction = entry(from, to - from, particle.position, particle.radius);
    if (fraction > 1.0 || (best && fraction >= best->fraction)) continue;
    const Vector3 point = from + fraction * (to - from);
    best = GrainHit{.grain = system_.grainAt(particle.ownerIndex),
                    .fraction = fraction,
                    .point = point,
                    .normal = (point - particle.position).normalized()};
  }
  return best;
}

void Layer::readGrainPoses(std::vector<granular::Pose>& poses) const {
  poses.clear();
  const double ahead = WorldTime::aheadOf(world_);
  const auto motions = system_.grainMotions();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (system_.grainAt(static_cast<std::int32_t>(i)).index < 0) continue;
    const granular::RigidMotion& motion = motions[i];
    poses.push_back({.position = motion.pose.position + motion.velocity * ahead,
                     .orientation = turnBy(motion.angularVelocity * ahead) * motion.pose.orientation});
  }
}

void Layer::showGrainsToQueries(int group, int mask) {
  hideGrainsFromQueries();
  queries_ = std::make_unique<GrainQueries>(world_, group, mask);
  queries_->update(system_);
}

void Layer::hideGrainsFromQueries() {
  queries_.reset();
}

std::optional<granular::GrainId> Layer::grainOf(const btCollisionObject* object, int childIndex) const {
  return queries_ ? queries_->grainOf(object, childIndex, system_) : std::nullopt;
}

/// The end of a tick with sand.
void Layer::tellWhatCame() {
  BT_PROFILE("granular: contacts and queries");
  if (queries_) queries_->update(system_);
  if (!contactListener_) return;
  readContacts(contacts_);
  contactListener_(contacts_);
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
