// SPDX-License-Identifier: MIT
// Runs the very text that the README shows and checks what it prints.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#define main helloSand
#include "../demos/hello_sand.cpp"  // NOLINT: the program is the thing under test
#undef main

// Slab: upper face at 0.0625 m. Ball: radius 0.0625 m. Grains: tetrahedra of particles of radius 0.01 m,
// whose centre of mass lies 0.01 m above a floor they stand on; the slab's particles touch its face from
// inside with dips between them.
TEST(HelloSand, BallRestsInTheSandAboveTheSlab) {
  testing::internal::CaptureStdout();
  helloSand();
  double ball = 0.0;
  double lowest = 0.0;
  const std::string line = testing::internal::GetCapturedStdout();
  ASSERT_EQ(std::sscanf(line.c_str(), "ball at %lf m, lowest grain at %lf m", &ball, &lowest), 2) << line;
  EXPECT_GT(ball, 0.0625 + 0.0625) << "through the slab";
  EXPECT_LT(ball, 0.1625 + 0.0625) << "still on top of the pile it fell on from a quarter of a metre above";
  EXPECT_GT(lowest, 0.0625) << "a grain is below the slab's upper face";
}
