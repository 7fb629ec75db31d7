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
    if (solids_.size() > 1 && solids_[solids_.size() - 2].body->solid == body.solid) {
      solid.parts = solids_[solids_.size() - 2].parts;
      solid.boundingRadius = solids_[solids_.size() - 2].boundingRadius;
      continue;
    }
    auto parts = std::make_shared<Parts>();
    for (const granular::TriangleMesh& part : body.solid->parts) {
      for (const Vector3& v : part.vertices) solid.boundingRadius = std::max(solid.boundingRadius, v.norm());
      parts->emplace_back(part);
    }
    solid.parts = std::move(parts);
  }
}

/// Whether a point of the body frame is inside by more than `depth`, m.
bool PlaceChecks::isInside(const Solid& solid, const Vector3& own, double depth) {
  const BodyShapeDef& shape = solid.body->part->shape;
  if (const auto* sphere = std::get_if<SphereShape>(&shape)) return own.norm() < sphere->radius - depth;
  if (const auto* space = std::get_if<HalfSpaceShape>(&shape))
    return space->normal.dot(own) < space->height - depth;
  if (const auto* box = std::get_if<BoxShape>(&shape)) {
    const Vector3 drawn = solid.body->solid->frame.toWorld(own);
    return (0.5 * box->size - drawn.cwiseAbs()).minCoeff() > depth;
  }
  return std::any_of(solid.parts->begin(), solid.parts->end(), [&](const granular::MeshDistance& part) {
    const Vector3 lower = own - part.bounds().lower;
    const Vector3 upper = part.bounds().upper - own;
    if (std::min(lower.minCoeff(), upper.minCoeff()) <= depth) return false;
    return part.nearest(own).signedDistance < -depth;
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

void PlaceChecks::countInside(const Vector3& p, double radius, const Solid& solid, const Pose& pose,
                              PlaceCounts& counts) const {
  if ((p - pose.position).squaredNorm() > solid.boundingRadius * solid.boundingRadius) return;
  if (!isInside(solid, pose.toOwn(p), radius)) return;
  ++counts.insideBodies;
  if (counts.inside.empty()) counts.inside = solid.body->part->name;
}

void PlaceChecks::countPlace(const Vector3& p, bool isFinite, PlaceCounts& counts) const {
  if (!isFinite) ++counts.notFinite;
  if (!scene_.def().container) return;
  const Box& box = scene_.def().container->box;
  if ((p - box.lower).minCoeff() < 0.0 || (box.upper - p).minCoeff() < 0.0) ++counts.outside;
}

void PlaceChecks::countGrains(PlaceCounts& counts) const {
  std::vector<granular::ParticleView> particles;
  scene_.grains().readParticles(particles);
  std::vector<Pose> poses;
  for (const Solid& solid : solids_) poses.push_back(solid.body->pose());
  for (const granular::ParticleView& p : particles) {
    if (p.ownerKind != granular::OwnerKind::Grain) continue;
    if (isBelowGround(p.position)) ++counts.belowGround;
    for (std::size_t i = 0; i < solids_.size(); ++i)
      countInside(p.position, p.radius, solids_[i], poses[i], counts);
  }
  const auto motions = scene_.grains().grainMotions();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (scene_.grains().grainAt(static_cast<std::int32_t>(i)).index < 0) continue;  // removed
    const Vector3& x = motions[i].pose.position;
    countPlace(x, x.allFinite() && motions[i].velocity.allFinite(), counts);
  }
}

void PlaceChecks::countBodies(PlaceCounts& counts) const {
  std::vector<Pose> poses;
  for (const Solid& solid : solids_) poses.push_back(solid.body->pose());
  for (std::size_t i = 0; i < solids_.size(); ++i) {
    const BuiltBody& body = *solids_[i].body;
    if (body.part->motion != BodyKind::dynamic) continue;
    countPlace(poses[i].position, poses[i].position.allFinite() && poses[i].orientation.coeffs().allFinite(),
               counts);
    const granular::Covering& covering = body.covering->covering;
    for (std::size_t j = 0; j < solids_.size(); ++j) {
      const double reach = solids_[i].boundingRadius + solids_[j].boundingRadius;
      if (j == i || (poses[i].position - poses[j].position).squaredNorm() > reach * reach) continue;
      for (std::size_t k = 0; k < covering.positions.size(); ++k)
        countInside(poses[i].toWorld(covering.positions[k]), covering.radii[k], solids_[j], poses[j], counts);
    }
    for (const Vector3& p : covering.positions) counts.belowGround += isBelowGround(poses[i].toWorld(p));
  }
}

PlaceCounts PlaceChecks::count() const {
  PlaceCounts counts;
  countGrains(counts);
  countBodies(counts);
  return counts;
}

}  // namespace granular_demo
