// SPDX-License-Identifier: MIT
#include "granular/geometry/winding_number.h"

#include <gtest/gtest.h>

#include "granular/base/random.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_primitives.h"

namespace granular {
namespace {

Vector3 randomPoint(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

TEST(WindingNumber, IsOneInsideABallAndZeroOutside) {
  const WindingNumber winding(makeIcosphere(1.0, 4));
  Random random(1);
  for (int n = 0; n < 500; ++n) {
    const Vector3 p = randomPoint(random, 1.6);
    if (std::abs(p.norm() - 1.0) < 0.01) continue;  // between the ball and its facets
    EXPECT_NEAR(winding.at(p), p.norm() < 1.0 ? 1.0 : 0.0, 0.05) << p.transpose();
  }
}

TEST(WindingNumber, IsTheSumOfAllSolidAngles) {
  const TriangleMesh torus = makeTorus(1.0, 0.3, 60, 30);
  const WindingNumber winding(torus);
  Random random(2);
  for (int n = 0; n < 200; ++n) {
    const Vector3 p = randomPoint(random, 1.5);
    double sum = 0.0;
    for (const auto& t : torus.triangles) {
      sum += windingOfTriangle(torus.vertices[t[0]], torus.vertices[t[1]], torus.vertices[t[2]], p);
    }
    EXPECT_NEAR(winding.at(p), sum, 0.05) << p.transpose();
  }
}

TEST(WindingNumber, IsTwoWhereBoxesOverlapAndZeroInACavity) {
  TriangleMesh boxes = makeBox({2.0, 1.0, 1.0});
  append(boxes, makeBox({1.0, 2.0, 1.0}));
  EXPECT_NEAR(WindingNumber(boxes).at({0.1, 0.2, 0.1}), 2.0, 1e-9);
  TriangleMesh hollow = makeBox({2.0, 2.0, 2.0});
  TriangleMesh cavity = makeBox({1.0, 1.0, 1.0});
  turnInsideOut(cavity);
  append(hollow, cavity);
  EXPECT_NEAR(WindingNumber(hollow).at({0.1, 0.2, 0.1}), 0.0, 1e-9);
  EXPECT_NEAR(WindingNumber(hollow).at({0.8, 0.2, 0.1}), 1.0, 1e-9);
}

// A cube of six faces: without one of them its middle is five sixths inside.
TEST(WindingNumber, OfAnOpenCubeIsFiveSixthsInItsMiddle) {
  TriangleMesh cube = makeBox({1.0, 1.0, 1.0});
  std::erase_if(cube.triangles, [&](const auto& t) {
    return cube.vertices[t[0]][2] + cube.vertices[t[1]][2] + cube.vertices[t[2]][2] > 1.4;
  });
  ASSERT_EQ(cube.triangles.size(), 10u);
  EXPECT_NEAR(WindingNumber(cube).at(Vector3::Zero()), 5.0 / 6.0, 1e-12);
}

TEST(WindingNumber, GivesMeshDistanceItsSignWherePartsOverlap) {
  TriangleMesh boxes = makeBox({2.0, 1.0, 1.0});
  append(boxes, makeBox({1.0, 2.0, 1.0}));
  const MeshDistance distance(boxes, MeshSign::WindingNumber);
  Random random(3);
  for (int n = 0; n < 500; ++n) {
    const Vector3 p = randomPoint(random, 1.2);
    const bool isInside = (std::abs(p[0]) < 1.0 && std::abs(p[1]) < 0.5 && std::abs(p[2]) < 0.5) ||
                          (std::abs(p[0]) < 0.5 && std::abs(p[1]) < 1.0 && std::abs(p[2]) < 0.5);
    EXPECT_EQ(distance.nearest(p).signedDistance < 0.0, isInside) << p.transpose();
  }
}

}  // namespace
}  // namespace granular
