// SPDX-License-Identifier: MIT
// Coverings of Bullet's shapes: every particle touches the surface that the shape means, from within, and no
// hole is larger than allowed. Inside a convex solid the distance to its surface is the least of the
// distances to its faces (planes, or the mantle of a solid of revolution), which is what the cases give.
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMesh.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "bridge_fixture.h"
#include "granular/geometry/mesh_distance.h"

namespace bridge_test {
namespace {

using bullet_bridge::coverParts;
using bullet_bridge::shapeParts;

constexpr double kRadius = 0.08;
/// Of round shapes of radius 0.5 or less in 64 sides: the mesh runs inside by up to 0.5 (1 - cos(pi/64)) =
/// 0.0006, twice that where it is curved twofold. Floaters are put onto the offset surface exactly; rounding
/// below.
constexpr double kMeshError = 0.0012;

granular::Covering cover(const btCollisionShape& shape, std::vector<granular::CoverReport>* reports = nullptr,
                         const bullet_bridge::SurfaceDef& surface = {}) {
  return coverParts(shapeParts(shape, surface), {.particleRadius = kRadius}, reports);
}

/// Tips thinner than a particle take particles nearer to the surface (CoverReport::thinParticles).
/// @param depth  of a point below the surface, m
void expectTouchingFromWithin(const btCollisionShape& shape,
                              const std::function<double(const Vector3&)>& depth) {
  SCOPED_TRACE(shape.getName());
  std::vector<granular::CoverReport> reports;
  const granular::Covering covering = cover(shape, &reports);
  ASSERT_GT(covering.positions.size(), 20u);
  std::int64_t thin = 0;
  for (const granular::CoverReport& report : reports) {
    EXPECT_TRUE(report.holesClosed) << report.text();
    thin += report.thinParticles;
  }
  EXPECT_LT(2 * thin, static_cast<std::int64_t>(covering.positions.size())) << "most must be told about";
  std::int64_t shallow = 0;
  for (const Vector3& p : covering.positions) {
    EXPECT_LE(depth(p), kRadius + kMeshError) << p.transpose();
    EXPECT_GE(depth(p), 0.0) << p.transpose();
    if (depth(p) < kRadius - kMeshError) ++shallow;
  }
  EXPECT_LE(shallow, thin);
}

double boxDepth(const Vector3& p, const Vector3& half) {
  return (half - p.cwiseAbs()).minCoeff();
}
double across(const Vector3& p, int axis) {
  return std::hypot(p[(axis + 1) % 3], p[(axis + 2) % 3]);
}

TEST(ShapeCovering, OfABoxTouchesItsFacesUnderScalingAndMargin) {
  btBoxShape box(vec(0.5, 0.25, 0.4));
  box.setMargin(scalar(0.02));
  box.setLocalScaling(vec(1, 2, 0.5));
  expectTouchingFromWithin(box, [](const Vector3& p) { return boxDepth(p, {0.5, 0.5, 0.2}); });
}

TEST(ShapeCovering, OfASphereTouchesIt) {
  btSphereShape sphere(scalar(0.25));
  sphere.setLocalScaling(vec(2, 2, 2));
  expectTouchingFromWithin(sphere, [](const Vector3& p) { return 0.5 - p.norm(); });
}

TEST(ShapeCovering, OfACapsuleTouchesItOnEachAxis) {
  const std::array<btCapsuleShape, 3> capsules{btCapsuleShapeX(scalar(0.25), scalar(0.5)),
                                               btCapsuleShape(scalar(0.25), scalar(0.5)),
                                               btCapsuleShapeZ(scalar(0.25), scalar(0.5))};
  for (const btCapsuleShape& capsule : capsules) {
    const int axis = capsule.getUpAxis();
    expectTouchingFromWithin(capsule, [axis](const Vector3& p) {
      return 0.25 - std::hypot(across(p, axis), std::max(0.0, std::abs(p[axis]) - 0.25));
    });
  }
}

TEST(ShapeCovering, OfACylinderTouchesItOnEachAxis) {
  btCylinderShapeX alongX(vec(0.3, 0.25, 0.25));
  btCylinderShape alongY(vec(0.25, 0.3, 0.25));
  btCylinderShapeZ alongZ(vec(0.25, 0.25, 0.3));
  for (btCylinderShape* cylinder :
       {static_cast<btCylinderShape*>(&alongX), &alongY, static_cast<btCylinderShape*>(&alongZ)}) {
    cylinder->setMargin(scalar(0.01));
    const int axis = cylinder->getUpAxis();
    expectTouchingFromWithin(*cylinder, [axis](const Vector3& p) {
      return std::min(0.25 - across(p, axis), 0.3 - std::abs(p[axis]));
    });
  }
}

TEST(ShapeCovering, OfAConeTouchesItOnEachAxis) {
  const std::array<btConeShape, 3> cones{btConeShapeX(scalar(0.4), scalar(0.8)),
                                         btConeShape(scalar(0.4), scalar(0.8)),
                                         btConeShapeZ(scalar(0.4), scalar(0.8))};
  for (const btConeShape& cone : cones) {
    const int axis = cone.getConeUpIndex();
    expectTouchingFromWithin(cone, [axis](const Vector3& p) {
      const double mantle = ((0.4 - p[axis]) * 0.4 - across(p, axis) * 0.8) / std::hypot(0.4, 0.8);
      return std::min(p[axis] + 0.4, mantle);
    });
  }
}

TEST(ShapeCovering, OfAHullTouchesItsFacesWithoutTheMargin) {
  btConvexHullShape hull;
  for (const btVector3& p : {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)}) hull.addPoint(p);
  hull.setMargin(scalar(0.1));
  expectTouchingFromWithin(
      hull, [](const Vector3& p) { return std::min(p.minCoeff(), (1.0 - p.sum()) / std::sqrt(3.0)); });
}

TEST(ShapeCovering, OfTwoSpheresTouchesTheCapsuleTheySpan) {
  const btVector3 centers[2] = {vec(0, -0.25, 0), vec(0, 0.25, 0)};
  const btScalar radii[2] = {scalar(0.3), scalar(0.3)};
  expectTouchingFromWithin(btMultiSphereShape(centers, radii, 2), [](const Vector3& p) {
    return 0.3 - std::hypot(across(p, 1), std::max(0.0, std::abs(p.y()) - 0.25));
  });
}

TEST(ShapeCovering, OfAUniformlyScaledShapeTouchesIt) {
  btBoxShape box(vec(0.25, 0.25, 0.25));
  expectTouchingFromWithin(btUniformScalingShape(&box, 2), [](const Vector3& p) {
    return boxDepth(p, {0.5, 0.5, 0.5});
  });
}

/// A tetrahedron of three right angles, legs 1.
btTriangleMesh cornerTetrahedron() {
  btTriangleMesh mesh;
  const btVector3 p[4] = {vec(0, 0, 0), vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1)};
  for (const auto& t : {std::array{0, 2, 1}, std::array{0, 1, 3}, std::array{0, 3, 2}, std::array{1, 2, 3}}) {
    mesh.addTriangle(p[t[0]], p[t[1]], p[t[2]]);
  }
  return mesh;
}

TEST(ShapeCovering, OfClosedTriangleMeshesTouchesTheirFaces) {
  btTriangleMesh triangles = cornerTetrahedron();
  const auto depth = [](const Vector3& p) {
    return std::min(p.minCoeff(), (1.0 - p.sum()) / std::sqrt(3.0));
  };
  expectTouchingFromWithin(btBvhTriangleMeshShape(&triangles, true), depth);
  btGImpactMeshShape impact(&triangles);
  impact.updateBound();
  expectTouchingFromWithin(impact, depth);
  btBvhTriangleMeshShape plain(&triangles, true);
  const btScaledBvhTriangleMeshShape scaled(&plain, vec(1, 2, 1));
  expectTouchingFromWithin(scaled, [](const Vector3& p) {
    return std::min(p.minCoeff(), (1.0 - p.x() - 0.5 * p.y() - p.z()) / 1.5);
  });
}

TEST(ShapeCovering, LeavesOutWhatLiesInsideAnotherChild) {
  btBoxShape box(vec(0.5, 0.3, 0.3));
  btCompoundShape cross;
  cross.addChildShape(at(0, 0, 0), &box);
  const btTransform quarterTurn(btQuaternion(btVector3(0, 0, 1), scalar(SIMD_HALF_PI)), btVector3(0, 0, 0));
  cross.addChildShape(quarterTurn, &box);
  const granular::Covering covering = cover(cross);
  for (const Vector3& p : covering.positions) {
    const double deeper = std::max(boxDepth(p, {0.5, 0.3, 0.3}), boxDepth(p, {0.3, 0.5, 0.3}));
    EXPECT_LT(deeper, 1.5 * kRadius + 1e-6) << p.transpose();
  }
  EXPECT_GT(covering.positions.size(), 100u);
}

/// Every point of the surface of centres, sampled, is within a radius and a hole's radius of a centre.
void expectNoHole(const granular::Covering& covering, const std::vector<Vector3>& samples, double hole) {
  for (const Vector3& p : samples) {
    double nearest = 1e9;
    for (const Vector3& center : covering.positions) nearest = std::min(nearest, (center - p).norm());
    EXPECT_LT(nearest, kRadius + hole) << p.transpose();
    if (nearest >= kRadius + hole) return;
  }
}

TEST(ShapeCovering, OfAPlaneIsItsUpperSideOnly) {
  const btStaticPlaneShape plane(vec(0, 0, 1), scalar(0.25));
  std::vector<granular::CoverReport> reports;
  const granular::Covering covering = cover(plane, &reports, {.plane = {.size = 2.0}});
  for (const Vector3& p : covering.positions) {
    EXPECT_LT(p.z(), 0.25 - kRadius + 1e-3 * kRadius);
    EXPECT_GT(p.z(), 0.25 - 1.5 * kRadius - 1e-6) << "only the border may lie lower";
  }
  std::vector<Vector3> samples;
  for (double x = -0.92; x <= 0.92; x += 0.04) {
    for (double y = -0.92; y <= 0.92; y += 0.04) samples.push_back({x, y, 0.25 - kRadius});
  }
  expectNoHole(covering, samples, reports[0].holeBound);
}

/// Hills of 0.2 m; the nearest point of the terrain is the nearest of its triangles, all tried.
TEST(ShapeCovering, OfAHeightfieldTouchesItFromBelow) {
  constexpr int kSticks = 12;
  std::vector<float> heights;
  for (int y = 0; y < kSticks; ++y) {
    for (int x = 0; x < kSticks; ++x)
      heights.push_back(static_cast<float>(std::sin(0.9 * x) + std::cos(0.7 * y)));
  }
  btHeightfieldTerrainShape field(kSticks, kSticks, heights.data(), scalar(-2), scalar(2), 1, false);
  field.setLocalScaling(vec(0.2, 0.1, 0.2));
  std::vector<granular::CoverReport> reports;
  const granular::Covering covering = cover(field, &reports);
  EXPECT_TRUE(reports[0].holesClosed) << reports[0].text();

  // Bullet's own ray test says how high the terrain is over a particle: never less than a radius.
  btCollisionObject ground;
  ground.setCollisionShape(&field);
  const granular::MeshDistance distance(bullet_bridge::shapeSurface(field));
  for (const Vector3& p : covering.positions) {
    EXPECT_NEAR(std::abs(distance.nearest(p).signedDistance), kRadius, 0.5 * kRadius);
    if (std::max(std::abs(p.x()), std::abs(p.z())) > 1.1 - kRadius) continue;  // rounds the border
    const btVector3 low = bullet_bridge::toBullet(p);
    const btVector3 high = low + vec(0, 10, 0);
    btCollisionWorld::ClosestRayResultCallback hit(high, low);
    btCollisionWorld::rayTestSingle(btTransform(btQuaternion::getIdentity(), high),
                                    btTransform(btQuaternion::getIdentity(), low), &ground, &field,
                                    btTransform::getIdentity(), hit);
    ASSERT_TRUE(hit.hasHit()) << p.transpose();
    EXPECT_GT(hit.m_hitPointWorld.y() - p.y(), kRadius * (1.0 - 1e-3));
  }
}

TEST(CoverBody, CoversAHeightfieldThatHoldsAGrainAtItsHeight) {
  SandScene scene;
  const std::vector<float> heights(25, 0.5f);
  auto& field = scene.shape<btHeightfieldTerrainShape>(5, 5, heights.data(), scalar(0), scalar(1), 1, false);
  field.setLocalScaling(vec(0.25, 1, 0.25));
  scene.world->coverBody(scene.body(0, field, at(0, 0, 0)), {.particleRadius = 0.05});
  granular::GranularSystem& sand = scene.world->grains();
  const auto shape = sand.addGrainShape(granular::sphereShape(0.05));
  const auto grain = sand.addGrain({.shape = shape,
                                    .material = sand.addMaterial({.restitution = 0.3}),
                                    .pose = {.position = {0.1, 0.06, 0.1}}});
  for (int i = 0; i < 60; ++i) scene.world->stepSimulation(scalar(1.0 / 60.0));
  // It rests in a dip between particles: at most r (2 - sqrt(2)) below its place on a smooth floor, since the
  // hole it lies over has half its radius at most (three particles touched, sqrt(4 - 1.5^2) r above them).
  const double height = sand.grainMotions()[grain.index].pose.position.y();
  EXPECT_LT(height, 0.051);
  EXPECT_GT(height, 0.05 - (2.0 - std::sqrt(4.0 - 1.5 * 1.5)) * 0.05 - 0.001);
}

TEST(CoverBody, CoversAnOpenMeshAsASheetOfTheThicknessAskedFor) {
  btTriangleMesh mesh;  // a square of 1 m that faces up
  SandScene scene;
  mesh.addTriangle(vec(-0.5, 0, -0.5), vec(-0.5, 0, 0.5), vec(0.5, 0, 0.5));
  mesh.addTriangle(vec(-0.5, 0, -0.5), vec(0.5, 0, 0.5), vec(0.5, 0, -0.5));
  auto& open = scene.shape<btBvhTriangleMeshShape>(&mesh, true);
  btRigidBody& body = scene.body(0, open, at(0, 0, 0));
  EXPECT_THROW(scene.world->coverBody(body, {.particleRadius = 0.04}), std::invalid_argument)
      << "no solid, and no sheet was asked for";
  scene.world->coverBody(body, {.particleRadius = 0.04, .sheetThickness = 0.02});
  std::vector<granular::ParticleView> particles;
  scene.world->grains().readParticles(particles);
  ASSERT_GT(particles.size(), 100u);
  for (const granular::ParticleView& p : particles) {
    EXPECT_LE(std::abs(p.position.y()), 0.01) << "centres lie within the sheet";
    EXPECT_LE(std::max(std::abs(p.position.x()), std::abs(p.position.z())), 0.51);
  }
}

TEST(CoverBody, RefusesAnOpenSurfaceForADynamicBody) {
  SandScene scene;
  btRigidBody& body = scene.body(1, scene.sphere(0.1), at(0, 0, 0));
  granular::TriangleMesh triangle;
  triangle.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.triangles = {{0, 1, 2}};
  bullet_bridge::CoverBodyDef def{.particleRadius = 0.02};
  def.surface = triangle;
  EXPECT_THROW(scene.world->coverBody(body, def), std::invalid_argument);
}

}  // namespace
}  // namespace bridge_test
