// SPDX-License-Identifier: MIT
// Meshes as people have them: faces turned, gaps, parts inside out. Volumes are those of the whole solid.
#include "granular/geometry/mesh_repair.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "granular/base/random.h"
#include "granular/geometry/mass_properties.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

TEST(MeshRepair, LeavesASolidAsItIs) {
  const TriangleMesh torus = makeTorus(1.0, 0.3, 24, 12);
  MeshRepair repair;
  EXPECT_EQ(repairMesh(torus, &repair).triangles, torus.triangles);
  EXPECT_TRUE(repair.isNothing()) << repair.text();
  EXPECT_EQ(repair.text(), "");
}

TEST(MeshRepair, TurnsFacesThatLookTheWrongWay) {
  TriangleMesh ball = makeIcosphere(1.0, 3);
  Random random(4);
  std::int64_t turned = 0;
  for (auto& t : ball.triangles) {
    if (random.uniform() > 0.3) continue;
    std::swap(t[0], t[1]);
    ++turned;
  }
  MeshRepair repair;
  const TriangleMesh solid = repairMesh(ball, &repair);
  EXPECT_EQ(repair.turnedTriangles, turned);
  EXPECT_NEAR(signedVolume(solid), signedVolume(makeIcosphere(1.0, 3)), 1e-12);
}

TEST(MeshRepair, TurnsASolidThatIsInsideOut) {
  TriangleMesh box = makeBox({1.0, 2.0, 3.0});
  turnInsideOut(box);
  MeshRepair repair;
  EXPECT_NEAR(massProperties(repairMesh(box, &repair), 1.0).mass, 6.0, 1e-12);
  EXPECT_EQ(repair.turnedParts, 1);
}

TEST(MeshRepair, TurnsOneOfTwoBallsButNotACavity) {
  TriangleMesh mesh = makeBox({2.0, 2.0, 2.0});
  TriangleMesh cavity = makeBox({1.0, 1.0, 1.0});
  turnInsideOut(cavity);
  append(mesh, cavity);
  TriangleMesh beside = makeBox({1.0, 1.0, 1.0});
  for (Vector3& v : beside.vertices) v[0] += 5.0;
  turnInsideOut(beside);
  append(mesh, beside);
  MeshRepair repair;
  EXPECT_NEAR(signedVolume(repairMesh(mesh, &repair)), 8.0 - 1.0 + 1.0, 1e-12);
  EXPECT_EQ(repair.turnedParts, 1);
}

TEST(MeshRepair, ClosesGapsOfAnySize) {
  TriangleMesh ball = makeIcosphere(1.0, 4);
  const double whole = signedVolume(ball);
  // A cap of height 0.2: a gap of pi (1 - 0.8^2) = 1.13 m^2; and one triangle on the other side.
  std::size_t lost = 0;
  std::erase_if(ball.triangles, [&](const auto& t) {
    const double z = (ball.vertices[t[0]] + ball.vertices[t[1]] + ball.vertices[t[2]])[2] / 3.0;
    const bool goes = z > 0.8 || (z < -0.99 && lost++ == 0);
    return goes;
  });
  MeshRepair repair;
  const TriangleMesh solid = repairMesh(ball, &repair);
  EXPECT_TRUE(checkMesh(solid).isSolid()) << checkMesh(solid).text();
  EXPECT_EQ(repair.closedGaps, 2);
  // The cap's volume, pi h^2 (3 - h) / 3, is gone, to the width of a triangle at its rim.
  EXPECT_NEAR(signedVolume(solid), whole - 0.1173, 0.03);
}

TEST(MeshRepair, DropsRepeatedTriangles) {
  TriangleMesh box = makeBox({1.0, 1.0, 1.0});
  box.triangles.push_back(box.triangles[3]);
  MeshRepair repair;
  EXPECT_TRUE(checkMesh(repairMesh(box, &repair)).isSolid());
  EXPECT_EQ(repair.droppedTriangles, 1);
}

TEST(MeshRepair, FindsPartsInsideOthers) {
  TriangleMesh boxes = makeBox({2.0, 1.0, 1.0});
  append(boxes, makeBox({0.5, 0.5, 0.5}));
  MeshRepair repair;
  repairMesh(boxes, &repair);
  EXPECT_EQ(repair.buriedTriangles.count, 12);
  EXPECT_EQ(repair.buriedTriangles.firstExample, "triangle 12");
}

TEST(MeshRepair, RefusesWhatCannotMeanASolid) {
  EXPECT_THROW(repairMesh({}), std::invalid_argument);
  EXPECT_THROW(repairMesh(makePlanePatch(1.0, 1.0, 3)), std::invalid_argument);
  TriangleMesh flat = makeBox({1.0, 1.0, 1.0});
  for (Vector3& v : flat.vertices) v[2] = 0.0;
  EXPECT_THROW(repairMesh(flat), std::invalid_argument);
  TriangleMesh point = makeBox({1.0, 1.0, 1.0});
  for (Vector3& v : point.vertices) v.setZero();
  EXPECT_THROW(repairMesh(point), std::invalid_argument);
  TriangleMesh notFinite = makeBox({1.0, 1.0, 1.0});
  notFinite.vertices[2][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(repairMesh(notFinite), std::invalid_argument);
}

TEST(MakeSheet, HasTheVolumeOfAreaTimesThickness) {
  const TriangleMesh sheet = makeSheet(makePlanePatch(2.0, 1.0, 3), 0.01);
  EXPECT_TRUE(checkMesh(sheet).isSolid()) << checkMesh(sheet).text();
  EXPECT_NEAR(signedVolume(sheet), 0.02, 1e-15);
  // A thin shell of a ball: 4 pi t, to the square of thickness and edge.
  EXPECT_NEAR(signedVolume(makeSheet(makeIcosphere(1.0, 4), 0.01)), 4.0 * std::numbers::pi * 0.01, 5e-4);
  EXPECT_THROW(makeSheet(makePlanePatch(1.0, 1.0), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace granular
