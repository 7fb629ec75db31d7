// SPDX-License-Identifier: MIT
#include "bullet_bridge/exact_shape.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/shape_surface.h"
#include "granular/base/require.h"
#include "granular/geometry/mesh_field.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

using granular::Vector3;

/// How far from a mesh there are samples, in their spacing: grains of twice the spacing may sink in whole.
constexpr double kSamplesToReach = 4.0;

/// Bullet: solid where normal . x < constant. The core: solid where y < 0.
ExactShape planeShape(const btStaticPlaneShape& plane) {
  const Vector3 normal = fromBullet(plane.getPlaneNormal()).normalized();
  return {.surface = granular::HalfSpace{},
          .frame = {.position = double(plane.getPlaneConstant()) * normal,
                    .orientation = granular::Quaternion::FromTwoVectors(Vector3::UnitY(), normal)}};
}

/// The core's capsules and cylinders stand along y.
granular::Pose alongAxis(int axis) {
  return {.position = Vector3::Zero(),
          .orientation = granular::Quaternion::FromTwoVectors(Vector3::UnitY(), Vector3::Unit(axis))};
}

ExactShape withRadius(ExactShape shape) {
  shape.boundingRadius = granular::boundingRadius(shape.surface);
  return shape;
}

ExactShape boxShape(const btBoxShape& box) {
  return withRadius({.surface = granular::ExactBox{fromBullet(box.getHalfExtentsWithMargin())}});
}

ExactShape sphereShape(const btSphereShape& sphere) {
  return withRadius({.surface = granular::ExactSphere{sphere.getRadius()}});
}

ExactShape capsuleShape(const btCapsuleShape& capsule) {
  return withRadius({.surface = granular::ExactCapsule{capsule.getRadius(), capsule.getHalfHeight()},
                     .frame = alongAxis(capsule.getUpAxis())});
}

ExactShape cylinderShape(const btCylinderShape& cylinder) {
  const Vector3 half = fromBullet(cylinder.getHalfExtentsWithMargin());
  return withRadius({.surface = granular::ExactCylinder{cylinder.getRadius(), half[cylinder.getUpAxis()]},
                     .frame = alongAxis(cylinder.getUpAxis())});
}

ExactShape meshShape(const btCollisionShape& shape, const CoverBodyDef& def, double spacing, int threads) {
  const std::vector<ShapePart> parts =
      def.surface ? std::vector{partOf(*def.surface)} : shapeParts(shape, def.shapeSurface);
  if (parts.size() != 1 || parts.front().kind != PartKind::Solid) {
    const char* asked = def.contact == SurfaceContact::Exact ? "CoverBodyDef.contact is Exact"
                                                             : "CoverBodyDef.meetBodies is Surface";
    throw std::invalid_argument(std::string(asked) + " for a collision shape " + shape.getName() +
                                (parts.size() == 1 ? " without an inside" : " of several parts") +
                                "; exact contact is for planes and for shapes of one closed part: give "
                                "SurfaceContact::Particles");
  }
  const granular::MeshFieldDef field{
      .spacing = spacing, .reach = kSamplesToReach * spacing, .threads = threads};
  return withRadius(
      {.surface = granular::ExactMesh{std::make_shared<granular::MeshField>(parts.front().mesh, field)}});
}

}  // namespace

ExactShape exactShape(const btRigidBody& body, const CoverBodyDef& def, double spacing, int threads) {
  const btCollisionShape& shape = *body.getCollisionShape();
  if (def.surface) return meshShape(shape, def, spacing, threads);
  switch (shape.getShapeType()) {
    case STATIC_PLANE_PROXYTYPE:
      granular::require(body.isStaticOrKinematicObject(), "coverBody: the body of an exact plane", "dynamic",
                        "", "static or kinematic");
      return planeShape(static_cast<const btStaticPlaneShape&>(shape));
    case BOX_SHAPE_PROXYTYPE:
      return boxShape(static_cast<const btBoxShape&>(shape));
    case SPHERE_SHAPE_PROXYTYPE:
      return sphereShape(static_cast<const btSphereShape&>(shape));
    case CAPSULE_SHAPE_PROXYTYPE:
      return capsuleShape(static_cast<const btCapsuleShape&>(shape));
    case CYLINDER_SHAPE_PROXYTYPE:
      return cylinderShape(static_cast<const btCylinderShape&>(shape));
    default:
      return meshShape(shape, def, spacing, threads);
  }
}

bool meetsBodiesExactly(const btRigidBody& body, const CoverBodyDef& def) {
  if (def.meetBodies != MeetBodies::Automatic) return def.meetBodies == MeetBodies::Surface;
  if (def.covering) return false;
  if (def.surface) return partOf(*def.surface).kind == PartKind::Solid;
  switch (body.getCollisionShape()->getShapeType()) {
    case STATIC_PLANE_PROXYTYPE:
    case BOX_SHAPE_PROXYTYPE:
    case SPHERE_SHAPE_PROXYTYPE:
    case CAPSULE_SHAPE_PROXYTYPE:
    case CYLINDER_SHAPE_PROXYTYPE:
      return true;
    default: {
      const std::vector<ShapePart> parts = shapeParts(*body.getCollisionShape(), def.shapeSurface);
      return parts.size() == 1 && parts.front().kind == PartKind::Solid;
    }
  }
}

void checkExactDef(const CoverBodyDef& def) {
  const auto refuse = [](bool isSet, const char* field) {
    granular::require(!isSet, field, "given", "", "left out where CoverBodyDef.contact is Exact");
  };
  refuse(def.covering.has_value(), "CoverBodyDef.covering");
  refuse(def.offset.has_value(), "CoverBodyDef.offset");
  refuse(def.density.has_value(), "CoverBodyDef.density");
  refuse(def.particleRadius != 0.0, "CoverBodyDef.particleRadius");
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
