// SPDX-License-Identifier: MIT
#include "bullet_bridge/grain_queries.h"

#include "bullet_bridge/convert.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

GrainQueries::GrainQueries(btDiscreteDynamicsWorld& world, int group, int mask)
    : world_(world), group_(group), mask_(mask) {}

GrainQueries::~GrainQueries() {
  if (inWorld_) world_.removeRigidBody(&body_);
}

btSphereShape* GrainQueries::sphere(double radius) {
  auto& shape = spheres_[radius];
  if (!shape) shape = std::make_unique<btSphereShape>(static_cast<btScalar>(radius));
  return shape.get();
}

void GrainQueries::update(const granular::GranularSystem& system) {
  std::vector<granular::ParticleView> particles;
  system.readParticles(particles);
  int child = 0;
  owner_.clear();
  for (const granular::ParticleView& particle : particles) {
    if (particle.ownerKind != granular::OwnerKind::Grain) break;  // grains come first
    btSphereShape* const ball = sphere(particle.radius);
    const btTransform place(btMatrix3x3::getIdentity(), toBullet(particle.position));
    if (child < compound_.getNumChildShapes() && compound_.getChildShape(child) == ball) {
      compound_.updateChildTransform(child, place, false);
    } else {
      while (compound_.getNumChildShapes() > child) {
        compound_.removeChildShapeByIndex(compound_.getNumChildShapes() - 1);
      }
      compound_.addChildShape(place, ball);
    }
    owner_.push_back(particle.ownerIndex);
    ++child;
  }
  while (compound_.getNumChildShapes() > child) {
    compound_.removeChildShapeByIndex(compound_.getNumChildShapes() - 1);
  }
  compound_.recalculateLocalAabb();
  if (inWorld_ && child == 0) world_.removeRigidBody(&body_);
  if (!inWorld_ && child > 0) world_.addRigidBody(&body_, group_, mask_);
  inWorld_ = child > 0;
  if (inWorld_) world_.updateSingleAabb(&body_);
}

std::optional<granular::GrainId> GrainQueries::grainOf(const btCollisionObject* object, int childIndex,
                                                       const granular::GranularSystem& system) const {
  if (object != &body_ || childIndex < 0 || childIndex >= static_cast<int>(owner_.size()))
    return std::nullopt;
  return system.grainAt(owner_[static_cast<std::size_t>(childIndex)]);
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
