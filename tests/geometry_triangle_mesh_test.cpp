// SPDX-License-Identifier: MIT
// Checks of meshes, welding, and the primitive meshes that the other tests build on.
#include "granular/geometry/triangle_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

TEST(CheckMesh, FindsNothingWrongWithABox) {
  const MeshReport report = checkMesh(makeBox({1.0, 2.0, 3.0}, 2));
  EXPECT_TRUE(report.isSolid());
  EXPECT_EQ(report.triangleCount, 6 * 4 * 2);
  EXPECT_NEAR(report.area, 22.0, 1e-12);
  EXPECT_NEAR(report.volume, 6.0, 1e-12);
  EXPECT_EQ(report.text().find('\n'), std::string::npos) << report.text();
}

TEST(CheckMesh, CountsTheOpenEdgesOfAMissingTriangle) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  mesh.triangles.pop_back();
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.openEdges.count, 3);
  EXPECT_FALSE(report.isClosed());
  EXPECT_NE(report.text().find("3 open edges, first: edge "), std::string::npos) << report.text();
}

TEST(CheckMesh, CountsTheEdgesOfAFlippedTriangle) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  std::swap(mesh.triangles[4][0], mesh.triangles[4][1]);
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.flippedEdges.count, 3);
  EXPECT_NE(report.flippedEdges.firstExample.find("triangle"), std::string::npos);
  EXPECT_FALSE(report.isClosed());
}

TEST(CheckMesh, FindsARepeatedTriangleHoweverItIsTurned) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  const auto t = mesh.triangles[2];
  mesh.triangles.push_back({t[2], t[1], t[0]});
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.duplicateTriangles.count, 1);
  EXPECT_EQ(report.duplicateTriangles.firstExample, "triangle 12 repeats triangle 2");
  EXPECT_EQ(report.crowdedEdges.count, 3);
}

TEST(CheckMesh, FindsTrianglesWithoutArea) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  mesh.vertices.push_back(0.25 * mesh.vertices[0] + 0.75 * mesh.vertices[1]);
  mesh.triangles.push_back({0, 1, 8});
  EXPECT_EQ(checkMesh(mesh).degenerateTriangles.count, 1);
  EXPECT_EQ(checkMesh(mesh).degenerateTriangles.firstExample, "triangle 12");
}

TEST(CheckMesh, FindsCoordinatesThatAreNotFinite) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  mesh.vertices[5][1] = std::numeric_limits<double>::quiet_NaN();
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.nonFiniteVertices.count, 1);
  EXPECT_EQ(report.nonFiniteVertices.firstExample, "vertex 5");
  EXPECT_FALSE(report.isReadable());
}

TEST(CheckMesh, FindsIndicesOutOfRange) {
  TriangleMesh mesh = makeBox({1.0, 1.0, 1.0});
  mesh.triangles[3][1] = 8;
  mesh.triangles[7][2] = -1;
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.indicesOutOfRange.count, 2);
  EXPECT_EQ(report.indicesOutOfRange.firstExample, "triangle 3");
}

TEST(CheckMesh, SeesThatAMeshIsInsideOut) {
  TriangleMesh mesh = makeIcosphere(1.0, 1);
  turnInsideOut(mesh);
  EXPECT_TRUE(checkMesh(mesh).isInsideOut());
  EXPECT_NE(checkMesh(mesh).text().find("turnInsideOut()"), std::string::npos);
  turnInsideOut(mesh);
  EXPECT_TRUE(checkMesh(mesh).isSolid());
}

TEST(CheckMesh, SaysThatAnEmptyMeshHasNoTriangles) {
  EXPECT_FALSE(checkMesh({}).isReadable());
  EXPECT_NE(checkMesh({}).text().find("no triangles"), std::string::npos);
}

TEST(WeldVertices, JoinsTheLooseTrianglesOfABox) {
  const TriangleMesh box = makeBox({1.0, 2.0, 3.0});
  TriangleMesh loose;
  for (const auto& t : box.triangles) {
    const auto first = static_cast<std::int32_t>(loose.vertices.size());
    for (std::int32_t v : t) loose.vertices.push_back(box.vertices[v]);
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  EXPECT_FALSE(checkMesh(loose).isClosed());
  EXPECT_EQ(weldVertices(loose), 36 - 8);
  EXPECT_TRUE(checkMesh(loose).isSolid());
}

TEST(WeldVertices, TakesMinusZeroForZero) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {-0.0, 0.0, -0.0}, {0.0, -1.0, 0.0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 1}};
  EXPECT_EQ(weldVertices(mesh), 1);
  EXPECT_EQ(mesh.triangles[1][0], 0);
}

TEST(WeldVertices, DropsTrianglesThatCollapse) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  weldVertices(mesh);
  EXPECT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.vertices.size(), 3u);
}

TEST(SeenFrom, UndoesThePoseThatPlacedAMesh) {
  const Pose pose{{1.0, -2.0, 0.5}, Quaternion(0.5, 0.5, -0.5, 0.5)};
  const TriangleMesh box = makeBox({1.0, 2.0, 3.0});
  TriangleMesh placed = box;
  for (Vector3& v : placed.vertices) v = pose.toWorld(v);
  const TriangleMesh back = seenFrom(pose, placed);
  for (std::size_t v = 0; v < box.vertices.size(); ++v)
    EXPECT_LT((back.vertices[v] - box.vertices[v]).norm(), 1e-14);
}

struct NamedMesh {
  const char* name;
  TriangleMesh mesh;
  double volume;  // of the round solid, m^3
};

TEST(MeshPrimitives, AreSolidsOfTheRightVolume) {
  constexpr double pi = std::numbers::pi;
  const NamedMesh meshes[] = {
      {"icosphere", makeIcosphere(0.5, 4), 4.0 / 3.0 * pi * 0.125},
      {"cylinder", makeCylinder(0.5, 2.0, 96), pi * 0.25 * 2.0},
      {"cone", makeCone(0.5, 2.0, 96), pi * 0.25 * 2.0 / 3.0},
      {"capsule", makeCapsule(0.5, 1.0, 96), pi * 0.25 * 1.0 + 4.0 / 3.0 * pi * 0.125},
      {"torus", makeTorus(1.0, 0.25, 96, 96), 2.0 * pi * pi * 0.0625},
  };
  for (const auto& [name, mesh, volume] : meshes) {
    const MeshReport report = checkMesh(mesh);
    EXPECT_TRUE(report.isSolid()) << name << ": " << report.text();
    EXPECT_EQ(report.degenerateTriangles.count, 0) << name;
    EXPECT_LT(report.volume, volume) << name;          // inscribed
    EXPECT_GT(report.volume, 0.995 * volume) << name;  // a 96-gon fills 0.9993 of its circle
  }
}

TEST(MeshPrimitives, PlanePatchIsOpenAndLooksUp) {
  const TriangleMesh patch = makePlanePatch(2.0, 3.0, 4);
  EXPECT_EQ(checkMesh(patch).openEdges.count, 16);
  for (const auto& t : patch.triangles) EXPECT_GT(doubleAreaVector(patch, t)[2], 0.0);
  EXPECT_NEAR(surfaceArea(patch), 6.0, 1e-12);
}

TEST(MeshPrimitives, RefuseSizesThatMakeNoSolid) {
  EXPECT_THROW(makeBox({1.0, 0.0, 1.0}), std::invalid_argument);
  EXPECT_THROW(makeTorus(0.2, 0.3, 16, 8), std::invalid_argument);
  EXPECT_THROW(makeCylinder(1.0, 1.0, 2), std::invalid_argument);
  EXPECT_THROW(makeIcosphere(std::nan(""), 1), std::invalid_argument);
}

}  // namespace
}  // namespace granular
