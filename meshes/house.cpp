// SPDX-License-Identifier: MIT
#include <cmath>

#include "meshes/mesh_builders.h"
#include "meshes/our_meshes.h"

namespace granular_meshes {
namespace {

// The house, m. The pitch is gentle enough that the roof rests on its walls by friction alone (0.5 and more).
constexpr double kHalfLength = 2.0, kHalfDepth = 1.5, kWall = 0.2, kEaves = 2.4;
constexpr double kPitch = 0.45;  // rise over run
constexpr double kJoint = 0.005;

/// Height of the roof's lower face above the point y.
double roofAbove(double y) {
  return kEaves + kPitch * (kHalfDepth - std::abs(y));
}

/// A long wall between y and y + kWall; its top follows the roof.
TriangleMesh longWall(double y, const std::vector<double>& x, const std::vector<double>& z,
                      const std::function<bool(int, int)>& isFilled) {
  TriangleMesh wall = latticeSolid(x, {y, y + kWall}, z, [&](int i, int, int k) { return isFilled(i, k); });
  for (Vector3& v : wall.vertices) {
    if (v[2] == kEaves) v[2] = roofAbove(v[1]) - kJoint;
  }
  return wall;
}

}  // namespace

TriangleMesh makeHouseFront() {
  // Cuts 1-2 and 5-6 along x are windows, 3-4 the door; cut 1-2 upwards are the windows' heights.
  return longWall(-kHalfDepth, {-kHalfLength, -1.6, -0.95, -0.45, 0.45, 0.95, 1.6, kHalfLength},
                  {0.0, 1.0, 1.75, 2.0, kEaves}, [](int i, int k) {
                    const bool isWindow = (i == 1 || i == 5) && k == 1;
                    const bool isDoor = i == 3 && k <= 2;
                    return !isWindow && !isDoor;
                  });
}

TriangleMesh makeHouseBack() {
  return longWall(kHalfDepth - kWall, {-kHalfLength, -1.3, -0.5, 0.5, 1.3, kHalfLength},
                  {0.0, 0.9, 1.75, kEaves}, [](int i, int k) { return !((i == 1 || i == 3) && k == 1); });
}

TriangleMesh makeHouseGable() {
  const double y = kHalfDepth - kWall - kJoint;
  std::vector<std::vector<Vector3>> sections;
  for (double x : {kHalfLength - kWall, kHalfLength}) {
    sections.push_back({{x, -y, 0.0},
                        {x, y, 0.0},
                        {x, y, roofAbove(y) - kJoint},
                        {x, 0.0, roofAbove(0.0) - kJoint},
                        {x, -y, roofAbove(y) - kJoint}});
  }
  return loft(sections);
}

TriangleMesh makeHouseRoof() {
  constexpr double kThickness = 0.16, kOverhang = 0.3;
  const double ridge = 0.5 * kJoint, eave = kHalfDepth + kOverhang;
  std::vector<std::vector<Vector3>> sections;
  for (double x : {-kHalfLength - kOverhang, kHalfLength + kOverhang}) {
    sections.push_back({{x, ridge, roofAbove(ridge)},
                        {x, eave, roofAbove(eave)},
                        {x, eave, roofAbove(eave) + kThickness},
                        {x, ridge, roofAbove(ridge) + kThickness}});
  }
  return loft(sections);
}

TriangleMesh makeHouseChimney() {
  constexpr double kSide = 0.6, kBrick = 0.16, kHeight = 4.0, kHood = 0.08;
  const double x = kHalfLength + 0.4;
  TriangleMesh tube = latticeSolid({x, x + kBrick, x + kSide - kBrick, x + kSide},
                                   {-0.5 * kSide, -0.5 * kSide + kBrick, 0.5 * kSide - kBrick, 0.5 * kSide},
                                   {0.0, kHeight}, [](int i, int j, int) { return i != 1 || j != 1; });
  // Wider at the foot, as chimneys are.
  for (Vector3& v : tube.vertices) {
    if (v[2] > 0.0) continue;
    if (v[0] == x + kSide) v[0] += kHood;
    if (std::abs(v[1]) == 0.5 * kSide) v[1] += std::copysign(kHood, v[1]);
  }
  return tube;
}

}  // namespace granular_meshes
