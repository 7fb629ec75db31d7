// SPDX-License-Identifier: MIT
// Meshes of Bullet's shapes: closed, and of the shape's volume. Round shapes are inscribed polyhedra of 64
// sides: a 64-sided prism has sin(2 pi/64)/(2 pi/64) = 0.9984 of the cylinder; doubly curved ones lose about
// twice that.
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include <numbers>
#include <string>

#include "bridge_fixture.h"
#include "granular/geometry/triangle_mesh.h"

namespace bridge_test {
namespace {

using bullet_bridge::shapeParts;
using bullet_bridge::shapeSurface;
constexpr double kPi = std::numbers::pi;

/// Closed, outward, and of this volume but for the given part that an inscribed mesh loses.
void expectSolid(const btCollisionShape& shape, double volume, double mayLose) {
  SCOPED_TRACE(shape.getName());
  const granular::MeshReport report = granular::checkMesh(shapeSurface(shape));
  EXPECT_TRUE(report.isSolid()) << report.text();
  EXPECT_LE(report.volume, volume * (1.0 + 20.0 * kBulletRounding));
  EXPECT_GE(report.volume, volume * (1.0 - mayLose - 20.0 * kBulletRounding));
}

granular::Box extentOf(const btCollisionShape& shape) {
  return granular::boundingBox(shapeSurface(shape));
}

TEST(ShapeSurface, OfABoxHasItsFullSizeWhateverTheMargin) {
  btBoxShape box(vec(0.5, 0.25, 1.0));
  expectSolid(box, 1.0, 0.0);
  box.setMargin(scalar(0.1));
  expectSolid(box, 1.0, 0.0);
}

TEST(ShapeSurface, FollowsLocalScaling) {
  btBoxShape box(vec(0.5, 0.25, 1.0));
  box.setLocalScaling(vec(2, 1, 0.5));
  EXPECT_TRUE(extentOf(box).size().isApprox(Vector3(2.0, 0.5, 1.0), 10 * kBulletRounding));
}

TEST(ShapeSurface, OfASphereIsClosedWithItsVolume) {
  expectSolid(btSphereShape(scalar(0.5)), 4.0 / 3.0 * kPi * 0.125, 0.005);
}

TEST(ShapeSurface, OfACapsuleStandsOnItsOwnAxis) {
  const double volume = kPi * 0.25 * 0.25 * 1.0 + 4.0 / 3.0 * kPi * 0.25 * 0.25 * 0.25;
  expectSolid(btCapsuleShapeX(scalar(0.25), scalar(1)), volume, 0.005);
  expectSolid(btCapsuleShape(scalar(0.25), scalar(1)), volume, 0.005);
  expectSolid(btCapsuleShapeZ(scalar(0.25), scalar(1)), volume, 0.005);
  EXPECT_NEAR(extentOf(btCapsuleShapeX(scalar(0.25), scalar(1))).size().x(), 1.5, 1e-6);
  EXPECT_NEAR(extentOf(btCapsuleShape(scalar(0.25), scalar(1))).size().y(), 1.5, 1e-6);
  EXPECT_NEAR(extentOf(btCapsuleShapeZ(scalar(0.25), scalar(1))).size().z(), 1.5, 1e-6);
}

TEST(ShapeSurface, OfACylinderStandsOnItsOwnAxis) {
  const double volume = kPi * 0.25 * 0.25 * 1.0;
  expectSolid(btCylinderShapeX(vec(0.5, 0.25, 0.25)), volume, 0.0017);
  expectSolid(btCylinderShape(vec(0.25, 0.5, 0.25)), volume, 0.0017);
  expectSolid(btCylinderShapeZ(vec(0.25, 0.25, 0.5)), volume, 0.0017);
  EXPECT_NEAR(extentOf(btCylinderShapeX(vec(0.5, 0.25, 0.25))).size().x(), 1.0, 1e-6);
  EXPECT_NEAR(extentOf(btCylinderShapeZ(vec(0.25, 0.25, 0.5))).size().z(), 1.0, 1e-6);
}

TEST(ShapeSurface, OfAConeHasItsApexWhereBulletHasIt) {
  const double volume = kPi * 0.25 * 0.25 * 1.0 / 3.0;
  for (const btConeShape& cone :
       {btConeShape(scalar(0.25), scalar(1)), btConeShape(btConeShapeX(scalar(0.25), scalar(1))),
        btConeShape(btConeShapeZ(scalar(0.25), scalar(1)))}) {
    expectSolid(cone, volume, 0.0017);
    btVector3 up(0, 0, 0);
    up[cone.getConeUpIndex()] = 1;
    const Vector3 apex = fromBullet(cone.localGetSupportingVertexWithoutMargin(up));
    double nearest = 1.0;
    for (const Vector3& v : shapeSurface(cone).vertices) nearest = std::min(nearest, (v - apex).norm());
    EXPECT_LT(nearest, 1e-6);
  }
}

TEST(ShapeSurface, OfAHullIsExactAndWithoutMargin) {
  btConvexHullShape hull;
  for (const btVector3& p :
       {vec(0, 0, 0), vec(1.1, 0, 0), vec(0, 0.9, 0), vec(0, 0, 1.3), vec(0.1, 0.1, 0.1)}) {
    hull.addPoint(p);
  }
  expectSolid(hull, 1.1 * 0.9 * 1.3 / 6.0, 0.0);
  EXPECT_EQ(shapeSurface(hull).vertices.size(), 4u) << "the inner point is no corner";
}

TEST(ShapeSurface, OfACubeGivenAsAHullHasTwelveTriangles) {
  btConvexHullShape hull;
  for (int i = 0; i < 8; ++i) hull.addPoint(vec(i & 1, (i >> 1) & 1, (i >> 2) & 1));
  expectSolid(hull, 1.0, 0.0);
  EXPECT_EQ(shapeSurface(hull).triangles.size(), 12u);
}

TEST(ShapeSurface, OfTwoSpheresIsTheCapsuleTheySpan) {
  const btVector3 centers[2] = {vec(0, -0.5, 0), vec(0, 0.5, 0)};
  const btScalar radii[2] = {scalar(0.25), scalar(0.25)};
  const btMultiSphereShape spheres(centers, radii, 2);
  expectSolid(spheres, kPi * 0.25 * 0.25 * 1.0 + 4.0 / 3.0 * kPi * 0.25 * 0.25 * 0.25, 0.02);
}

TEST(ShapeSurface, OfACompoundIsThatOfItsNestedChildrenInPlace) {
  btBoxShape cube(vec(0.5, 0.5, 0.5));
  btSphereShape ball(scalar(0.5));
  btCompoundShape inner;
  inner.addChildShape(at(2, 0, 0), &cube);
  btCompoundShape outer;
  const btTransform quarterTurn(btQuaternion(btVector3(0, 0, 1), scalar(kPi / 2)), btVector3(0, 0, 0));
  outer.addChildShape(quarterTurn, &inner);
  outer.addChildShape(at(0, -3, 0), &ball);
  expectSolid(outer, 1.0 + 4.0 / 3.0 * kPi * 0.125, 0.005);
  const auto parts = shapeParts(outer);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_LT((granular::boundingBox(parts[0]).center() - Vector3(0, 2, 0)).norm(), 1e-6) << "x turned into y";
  EXPECT_LT((granular::boundingBox(parts[1]).center() - Vector3(0, -3, 0)).norm(), 1e-6);
}

TEST(ShapeSurface, OfAUniformlyScaledShapeIsScaled) {
  btBoxShape cube(vec(0.5, 0.5, 0.5));
  expectSolid(btUniformScalingShape(&cube, 3), 27.0, 0.0);
}

TEST(ShapeSurface, OfATriangleMeshIsTheMeshWelded) {
  btTriangleMesh triangles;
  const btVector3 p[4] = {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)};
  triangles.addTriangle(p[0], p[2], p[1]);
  triangles.addTriangle(p[0], p[1], p[3]);
  triangles.addTriangle(p[0], p[3], p[2]);
  triangles.addTriangle(p[1], p[2], p[3]);
  const btBvhTriangleMeshShape shape(&triangles, true);
  expectSolid(shape, 1.0 / 6.0, 0.0);
  EXPECT_EQ(shapeSurface(shape).vertices.size(), 4u);
}

TEST(ShapeSurface, OfAHeightfieldIsOpenAndHasItsArea) {
  const std::vector<float> heights(9, 0.0f);
  const btHeightfieldTerrainShape field(3, 3, heights.data(), scalar(-1), scalar(1), 1, false);
  const granular::MeshReport report = granular::checkMesh(shapeSurface(field));
  EXPECT_TRUE(report.isReadable()) << report.text();
  EXPECT_FALSE(report.isClosed());
  EXPECT_NEAR(report.area, 4.0, 1e-6);
}

TEST(ShapeSurface, OfAPlaneIsASlabBelowIt) {
  const btStaticPlaneShape plane(vec(0, 1, 0), scalar(0.5));
  const auto slab = shapeSurface(plane, {.plane = {.center = {3, 7, 4}, .size = 2.0, .thickness = 0.1}});
  EXPECT_TRUE(granular::checkMesh(slab).isSolid());
  const granular::Box extent = granular::boundingBox(slab);
  EXPECT_TRUE(extent.lower.isApprox(Vector3(2, 0.4, 3), 1e-6)) << extent.lower.transpose();
  EXPECT_TRUE(extent.upper.isApprox(Vector3(4, 0.5, 5), 1e-6)) << extent.upper.transpose();
}

TEST(ShapeSurface, OfAPlaneNeedsAPatch) {
  EXPECT_THROW(shapeSurface(btStaticPlaneShape(vec(0, 1, 0), 0)), std::invalid_argument);
}

TEST(ShapeSurface, RefusesOtherShapesByName) {
  try {
    shapeSurface(btEmptyShape());
    FAIL() << "an empty shape has no surface";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("Empty"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace bridge_test
