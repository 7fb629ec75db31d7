// SPDX-License-Identifier: MIT
// Meshes of Bullet's shapes: closed, and of the shape's volume. Round shapes are inscribed polyhedra of 64
// sides: a 64-sided prism has sin(2 pi/64)/(2 pi/64) = 0.9984 of the cylinder; doubly curved ones lose about
// twice that.
#include <BulletCollision/CollisionShapes/btConvexTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btEmptyShape.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btMinkowskiSumShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "bridge_fixture.h"
#include "granular/geometry/triangle_mesh.h"

namespace bridge_test {
namespace {

using bullet_bridge::PartKind;
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

TEST(ShapeSurface, TakesANegativeScaleAsAMirrorImage) {
  btBoxShape box(vec(0.5, 0.25, 1.0));
  box.setLocalScaling(vec(-2, 1, 1));
  expectSolid(box, 2.0, 0.0);
  btConvexHullShape hull;
  for (const btVector3& p : {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)}) hull.addPoint(p);
  hull.setLocalScaling(vec(-1, 1, 1));
  expectSolid(hull, 1.0 / 6.0, 0.0);
  EXPECT_NEAR(extentOf(hull).lower.x(), -1.0, 1e-6);
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
  EXPECT_LT((granular::boundingBox(parts[0].mesh).center() - Vector3(0, 2, 0)).norm(), 1e-6)
      << "x turned into y";
  EXPECT_LT((granular::boundingBox(parts[1].mesh).center() - Vector3(0, -3, 0)).norm(), 1e-6);
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

TEST(ShapeSurface, OfAMeshMirroredByItsScalingLooksOutwards) {
  btTriangleMesh triangles;
  const btVector3 p[4] = {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)};
  for (const auto& t : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{0, 3, 2}, std::array{1, 2, 3}}) {
    triangles.addTriangle(p[t[0]], p[t[1]], p[t[2]]);
  }
  btBvhTriangleMeshShape shape(&triangles, true);
  const btScaledBvhTriangleMeshShape scaled(&shape, vec(-2, 1, 3));
  expectSolid(scaled, 1.0, 0.0);
  EXPECT_NEAR(extentOf(scaled).lower.x(), -2.0, 1e-6);
}

TEST(ShapeSurface, OfAGImpactMeshIsTheMeshWithItsScalingAndWithoutItsMargin) {
  btTriangleMesh triangles;
  const btVector3 p[4] = {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)};
  for (const auto& t : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{0, 3, 2}, std::array{1, 2, 3}}) {
    triangles.addTriangle(p[t[0]], p[t[1]], p[t[2]]);
  }
  btGImpactMeshShape shape(&triangles);
  EXPECT_THROW(shapeSurface(shape), std::invalid_argument) << "updateBound has not been called";
  shape.setLocalScaling(vec(2, 1, 3));
  shape.setMargin(scalar(0.1));
  shape.updateBound();
  expectSolid(shape, 1.0, 0.0);
}

TEST(ShapeSurface, OfAGImpactCompoundIsThatOfItsChildrenInPlace) {
  btBoxShape cube(vec(0.5, 0.5, 0.5));
  btGImpactCompoundShape compound;
  compound.addChildShape(at(2, 0, 0), &cube);
  compound.addChildShape(at(-2, 0, 0), &cube);
  expectSolid(compound, 2.0, 0.0);
}

TEST(ShapeSurface, OfAConvexTriangleMeshIsItsHullScaled) {
  btTriangleMesh triangles;
  triangles.addTriangle(vec(0, 0, 0), vec(0, 1, 0), vec(1, 0, 0));
  triangles.addTriangle(vec(0, 0, 0), vec(1, 0, 0), vec(0, 0, 1));
  btConvexTriangleMeshShape shape(&triangles);
  shape.setLocalScaling(vec(2, 3, 4));
  expectSolid(shape, 4.0, 0.0);
}

/// Bullet's Minkowski sum of a box of half extents 1 and a ball of radius 0.5 is the box without its margin,
/// edge s = 1.92, with the sum of the margins round it, r = 0.54. Steiner: s^3 + 6 s^2 r + 3 pi s r^2 + 4/3
/// pi r^3.
TEST(ShapeSurface, OfAnyOtherConvexShapeIsInscribedBySupportPoints) {
  btBoxShape box(vec(1, 1, 1));
  btSphereShape sphere(scalar(0.5));
  const btMinkowskiSumShape sum(&box, &sphere);
  const double s = 1.92;
  const double r = 0.54;
  expectSolid(sum, s * s * s + 6.0 * s * s * r + 3.0 * kPi * s * r * r + 4.0 / 3.0 * kPi * r * r * r, 0.005);
}

/// Four ways to hold heights; the legacy constructor takes PHY_FLOAT to mean btScalar.
struct HeightData {
  std::vector<float> floats;
  std::vector<double> doubles;
  std::vector<short> shorts;
  std::vector<unsigned char> bytes;
  std::vector<btScalar> scalars;
};

enum class HeightType { Float, Double, Short, Byte, Legacy };

struct FieldCase {
  HeightType type;
  int upAxis;
  bool flipEdges;
  bool flipWinding;
};

class HeightfieldSurface : public testing::TestWithParam<FieldCase> {
 protected:
  static constexpr int kSticks = 5;

  /// Heights of the plane 1 + x/4 + y/2 over sticks x, y = 0 ... 4: all exact in steps of 1/4.
  std::unique_ptr<btHeightfieldTerrainShape> field() {
    for (int y = 0; y < kSticks; ++y) {
      for (int x = 0; x < kSticks; ++x) {
        const int quarters = 4 + x + 2 * y;
        data_.floats.push_back(0.25f * static_cast<float>(quarters));
        data_.doubles.push_back(0.25 * quarters);
        data_.scalars.push_back(scalar(0.25 * quarters));
        data_.shorts.push_back(static_cast<short>(quarters));
        data_.bytes.push_back(static_cast<unsigned char>(quarters));
      }
    }
    const FieldCase& c = GetParam();
    auto result = make(c);
    result->setFlipTriangleWinding(c.flipWinding);
    return result;
  }

 private:
  std::unique_ptr<btHeightfieldTerrainShape> make(const FieldCase& c) const {
    const btScalar low = 0;
    const btScalar high = 4;
    const btScalar step = scalar(0.25);
    using Field = btHeightfieldTerrainShape;
    switch (c.type) {
      case HeightType::Float:
        return std::make_unique<Field>(kSticks, kSticks, data_.floats.data(), low, high, c.upAxis,
                                       c.flipEdges);
      case HeightType::Double:
        return std::make_unique<Field>(kSticks, kSticks, data_.doubles.data(), low, high, c.upAxis,
                                       c.flipEdges);
      case HeightType::Short:
        return std::make_unique<Field>(kSticks, kSticks, data_.shorts.data(), step, low, high, c.upAxis,
                                       c.flipEdges);
      case HeightType::Byte:
        return std::make_unique<Field>(kSticks, kSticks, data_.bytes.data(), step, low, high, c.upAxis,
                                       c.flipEdges);
      case HeightType::Legacy:
        break;
    }
    return std::make_unique<Field>(kSticks, kSticks, static_cast<const void*>(data_.scalars.data()), step,
                                   low, high, c.upAxis, PHY_FLOAT, c.flipEdges);
  }

  HeightData data_;
};

/// Bullet puts the field's middle at the origin: sticks at -2 ... 2, heights less 2 (half of 0 ... 4).
TEST_P(HeightfieldSurface, LiesInThePlaneOfItsHeightsAndLooksUp) {
  const auto shape = field();
  const auto parts = shapeParts(*shape);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].kind, PartKind::Ground);
  const int up = GetParam().upAxis;
  const int first = up == 0 ? 1 : 0;  // the axis of x, then that of y
  const int second = up == 2 ? 1 : 2;
  EXPECT_EQ(parts[0].mesh.vertices.size(), 25u);
  EXPECT_EQ(parts[0].mesh.triangles.size(), 32u);
  for (const Vector3& v : parts[0].mesh.vertices) {
    EXPECT_NEAR(v[up], 1.0 + (v[first] + 2.0) / 4.0 + (v[second] + 2.0) / 2.0 - 2.0, 1e-5);
  }
  for (const auto& triangle : parts[0].mesh.triangles) {
    EXPECT_GT(granular::doubleAreaVector(parts[0].mesh, triangle)[up], 0.0);
  }
  EXPECT_EQ(granular::checkMesh(parts[0].mesh).flippedEdges.count, 0);
}

INSTANTIATE_TEST_SUITE_P(AllTypesAxesAndFlips, HeightfieldSurface,
                         testing::Values(FieldCase{HeightType::Float, 0, false, false},
                                         FieldCase{HeightType::Float, 1, true, false},
                                         FieldCase{HeightType::Float, 2, false, true},
                                         FieldCase{HeightType::Double, 1, false, false},
                                         FieldCase{HeightType::Double, 2, true, true},
                                         FieldCase{HeightType::Short, 1, true, true},
                                         FieldCase{HeightType::Short, 0, false, false},
                                         FieldCase{HeightType::Byte, 2, false, false},
                                         FieldCase{HeightType::Byte, 1, false, true},
                                         FieldCase{HeightType::Legacy, 1, false, false}));

TEST(ShapeSurface, OfAPlaneIsAPatchInIt) {
  const btStaticPlaneShape plane(vec(0, 1, 0), scalar(0.5));
  const auto parts = shapeParts(plane, {.plane = {.center = {3, 7, 4}, .size = 2.0}});
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].kind, PartKind::Ground);
  EXPECT_TRUE(parts[0].up.isApprox(Vector3::UnitY(), kBulletRounding));
  EXPECT_NEAR(granular::surfaceArea(parts[0].mesh), 4.0, 1e-6);
  for (const Vector3& v : parts[0].mesh.vertices) {
    EXPECT_NEAR(v.y(), 0.5, 1e-6);
    EXPECT_NEAR((v - Vector3(3, 0.5, 4)).norm(), std::sqrt(2.0), 1e-6);
  }
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
