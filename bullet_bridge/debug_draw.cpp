// SPDX-License-Identifier: MIT
// Every k-th particle or contact is drawn when there are more than the limit, so that the picture stays even.
#include "bullet_bridge/debug_draw.h"

#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <vector>

#include "bullet_bridge/convert.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace {

constexpr std::size_t kSphereLimit = 500;

void drawCross(btIDebugDraw& drawer, const btVector3& center, btScalar radius, const btVector3& color) {
  for (int axis = 0; axis < 3; ++axis) {
    btVector3 arm(0, 0, 0);
    arm[axis] = radius;
    drawer.drawLine(center - arm, center + arm, color);
  }
}

void drawParticles(btIDebugDraw& drawer, const granular::GranularSystem& system, int limit) {
  std::vector<granular::ParticleView> particles;
  system.readParticles(particles);
  const std::size_t stride = (particles.size() + limit - 1) / limit;
  const bool asSpheres = particles.size() / std::max<std::size_t>(stride, 1) <= kSphereLimit;
  const btVector3 sand(btScalar(0.9), btScalar(0.75), btScalar(0.45));
  const btVector3 body(btScalar(0.5), btScalar(0.6), btScalar(0.7));
  for (std::size_t i = 0; i < particles.size(); i += stride) {
    const granular::ParticleView& p = particles[i];
    const btVector3& color = p.ownerKind == granular::OwnerKind::Grain ? sand : body;
    const btVector3 center = toBullet(p.position);
    const auto radius = static_cast<btScalar>(p.radius);
    if (asSpheres) {
      drawer.drawSphere(center, radius, color);
    } else {
      drawCross(drawer, center, radius, color);
    }
  }
}

void drawContacts(btIDebugDraw& drawer, granular::GranularSystem& system, int limit) {
  std::vector<granular::ContactView> contacts;
  system.readContacts(contacts);
  const std::size_t stride = (contacts.size() + limit - 1) / limit;
  const btVector3 red(1, btScalar(0.2), btScalar(0.2));
  for (std::size_t i = 0; i < contacts.size(); i += stride) {
    const granular::ContactView& contact = contacts[i];
    const granular::Vector3 normal = contact.force.normalized();  // zero stays zero
    drawer.drawContactPoint(toBullet(contact.point), toBullet(normal),
                            static_cast<btScalar>(-contact.overlap), 0, red);
  }
}

}  // namespace

void drawSand(btIDebugDraw& drawer, granular::GranularSystem& system, int limit) {
  if (limit <= 0) return;
  const int mode = drawer.getDebugMode();
  if ((mode & btIDebugDraw::DBG_DrawWireframe) != 0) drawParticles(drawer, system, limit);
  if ((mode & btIDebugDraw::DBG_DrawContactPoints) != 0) drawContacts(drawer, system, limit);
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
