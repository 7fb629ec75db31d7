// SPDX-License-Identifier: MIT
#include "demos/world/body_solid.h"

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/pose_algebra.h"
#include "bullet_bridge/shape_surface.h"
#include "granular/geometry/mass_properties.h"
#include "granular/geometry/mesh_file.h"
#include "granular/geometry/mesh_primitives.h"
#include "granular/geometry/mesh_repair.h"

namespace granular_demo {
namespace {

using bullet_bridge::composed;
using bullet_bridge::inverse;
using bullet_bridge::toBullet;
using granular::TriangleMesh;

// Sides of a circle: for pictures and coverings, and for mass properties, where 256 are within 1e-4 of round.
constexpr int kSegments = 64;
constexpr int kMassSegments = 256;

TriangleMesh placed(TriangleMesh mesh, const Pose& pose) {
  for (Vector3& v : mesh.vertices) v = pose.toWorld(v);
  return mesh;
}

/// A flat rectangle facing +y.
TriangleMesh patchMesh(const PlanePatchShape& patch) {
  const double x = 0.5 * patch.sizeX;
  const double z = 0.5 * patch.sizeZ;
  return {{{-x, 0, -z}, {-x, 0, z}, {x, 0, z}, {x, 0, -z}}, {{0, 1, 2}, {0, 2, 3}}};
}

/// What pictures show of a half-space.
TriangleMesh halfSpaceMesh(const HalfSpaceShape& space) {
  return placed(patchMesh({space.shownSize, space.shownSize}),
                {space.height * space.normal, Quaternion::FromTwoVectors(Vector3::UnitY(), space.normal)});
}

/// Adds the Bullet shape of a simple solid, in the frame it is drawn in.
class SimpleShape {
 public:
  std::unique_ptr<btCollisionShape> operator()(const BoxShape& s) const {
    return std::make_unique<btBoxShape>(toBullet(Vector3(0.5 * s.size)));
  }
  std::unique_ptr<btCollisionShape> operator()(const SphereShape& s) const {
    return std::make_unique<btSphereShape>(static_cast<btScalar>(s.radius));
  }
  std::unique_ptr<btCollisionShape> operator()(const CapsuleShape& s) const {
    return std::make_unique<btCapsuleShape>(static_cast<btScalar>(s.radius), static_cast<btScalar>(s.height));
  }
  std::unique_ptr<btCollisionShape> operator()(const CylinderShape& s) const {
    return std::make_unique<btCylinderShape>(toBullet(Vector3(s.radius, 0.5 * s.height, s.radius)));
  }
  std::unique_ptr<btCollisionShape> operator()(const ConeShape& s) const {
    return std::make_unique<btConeShape>(static_cast<btScalar>(s.radius), static_cast<btScalar>(s.height));
  }
  std::unique_ptr<btCollisionShape> operator()(const HalfSpaceShape& s) const {
    return std::make_unique<btStaticPlaneShape>(toBullet(s.normal), static_cast<btScalar>(s.height));
  }
  template <class Other>
  std::unique_ptr<btCollisionShape> operator()(const Other&) const {
    return nullptr;
  }
};

/// The surfaces of a shape in the frame it is drawn in, moved by `pose`.
void addParts(const BodyShapeDef& def, const Pose& pose, int segments, std::vector<TriangleMesh>& parts) {
  if (const auto* mesh = std::get_if<MeshShape>(&def)) {
    parts.push_back(placed(readSolidMesh(*mesh), pose));
  } else if (const auto* patch = std::get_if<PlanePatchShape>(&def)) {
    parts.push_back(placed(patchMesh(*patch), pose));
  } else if (const auto* space = std::get_if<HalfSpaceShape>(&def)) {
    parts.push_back(placed(halfSpaceMesh(*space), pose));
  } else if (const auto* compound = std::get_if<CompoundShape>(&def)) {
    for (const ShapeChild& child : compound->children) {
      addParts(child.shape, composed(pose, child.pose), segments, parts);
    }
  } else {
    const std::unique_ptr<btCollisionShape> shape = std::visit(SimpleShape{}, def);
    for (bullet_bridge::ShapePart& part :
         bullet_bridge::shapeParts(*shape, {.segments = segments, .plane = {}})) {
      parts.push_back(placed(std::move(part.mesh), pose));
    }
  }
}

TriangleMesh joined(const std::vector<TriangleMesh>& parts) {
  TriangleMesh mesh;
  for (const TriangleMesh& part : parts) granular::append(mesh, part);
  return mesh;
}

void setMassProperties(const BodyShapeDef& def, BodySolid& solid) {
  if (const auto* sphere = std::get_if<SphereShape>(&def)) {
    const double r = sphere->radius;
    solid.volume = 4.0 / 3.0 * std::numbers::pi * r * r * r;
    solid.unitInertia = Vector3::Constant(0.4 * solid.volume * r * r);
    return;
  }
  if (std::holds_alternative<PlanePatchShape>(def) || std::holds_alternative<HalfSpaceShape>(def)) return;
  std::vector<TriangleMesh> fine;
  addParts(def, {}, kMassSegments, fine);
  const granular::MassProperties properties = granular::massProperties(joined(fine), 1.0);
  solid.frame = properties.principalFrame;
  solid.volume = properties.volume;
  solid.unitInertia = properties.principalMoments;
}

std::unique_ptr<btCollisionShape> hullShape(const TriangleMesh& mesh) {
  auto hull = std::make_unique<btConvexHullShape>();
  for (const Vector3& v : mesh.vertices) hull->addPoint(toBullet(v), false);
  hull->recalcLocalAabb();
  hull->optimizeConvexHull();
  return hull;
}

std::unique_ptr<btCollisionShape> triangleShape(const TriangleMesh& mesh, BodySolid& solid) {
  auto triangles = std::make_unique<btTriangleMesh>();
  for (const auto& t : mesh.triangles) {
    triangles->addTriangle(toBullet(mesh.vertices[t[0]]), toBullet(mesh.vertices[t[1]]),
                           toBullet(mesh.vertices[t[2]]));
  }
  auto shape = std::make_unique<btBvhTriangleMeshShape>(triangles.get(), true);
  solid.triangles.push_back(std::move(triangles));
  return shape;
}

/// Collects the Bullet shapes of all children, flat, in the body's frame.
void addToCompound(const BodyShapeDef& def, const Pose& pose, BodyKind motion, BodySolid& solid,
                   btCompoundShape& compound) {
  if (const auto* group = std::get_if<CompoundShape>(&def)) {
    for (const ShapeChild& child : group->children) {
      addToCompound(child.shape, composed(pose, child.pose), motion, solid, compound);
    }
    return;
  }
  std::unique_ptr<btCollisionShape> shape = std::visit(SimpleShape{}, def);
  if (!shape) {
    std::vector<TriangleMesh> parts;
    addParts(def, {}, kSegments, parts);
    shape = motion == BodyKind::dynamic ? hullShape(parts.front()) : triangleShape(parts.front(), solid);
  }
  compound.addChildShape(toBullet(pose), shape.get());
  solid.shapes.push_back(std::move(shape));
}

bool isIdentity(const Pose& pose) {
  return pose.position.norm() == 0.0 && pose.orientation.vec().norm() == 0.0;
}

void setBulletShape(const BodyShapeDef& def, BodyKind motion, BodySolid& solid) {
  if (std::unique_ptr<btCollisionShape> simple = std::visit(SimpleShape{}, def);
      simple && isIdentity(solid.frame)) {
    solid.shapes.push_back(std::move(simple));
    return;
  }
  auto compound = std::make_unique<btCompoundShape>();
  addToCompound(def, inverse(solid.frame), motion, solid, *compound);
  solid.shapes.push_back(std::move(compound));
}

}  // namespace

granular::TriangleMesh readSolidMesh(const MeshShape& shape) {
  TriangleMesh mesh = granular::readMeshFile(shape.file);
  try {
    mesh = granular::repairMesh(mesh);
  } catch (const std::invalid_argument& error) {
    std::string faults = error.what();
    std::replace(faults.begin(), faults.end(), '\n', ';');
    throw std::runtime_error(shape.file.string() + ": " + faults);
  }
  const Box box = granular::boundingBox(mesh);
  const double scale = shape.boundingSize ? *shape.boundingSize / box.size().norm() : shape.scale;
  const Vector3 shift = shape.center ? Vector3(*shape.center - scale * box.center()) : Vector3::Zero();
  for (Vector3& v : mesh.vertices) v = scale * v + shift;
  return mesh;
}

BodySolid makeBodySolid(const BodyShapeDef& shape, BodyKind motion, BodyAxes axes) {
  BodySolid solid;
  setMassProperties(shape, solid);
  if (axes == BodyAxes::drawn)
    solid.frame.orientation.setIdentity();  // the moments are no longer the shape's
  addParts(shape, inverse(solid.frame), kSegments, solid.parts);
  setBulletShape(shape, motion, solid);
  return solid;
}

Box boundsOf(const BodyShapeDef& shape) {
  std::vector<TriangleMesh> parts;
  addParts(shape, {}, kSegments, parts);
  return granular::boundingBox(joined(parts));
}

granular::TriangleMesh joinedMesh(const BodySolid& solid) {
  return joined(solid.parts);
}

}  // namespace granular_demo
