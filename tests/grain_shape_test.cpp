// SPDX-License-Identifier: MIT
#include "granular/system/grain_shape.h"

#include <gtest/gtest.h>

#include <numbers>

namespace granular {
namespace {

double sphereMass(double radius) {
  return 4.0 / 3.0 * std::numbers::pi * radius * radius * radius;
}

TEST(GrainShape, SphereHasTheInertiaOfASolidSphere) {
  const GrainShape shape = makeGrainShape(sphereShape(0.02));
  EXPECT_DOUBLE_EQ(shape.volume, sphereMass(0.02));
  EXPECT_NEAR(shape.unitInertia.x(), 0.4 * sphereMass(0.02) * 0.02 * 0.02, 1e-13 * shape.unitInertia.x());
  EXPECT_TRUE(shape.isotropic);
}

TEST(GrainShape, FourTouchingSpheresHaveInertia5p6) {
  const double r = 0.003;
  const GrainShape shape = makeGrainShape(tetrahedronShape(r));
  const double expected = 5.6 * sphereMass(r) * r * r;  // Steiner: 4 (2/5 + 3/2 * 2/3) m r^2
  EXPECT_TRUE(shape.isotropic);
  EXPECT_NEAR(shape.unitInertia.x(), expected, 1e-12 * expected);
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      EXPECT_NEAR((shape.particles[i].position - shape.particles[j].position).norm(), 2.0 * r, 1e-15);
    }
  }
}

TEST(GrainShape, CubeOfEightSpheresHasInertia19p2) {
  const double r = 0.5;
  const GrainShape shape = makeGrainShape(cubeShape(r));
  EXPECT_TRUE(shape.isotropic);
  EXPECT_NEAR(shape.unitInertia.z(), 19.2 * sphereMass(r) * r * r, 1e-12);
}

TEST(GrainShape, PrincipalFrameOfARodLiesAlongTheRod) {
  const Vector3 along = Vector3(1, 2, -2) / 3.0;
  GrainShapeDef rod{.name = "rod", .particles = {}};
  for (int i = 0; i < 4; ++i) rod.particles.push_back({Vector3(5, 0, 1) + i * 0.02 * along, 0.01});
  const GrainShape shape = makeGrainShape(rod);
  EXPECT_LT((shape.principalFrame.position - Vector3(5, 0, 1) - 0.03 * along).norm(), 1e-14);
  EXPECT_FALSE(shape.isotropic);
  // Smallest moment about the rod: 4 solid spheres on the axis.
  const double about = 4.0 * 0.4 * sphereMass(0.01) * 1e-4;
  EXPECT_NEAR(shape.unitInertia.minCoeff(), about, 1e-12 * about);
  for (std::size_t i = 0; i < rod.particles.size(); ++i) {
    const Vector3 back = shape.principalFrame.toWorld(shape.particles[i].position);
    EXPECT_LT((back - rod.particles[i].position).norm(), 1e-14);
  }
}

TEST(GrainShape, RefusesWhatCannotBeAGrain) {
  EXPECT_THROW(makeGrainShape({}), std::invalid_argument);
  EXPECT_THROW(makeGrainShape(sphereShape(0.0)), std::invalid_argument);
  EXPECT_THROW(makeGrainShape(sphereShape(std::nan(""))), std::invalid_argument);
  try {
    makeGrainShape(sphereShape(-0.01));
    FAIL() << "a negative radius was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "GrainShapeDef.particles.radius is -0.01 m; it must be finite and > 0");
  }
}

}  // namespace
}  // namespace granular
