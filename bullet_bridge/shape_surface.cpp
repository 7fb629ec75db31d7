// SPDX-License-Identifier: MIT
// One small function for each shape; the switch at the end is the list of what is known.
// What each type keeps where (margin inside or outside, scaled or not) is read from Bullet 3.24's headers.
#include "bullet_bridge/shape_surface.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btConeShape.h>
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMultiSphereShape.h>
#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <LinearMath/btConvexHullComputer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "bullet_bridge/concave_surface.h"
#include "bullet_bridge/convert.h"
#include "granular/base/require.h"
#include "granular/geometry/mesh_primitives.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace {

using granular::TriangleMesh;
using granular::Vector3;

/// A mesh made along z, turned so that z becomes the given axis (a cyclic change of names: no mirror).
TriangleMesh alongAxis(TriangleMesh mesh, int axis) {
  for (Vector3& v : mesh.vertices) {
    const Vector3 p = v;
    for (int i = 0; i < 3; ++i) v[(axis + 1 + i) % 3] = p[i];
  }
  return mesh;
}

ShapePart placed(ShapePart part, const btTransform& transform) {
  const granular::Pose pose = fromBullet(transform);
  for (Vector3& v : part.mesh.vertices) v = pose.toWorld(v);
  part.up = pose.orientation * part.up;
  return part;
}

/// Icosphere with about as many sides round the equator as asked: 5 x 2^n edges make a great circle.
TriangleMesh ball(double radius, int segments) {
  const int subdivisions = static_cast<int>(std::ceil(std::log2(segments / 5.0)));
  return granular::makeIcosphere(radius, std::clamp(subdivisions, 1, 6));
}

/// Exact hull: Bullet's hull computer says which of the given points are corners; the points themselves are
/// used, as its own vertices are rounded to 1e-4 of the size.
TriangleMesh hullOf(const std::vector<Vector3>& points, const char* name) {
  btConvexHullComputer hull;
  if (points.size() >= 4)
    hull.compute(points[0].data(), sizeof(Vector3), static_cast<int>(points.size()), 0, 0);
  if (hull.faces.size() < 4) {
    throw std::invalid_argument(std::string("collision shape ") + name + " has " +
                                std::to_string(points.size()) +
                                " vertices in one plane or fewer than 4; it must enclose a volume");
  }
  TriangleMesh mesh;
  for (int i = 0; i < hull.vertices.size(); ++i)
    mesh.vertices.push_back(points[hull.original_vertex_index[i]]);
  for (int face = 0; face < hull.faces.size(); ++face) {
    const btConvexHullComputer::Edge* first = &hull.edges[hull.faces[face]];
    const int corner = first->getSourceVertex();
    for (const auto* edge = first->getNextEdgeOfFace(); edge->getTargetVertex() != corner;
         edge = edge->getNextEdgeOfFace()) {
      mesh.triangles.push_back({corner, edge->getSourceVertex(), edge->getTargetVertex()});
    }
  }
  if (granular::signedVolume(mesh) < 0.0) granular::turnInsideOut(mesh);
  return mesh;
}

TriangleMesh boxSurface(const btBoxShape& box) {
  return granular::makeBox(2.0 * fromBullet(box.getHalfExtentsWithMargin()));
}

TriangleMesh sphereSurface(const btSphereShape& sphere, int segments) {
  return ball(sphere.getRadius(), segments);
}

TriangleMesh capsuleSurface(const btCapsuleShape& capsule, int segments) {
  return alongAxis(granular::makeCapsule(capsule.getRadius(), 2.0 * capsule.getHalfHeight(), segments),
                   capsule.getUpAxis());
}

/// The two half extents across the axis differ under uneven scaling: Bullet's cylinder takes getRadius() for
/// both.
TriangleMesh cylinderSurface(const btCylinderShape& cylinder, int segments) {
  const int axis = cylinder.getUpAxis();
  return alongAxis(
      granular::makeCylinder(cylinder.getRadius(), 2.0 * cylinder.getHalfExtentsWithMargin()[axis], segments),
      axis);
}

/// Margin is outside the cone, like that of a hull: left out.
TriangleMesh coneSurface(const btConeShape& cone, int segments) {
  return alongAxis(granular::makeCone(cone.getRadius(), cone.getHeight(), segments), cone.getConeUpIndex());
}

TriangleMesh polyhedronSurface(const btPolyhedralConvexShape& shape) {
  std::vector<Vector3> points(shape.getNumVertices());
  for (std::size_t i = 0; i < points.size(); ++i) {
    btVector3 vertex;
    shape.getVertex(static_cast<int>(i), vertex);
    points[i] = fromBullet(vertex);
  }
  return hullOf(points, shape.getName());
}

TriangleMesh multiSphereSurface(const btMultiSphereShape& shape, int segments) {
  const TriangleMesh directions = ball(1.0, segments);
  const Vector3 scaling = fromBullet(shape.getLocalScaling());
  std::vector<Vector3> points;
  for (int i = 0; i < shape.getSphereCount(); ++i) {
    const Vector3 center = fromBullet(shape.getSpherePosition(i));
    for (const Vector3& d : directions.vertices) {
      points.push_back(scaling.cwiseProduct(center + double(shape.getSphereRadius(i)) * d));
    }
  }
  return hullOf(points, shape.getName());
}

TriangleMesh convexMeshSurface(const btConvexTriangleMeshShape& shape) {
  class Corners : public btInternalTriangleIndexCallback {
   public:
    void internalProcessTriangleIndex(btVector3* triangle, int, int) override {
      for (int corner = 0; corner < 3; ++corner) points.push_back(fromBullet(triangle[corner]));
    }
    std::vector<Vector3> points;
  } corners;
  const btScalar all = BT_LARGE_FLOAT;
  shape.getMeshInterface()->InternalProcessAllTriangles(&corners, btVector3(-all, -all, -all),
                                                        btVector3(all, all, all));
  return hullOf(corners.points, shape.getName());
}

/// Any other convex shape: the hull of its farthest points in many directions, inscribed. With its margin, as
/// nobody can say here whether it is part of the geometry.
TriangleMesh supportSurface(const btConvexShape& shape, int segments) {
  std::vector<Vector3> points;
  for (const Vector3& direction : ball(1.0, 2 * segments).vertices) {
    points.push_back(fromBullet(shape.localGetSupportingVertex(toBullet(direction))));
  }
  return hullOf(points, shape.getName());
}

[[noreturn]] void refuse(const btCollisionShape& shape) {
  throw std::invalid_argument(std::string("collision shape ") + shape.getName() +
                              " has no known surface; give CoverBodyDef.surface or CoverBodyDef.covering");
}

void addParts(std::vector<ShapePart>& parts, const btCollisionShape& shape, const SurfaceDef& def,
              const btTransform& transform);

/// Compounds of either family. A GImpact compound scales its children's places, but not the children.
template <class Compound>
void addChildren(std::vector<ShapePart>& parts, const Compound& compound, const SurfaceDef& def,
                 const btTransform& transform) {
  for (int i = 0; i < compound.getNumChildShapes(); ++i) {
    addParts(parts, *compound.getChildShape(i), def, transform * compound.getChildTransform(i));
  }
}

/// A uniformly scaled shape about its own origin.
void addScaled(std::vector<ShapePart>& parts, const btUniformScalingShape& scaled, const SurfaceDef& def,
               const btTransform& transform) {
  std::vector<ShapePart> children;
  addParts(children, *scaled.getChildShape(), def, btTransform::getIdentity());
  for (ShapePart& part : children) {
    for (Vector3& v : part.mesh.vertices) v *= double(scaled.getUniformScalingFactor());
    parts.push_back(placed(std::move(part), transform));
  }
}

/// Shapes that are one solid.
TriangleMesh convexSurface(const btCollisionShape& shape, const SurfaceDef& def) {
  switch (shape.getShapeType()) {
    case BOX_SHAPE_PROXYTYPE:
      return boxSurface(static_cast<const btBoxShape&>(shape));
    case SPHERE_SHAPE_PROXYTYPE:
      return sphereSurface(static_cast<const btSphereShape&>(shape), def.segments);
    case CAPSULE_SHAPE_PROXYTYPE:
      return capsuleSurface(static_cast<const btCapsuleShape&>(shape), def.segments);
    case CYLINDER_SHAPE_PROXYTYPE:
      return cylinderSurface(static_cast<const btCylinderShape&>(shape), def.segments);
    case CONE_SHAPE_PROXYTYPE:
      return coneSurface(static_cast<const btConeShape&>(shape), def.segments);
    case MULTI_SPHERE_SHAPE_PROXYTYPE:
      return multiSphereSurface(static_cast<const btMultiSphereShape&>(shape), def.segments);
    case CONVEX_HULL_SHAPE_PROXYTYPE:
    case CONVEX_POINT_CLOUD_SHAPE_PROXYTYPE:
    case TETRAHEDRAL_SHAPE_PROXYTYPE:
      return polyhedronSurface(static_cast<const btPolyhedralConvexShape&>(shape));
    case CONVEX_TRIANGLEMESH_SHAPE_PROXYTYPE:
      return convexMeshSurface(static_cast<const btConvexTriangleMeshShape&>(shape));
    default:
      if (!shape.isConvex()) refuse(shape);
      return supportSurface(static_cast<const btConvexShape&>(shape), def.segments);
  }
}

void addParts(std::vector<ShapePart>& parts, const btCollisionShape& shape, const SurfaceDef& def,
              const btTransform& transform) {
  switch (shape.getShapeType()) {
    case COMPOUND_SHAPE_PROXYTYPE:
      return addChildren(parts, static_cast<const btCompoundShape&>(shape), def, transform);
    case UNIFORM_SCALING_SHAPE_PROXYTYPE:
      return addScaled(parts, static_cast<const btUniformScalingShape&>(shape), def, transform);
    case STATIC_PLANE_PROXYTYPE:
      return parts.push_back(
          placed(detail::planePart(static_cast<const btStaticPlaneShape&>(shape), def.plane), transform));
    case TERRAIN_SHAPE_PROXYTYPE:
      return parts.push_back(
          placed(detail::heightfieldPart(static_cast<const btHeightfieldTerrainShape&>(shape)), transform));
    case GIMPACT_SHAPE_PROXYTYPE:
      if (static_cast<const btGImpactShapeInterface&>(shape).getGImpactShapeType() ==
          CONST_GIMPACT_COMPOUND_SHAPE) {
        return addChildren(parts, static_cast<const btGImpactCompoundShape&>(shape), def, transform);
      }
      [[fallthrough]];
    case TRIANGLE_MESH_SHAPE_PROXYTYPE:
    case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
    case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
      return parts.push_back(
          placed(detail::triangleMeshPart(static_cast<const btConcaveShape&>(shape)), transform));
    default:
      parts.push_back(placed({.mesh = convexSurface(shape, def)}, transform));
  }
}

}  // namespace

ShapePart partOf(TriangleMesh mesh) {
  const granular::MeshReport report = granular::checkMesh(mesh);
  if (report.isInsideOut()) granular::turnInsideOut(mesh);
  return {.mesh = std::move(mesh), .kind = report.isClosed() ? PartKind::Solid : PartKind::Sheet};
}

std::vector<ShapePart> shapeParts(const btCollisionShape& shape, const SurfaceDef& def) {
  granular::require(def.segments >= 8, "SurfaceDef.segments", def.segments, "", ">= 8");
  std::vector<ShapePart> parts;
  addParts(parts, shape, def, btTransform::getIdentity());
  if (parts.empty())
    throw std::invalid_argument("collision shape " + std::string(shape.getName()) + " has no children");
  return parts;
}

TriangleMesh shapeSurface(const btCollisionShape& shape, const SurfaceDef& def) {
  TriangleMesh surface;
  for (const ShapePart& part : shapeParts(shape, def)) granular::append(surface, part.mesh);
  return surface;
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
