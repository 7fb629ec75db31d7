// SPDX-License-Identifier: MIT
#include "bullet_bridge/concave_surface.h"

#include <BulletCollision/CollisionShapes/btConcaveShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleCallback.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "bullet_bridge/convert.h"
#include "granular/base/require.h"
#include "granular/geometry/mesh_primitives.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

using granular::TriangleMesh;
using granular::Vector3;

namespace detail {
namespace {

class TriangleCollector : public btTriangleCallback {
 public:
  void processTriangle(btVector3* triangle, int, int) override {
    const auto first = static_cast<std::int32_t>(mesh.vertices.size());
    for (int corner = 0; corner < 3; ++corner) mesh.vertices.push_back(fromBullet(triangle[corner]));
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  TriangleMesh mesh;
};

TriangleMesh weldedTriangles(const btConcaveShape& shape) {
  btVector3 lower;
  btVector3 upper;
  shape.getAabb(btTransform::getIdentity(), lower, upper);
  TriangleCollector collector;
  shape.processAllTriangles(&collector, lower, upper);
  if (collector.mesh.triangles.empty()) {
    throw std::invalid_argument(std::string("collision shape ") + shape.getName() +
                                " has no triangles (a GImpact shape: call updateBound first)");
  }
  granular::weldVertices(collector.mesh);
  return std::move(collector.mesh);
}

}  // namespace

ShapePart planePart(const btStaticPlaneShape& plane, const PlanePatch& patch) {
  granular::require(std::isfinite(patch.size) && patch.size > 0.0, "PlanePatch.size", patch.size, "m",
                    "finite and > 0, as the collision shape is an endless plane");
  granular::requireFinite(patch.center, "PlanePatch.center", "m");
  const Vector3 up = fromBullet(plane.getPlaneNormal()).normalized();
  const granular::Pose pose{
      .position = patch.center + (double(plane.getPlaneConstant()) - up.dot(patch.center)) * up,
      .orientation = granular::Quaternion::FromTwoVectors(Vector3::UnitZ(), up)};
  ShapePart part{
      .mesh = granular::makePlanePatch(patch.size, patch.size), .kind = PartKind::Ground, .up = up};
  for (Vector3& v : part.mesh.vertices) v = pose.toWorld(v);
  return part;
}

ShapePart heightfieldPart(const btHeightfieldTerrainShape& field) {
  ShapePart part{.mesh = weldedTriangles(field), .kind = PartKind::Ground, .up = Vector3::Zero()};
  part.up[field.getUpAxis()] = 1.0;
  for (auto& triangle : part.mesh.triangles) {
    if (granular::doubleAreaVector(part.mesh, triangle).dot(part.up) < 0.0)
      std::swap(triangle[1], triangle[2]);
  }
  return part;
}

ShapePart triangleMeshPart(const btConcaveShape& shape) {
  return partOf(weldedTriangles(shape));
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
