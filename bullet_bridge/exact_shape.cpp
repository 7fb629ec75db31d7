// SPDX-License-Identifier: MIT
#include "bullet_bridge/exact_shape.h"

#include <stdexcept>
#include <string>

#include "bullet_bridge/convert.h"
#include "granular/base/require.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {
namespace {

using granular::Vector3;

/// Bullet: solid where normal . x < constant. The core: solid where y < 0.
ExactShape planeShape(const btStaticPlaneShape& plane) {
  const Vector3 normal = fromBullet(plane.getPlaneNormal()).normalized();
  return {.surface = granular::HalfSpace{},
          .frame = {.position = double(plane.getPlaneConstant()) * normal,
                    .orientation = granular::Quaternion::FromTwoVectors(Vector3::UnitY(), normal)}};
}

ExactShape sphereShape(const btSphereShape& sphere) {
  const double radius = sphere.getRadius();
  return {.surface = granular::ExactSphere{radius}, .frame = {}, .boundingRadius = radius};
}

}  // namespace

ExactShape exactShape(const btRigidBody& body) {
  const btCollisionShape& shape = *body.getCollisionShape();
  switch (shape.getShapeType()) {
    case STATIC_PLANE_PROXYTYPE:
      granular::require(body.isStaticOrKinematicObject(), "coverBody: the body of an exact plane", "dynamic",
                        "", "static or kinematic");
      return planeShape(static_cast<const btStaticPlaneShape&>(shape));
    case SPHERE_SHAPE_PROXYTYPE:
      return sphereShape(static_cast<const btSphereShape&>(shape));
    default:
      throw std::invalid_argument(
          std::string("CoverBodyDef.contact is Exact for a collision shape ") + shape.getName() +
          "; exact contact is for btSphereShape and btStaticPlaneShape: give SurfaceContact::Particles");
  }
}

void checkExactDef(const CoverBodyDef& def) {
  const auto refuse = [](bool isSet, const char* field) {
    granular::require(!isSet, field, "given", "", "left out where CoverBodyDef.contact is Exact");
  };
  refuse(def.covering.has_value(), "CoverBodyDef.covering");
  refuse(def.surface.has_value(), "CoverBodyDef.surface");
  refuse(def.offset.has_value(), "CoverBodyDef.offset");
  refuse(def.density.has_value(), "CoverBodyDef.density");
  refuse(def.particleRadius != 0.0, "CoverBodyDef.particleRadius");
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
