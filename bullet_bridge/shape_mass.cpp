// SPDX-License-Identifier: MIT
// Each shape at density 1; the mass comes last.
#include "bullet_bridge/shape_mass.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <numbers>

#include "bullet_bridge/convert.h"
#include "granular/base/require.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace {

using granular::MassProperties;
using granular::Matrix3;
using granular::Vector3;

constexpr double kPi = std::numbers::pi;
constexpr int kSegments = 256;  // the inertia of a 256-sided prism is 2e-4 short of the cylinder's

/// A solid of density 1 with these moments about its centre; `along` about `axis`, `across` about the others.
MassProperties round(double volume, int axis, double along, double across) {
  MassProperties solid;
  solid.volume = volume;
  solid.inertia.diagonal().setConstant(across);
  solid.inertia(axis, axis) = along;
  return solid;
}

MassProperties boxMass(const btBoxShape& box) {
  const Vector3 half = fromBullet(box.getHalfExtentsWithMargin());
  const Vector3 squares = half.cwiseAbs2();
  MassProperties solid;
  solid.volume = 8.0 * half.prod();
  solid.inertia.diagonal() = solid.volume / 3.0 * (Vector3::Constant(squares.sum()) - squares);
  return solid;
}

MassProperties sphereMass(double radius) {
  const double volume = 4.0 / 3.0 * kPi * radius * radius * radius;
  return round(volume, 0, 0.4 * volume * radius * radius, 0.4 * volume * radius * radius);
}

MassProperties cylinderMass(double radius, double height, int axis) {
  const double volume = kPi * radius * radius * height;
  return round(volume, axis, volume * radius * radius / 2.0,
               volume * (3.0 * radius * radius + height * height) / 12.0);
}

/// A half ball has its centre 3/8 of the radius from its flat face.
MassProperties capsuleMass(double radius, double length, int axis) {
  const MassProperties middle = cylinderMass(radius, length, axis);
  const MassProperties ends = sphereMass(radius);
  const double lever = length * length / 4.0 + 3.0 / 8.0 * length * radius;
  const int other = (axis + 1) % 3;
  return round(middle.volume + ends.volume, axis, middle.inertia(axis, axis) + ends.inertia(axis, axis),
               middle.inertia(other, other) + ends.inertia(other, other) + ends.volume * lever);
}

/// The frame's origin is halfway up; the centre of mass a quarter of the height above the base.
MassProperties coneMass(double radius, double height, int axis) {
  const double volume = kPi * radius * radius * height / 3.0;
  MassProperties solid = round(volume, axis, 0.3 * volume * radius * radius,
                               3.0 / 80.0 * volume * (4.0 * radius * radius + height * height));
  solid.centerOfMass[axis] = -height / 4.0;
  return solid;
}

/// Sum of solids, each about its own centre of mass and in the same frame.
class MassSum {
 public:
  void add(const MassProperties& solid) {
    sum_.volume += solid.volume;
    moment_ += solid.volume * solid.centerOfMass;
    aboutOrigin_ += solid.inertia + solid.volume * shift(solid.centerOfMass);
  }
  MassProperties total() {
    sum_.centerOfMass = moment_ / sum_.volume;
    sum_.inertia = aboutOrigin_ - sum_.volume * shift(sum_.centerOfMass);
    return sum_;
  }

 private:
  /// Inertia of a unit mass at p.
  static Matrix3 shift(const Vector3& p) { return p.squaredNorm() * Matrix3::Identity() - p * p.transpose(); }

  MassProperties sum_;
  Vector3 moment_ = Vector3::Zero();
  Matrix3 aboutOrigin_ = Matrix3::Zero();
};

MassProperties placed(MassProperties solid, const btTransform& transform) {
  const granular::Pose pose = fromBullet(transform);
  const Matrix3 turn = pose.orientation.toRotationMatrix();
  solid.centerOfMass = pose.toWorld(solid.centerOfMass);
  solid.inertia = turn * solid.inertia * turn.transpose();
  return solid;
}

MassProperties unitMass(const btCollisionShape& shape);

template <class Compound>
MassProperties compoundMass(const Compound& compound) {
  granular::require(compound.getNumChildShapes() > 0, "shapeMass: the number of the compound's children",
                    compound.getNumChildShapes(), "", "> 0");
  MassSum sum;
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    sum.add(placed(unitMass(*compound.getChildShape(i)), compound.getChildTransform(i)));
  }
  return sum.total();
}

MassProperties scaledMass(const btUniformScalingShape& scaled) {
  const double factor = scaled.getUniformScalingFactor();
  MassProperties solid = unitMass(*scaled.getChildShape());
  solid.volume *= factor * factor * factor;
  solid.centerOfMass *= factor;
  solid.inertia *= factor * factor * factor * factor * factor;
  return solid;
}

MassProperties meshMass(const btCollisionShape& shape) {
  return granular::massProperties(shapeSurface(shape, {.segments = kSegments}), 1.0);
}

MassProperties unitMass(const btCollisionShape& shape) {
  switch (shape.getShapeType()) {
    case BOX_SHAPE_PROXYTYPE:
      return boxMass(static_cast<const btBoxShape&>(shape));
    case SPHERE_SHAPE_PROXYTYPE:
      return sphereMass(static_cast<const btSphereShape&>(shape).getRadius());
    case CAPSULE_SHAPE_PROXYTYPE: {
      const auto& capsule = static_cast<const btCapsuleShape&>(shape);
      return capsuleMass(capsule.getRadius(), 2.0 * capsule.getHalfHeight(), capsule.getUpAxis());
    }
    case CYLINDER_SHAPE_PROXYTYPE: {
      const auto& cylinder = static_cast<const btCylinderShape&>(shape);
      const int axis = cylinder.getUpAxis();
      return cylinderMass(cylinder.getRadius(), 2.0 * cylinder.getHalfExtentsWithMargin()[axis], axis);
    }
    case CONE_SHAPE_PROXYTYPE: {
      const auto& cone = static_cast<const btConeShape&>(shape);
      return coneMass(cone.getRadius(), cone.getHeight(), cone.getConeUpIndex());
    }
    case UNIFORM_SCALING_SHAPE_PROXYTYPE:
      return scaledMass(static_cast<const btUniformScalingShape&>(shape));
    case COMPOUND_SHAPE_PROXYTYPE:
      return compoundMass(static_cast<const btCompoundShape&>(shape));
    case GIMPACT_SHAPE_PROXYTYPE:
      if (static_cast<const btGImpactShapeInterface&>(shape).getGImpactShapeType() ==
          CONST_GIMPACT_COMPOUND_SHAPE) {
        return compoundMass(static_cast<const btGImpactCompoundShape&>(shape));
      }
      return meshMass(shape);
    default:
      return meshMass(shape);
  }
}

MassProperties ofMass(MassProperties solid, double mass) {
  solid.inertia *= mass / solid.volume;
  solid.mass = mass;
  granular::findPrincipalFrame(solid);
  return solid;
}

}  // namespace

MassProperties shapeMass(const btCollisionShape& shape, double mass) {
  granular::requirePositive(mass, "shapeMass: mass", "kg");
  return ofMass(unitMass(shape), mass);
}

MassProperties surfaceMass(const granular::TriangleMesh& mesh, double mass) {
  granular::requirePositive(mass, "surfaceMass: mass", "kg");
  return ofMass(granular::massProperties(mesh, 1.0), mass);
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
