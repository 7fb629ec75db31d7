// SPDX-License-Identifier: MIT
#include "demos/runner/place_checks.h"

#include <algorithm>
#include <limits>

namespace granular_demo {

PlaceChecks::PlaceChecks(const BuiltScene& scene) : scene_(scene) {
  for (const BuiltBody& body : scene.bodies()) {
    if (!body.part->meetsGrains() || std::holds_alternative<PlanePatchShape>(body.part->shape)) continue;
    Solid& solid = solids_.emplace_back();
    solid.body = &body;
    if (std::holds_alternative<HalfSpaceShape>(body.part->shape)) {
      solid.boundingRadius = std::numeric_limits<double>::infinity();
      continue;
    }
    for (const granular::TriangleMesh& part : body.solid.parts) {
      for (const Vector3& v : part.vertices) solid.boundingRadius = std::max(solid.boundingRadius, v.norm());
      solid.parts.push_back(std::make_unique<granular::MeshDistance>(part));
    }
  }
}

/// Whether a point of the body frame is inside by more than `depth`, m.
bool PlaceChecks::isInside(const Solid& solid, const Vector3& own, double depth) {
  const BodyShapeDef& shape = solid.body->part->shape;
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return own.norm() < sphere->radius - depth;
  if (const auto* space = std::get_if<HalfSpaceShape>(&shape))
    return space->normal.dot(own) < space->height - depth;
  if (const auto* box = std::get_if<BoxShape>(&shape)) {
    const Vector3 drawn = solid.body->solid.frame.toWorld(own);
    return (0.5 * box->size - drawn.cwiseAbs()).minCoeff() > depth;
  }
  return std::any_of(solid.parts.begin(), solid.parts.end(), [&](const auto& part) {
    const Vector3 lower = own - part->bounds().lower;
    const Vector3 upper = part->bounds().upper - own;
    if (std::min(lower.minCoeff(), upper.minCoeff()) <= depth) return false;
    return part->nearest(own).signedDistance < -depth;
  });
}

Vector3 PlaceChecks::up() const {
  const Vector3& gravity = scene_.def().gravity;
  return gravity.norm() > 0.0 ? Vector3(-gravity.normalized()) : Vector3(Vector3::UnitY());
}

/// What has left the container sideways and falls past the edge of the floor has escaped; it is not below the
/// ground.
bool PlaceChecks::isBelowGround(const Vector3& p) const {
  const SceneDef& def = scene_.def();
  if (!def.groundHeight || up().dot(p) >= *def.groundHeight) return false;
  if (!def.container) return true;
  const Vector3 onFloor = p + (*def.groundHeight - up().dot(p)) * up();
  return (onFloor - def.container->box.lower).minCoeff() >= 0.0 &&
         (def.container->box.upper - onFloor).minCoeff() >= 0.0;
}

PlaceCounts PlaceChecks::count() const {
  PlaceCounts counts;
  std::vector<granular::ParticleView> particles;
  scene_.grains().readParticles(particles);
  std::vector<Pose> poses;
  for (const Solid& solid : solids_) poses.push_back(solid.body->pose());
  for (const granular::ParticleView& p : particles) {
    if (p.ownerKind != granular::OwnerKind::Grain) continue;
    if (isBelowGround(p.position)) ++counts.belowGround;
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      if ((p.position - poses[i].position).squaredNorm() >
          solids_[i].boundingRadius * solids_[i].boundingRadius)
        continue;
      if (isInside(solids_[i], poses[i].toOwn(p.position), p.radius)) ++counts.insideBodies;
    }
  }
  const auto motions = scene_.grains().grainMotions();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (scene_.grains().grainAt(static_cast<std::int32_t>(i)).index < 0) continue;  // removed
    const Vector3& x = motions[i].pose.position;
    if (!x.allFinite() || !motions[i].velocity.allFinite()) ++counts.notFinite;
    if (!scene_.def().container) continue;
    const Box& box = scene_.def().container->box;
    if ((x - box.lower).minCoeff() < 0.0 || (box.upper - x).minCoeff() < 0.0) ++counts.outside;
  }
  return counts;
}

}  // namespace granular_demo
