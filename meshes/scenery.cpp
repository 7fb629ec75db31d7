// SPDX-License-Identifier: MIT
// Hourglass, blade, pole and terrain.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/base/random.h"
#include "granular/geometry/mesh_primitives.h"
#include "meshes/mesh_builders.h"
#include "meshes/our_meshes.h"

namespace granular_meshes {
namespace {

using Profile = std::vector<std::pair<double, double>>;  // radius, height

// The hourglass, m.
constexpr double kHalfHeight = 0.5, kBulbRadius = 0.2, kGlass = 0.02;
constexpr double kDome = 0.14;    // height of the rounded end of a bulb
constexpr double kFunnel = 0.75;  // of the funnel's wall, across over up: 53 degrees from level, grains slide

/// Radius of the cavity a height above the neck: a funnel that opens as a hyperbola, smoothly into a domed
/// cylinder.
double cavityRadius(double neckRadius, double height) {
  constexpr double kBlend = 0.07;  // m
  const double funnel = std::hypot(neckRadius, kFunnel * height);
  const double h = std::max(kBlend - std::abs(funnel - kBulbRadius), 0.0) / kBlend;
  const double radius = std::min(funnel, kBulbRadius) - 0.25 * h * h * kBlend;
  const double inDome = std::max(0.0, (height - (kHalfHeight - kDome)) / kDome);
  return radius * std::sqrt(std::max(0.0, 1.0 - inDome * inDome));
}

/// Heights of the rings from the neck up; denser in the neck and in the dome, where the wall bends.
std::vector<double> ringHeights() {
  std::vector<double> heights;
  for (double z : {0.0, 0.025, 0.05, 0.08, 0.12, 0.16, 0.20, 0.225, 0.25, 0.275, 0.30, 0.33})
    heights.push_back(z);
  for (int k = 0; k < 7; ++k) {
    heights.push_back(kHalfHeight - kDome + kDome * std::sin(0.5 * std::numbers::pi * k / 7.0));
  }
  return heights;
}

/// The cavity's profile moved outwards by `wall`, m, along its normal.
Profile hourglassProfile(double neckRadius, double wall) {
  Profile upper;
  for (double z : ringHeights()) {
    constexpr double kStep = 1e-5;
    const double slope =
        (cavityRadius(neckRadius, z + kStep) - cavityRadius(neckRadius, std::abs(z - kStep))) / (2.0 * kStep);
    const double length = std::hypot(1.0, slope);
    upper.emplace_back(cavityRadius(neckRadius, z) + wall / length,
                       z == 0.0 ? 0.0 : z - wall * slope / length);
  }
  Profile profile{{0.0, -kHalfHeight - wall}};
  for (auto ring = upper.rbegin(); ring != upper.rend(); ++ring)
    profile.emplace_back(ring->first, -ring->second);
  profile.insert(profile.end(), upper.begin() + 1, upper.end());
  profile.emplace_back(0.0, kHalfHeight + wall);
  return profile;
}

TriangleMesh moved(TriangleMesh mesh, const Vector3& shift) {
  for (Vector3& v : mesh.vertices) v += shift;
  return mesh;
}

/// A turned post between two heights: beads at the ends and in the middle.
Profile postProfile(double radius, double low, double high) {
  Profile profile{{0.0, low}};
  const double middle = 0.5 * (low + high);
  const auto bead = [&](double z) {
    for (double a : {-60.0, -30.0, 0.0, 30.0, 60.0}) {
      const double angle = a * std::numbers::pi / 180.0;
      profile.emplace_back(radius * (0.6 + 0.8 * std::cos(angle)), z + 1.2 * radius * std::sin(angle));
    }
  };
  profile.emplace_back(radius, low);
  bead(low + 4.0 * radius);
  bead(middle);
  bead(high - 4.0 * radius);
  profile.emplace_back(radius, high);
  profile.emplace_back(0.0, high);
  return profile;
}

/// Smooth noise in [-1, 1] of wavelength 1: values at the points of a lattice, cubic in between.
double noise(double x, double y, const granular::Random& random) {
  const double i = std::floor(x), j = std::floor(y);
  const auto value = [&](double a, double b) {
    const auto item = static_cast<std::uint64_t>(static_cast<std::int64_t>(a + 4096.0) * 8192 +
                                                 static_cast<std::int64_t>(b + 4096.0));
    return random.forItem(item).uniform(-1.0, 1.0);
  };
  const auto ease = [](double t) { return t * t * (3.0 - 2.0 * t); };
  const double u = ease(x - i), v = ease(y - j);
  const double low = value(i, j) + u * (value(i + 1, j) - value(i, j));
  const double high = value(i, j + 1) + u * (value(i + 1, j + 1) - value(i, j + 1));
  return low + v * (high - low);
}

double terrainHeight(double x, double y) {
  constexpr double kEnd = 0.5, kBend = 2.0;  // m: the bend between slope and plain ends at x = kEnd
  constexpr double kSlope = 0.78;            // 38 degrees
  const double back = kEnd - x;
  if (back <= 0.0) return 0.0;
  const double slope = back < kBend ? 0.5 * kSlope * back * back / kBend : kSlope * (back - 0.5 * kBend);
  const double grown = std::min(1.0, back / 3.0);  // gully and rocks fade out towards the plain
  const double gully = 0.075 * y * y / (1.0 + 0.04 * y * y);
  const granular::Random random(20);
  const double rocks =
      0.16 * noise(0.8 * x, 0.8 * y, random) + 0.07 * noise(2.1 * x, 2.1 * y, random.forItem(7));
  return slope + grown * grown * (gully + rocks);
}

}  // namespace

TriangleMesh makeHourglass(double neckRadius) {
  constexpr int kSegments = 36;
  TriangleMesh glass = granular::makeRevolution(hourglassProfile(neckRadius, kGlass), kSegments);
  TriangleMesh cavity = granular::makeRevolution(hourglassProfile(neckRadius, 0.0), kSegments);
  granular::turnInsideOut(cavity);
  granular::append(glass, cavity);
  return glass;
}

TriangleMesh makeHourglassFrame() {
  constexpr double kGap = 0.004, kPlate = 0.05, kPlateRadius = 0.32, kPostCircle = 0.27;
  const double inside = kHalfHeight + kGlass + kGap;
  TriangleMesh frame;
  for (double side : {-1.0, 1.0}) {
    // Edges broken by 1 cm.
    const double low = side > 0.0 ? inside : -inside - kPlate, high = low + kPlate;
    granular::append(frame, granular::makeRevolution({{0.0, low},
                                                      {kPlateRadius - 0.01, low},
                                                      {kPlateRadius, low + 0.01},
                                                      {kPlateRadius, high - 0.01},
                                                      {kPlateRadius - 0.01, high},
                                                      {0.0, high}},
                                                     48));
  }
  const TriangleMesh post = granular::makeRevolution(postProfile(0.016, -inside + kGap, inside - kGap), 12);
  for (int k = 0; k < 4; ++k) {
    const double angle = 0.25 * std::numbers::pi + 0.5 * std::numbers::pi * k;
    granular::append(frame, moved(post, {kPostCircle * std::cos(angle), kPostCircle * std::sin(angle), 0.0}));
  }
  return frame;
}

TriangleMesh makeBlade() {
  constexpr double kHalfWidth = 1.6, kWingFrom = 1.15, kWing = 0.42, kHeight = 1.1;
  constexpr double kHollow = 0.2, kEdge = 0.03, kPlate = 0.1, kRib = 0.12;
  struct Station {
    double y;
    bool isRib;
  };
  std::vector<Station> stations;
  for (int k = 0; k <= 16; ++k) stations.push_back({kHalfWidth * (k - 8) / 8.0, false});
  for (double rib : {-0.95, -0.32, 0.32, 0.95}) {
    for (double side : {-1.0, 1.0}) {
      stations.push_back({rib + side * 0.051, false});
      stations.push_back({rib + side * 0.05, true});
    }
  }
  std::sort(stations.begin(), stations.end(), [](const Station& a, const Station& b) { return a.y < b.y; });
  std::erase_if(stations, [&](const Station& s) {
    return !s.isRib && std::any_of(stations.begin(), stations.end(), [&](const Station& other) {
      return other.isRib && other.y != s.y && std::abs(other.y - s.y) < 0.05 &&
             std::abs(other.y - s.y) > 0.002;
    });
  });
  std::vector<std::vector<Vector3>> sections;
  for (const Station& station : stations) {
    const double beyond = std::max(0.0, std::abs(station.y) - kWingFrom) / (kHalfWidth - kWingFrom);
    const double forward = kWing * beyond * beyond;
    std::vector<Vector3> section;
    constexpr int kSteps = 10;
    const auto hollow = [&](double up) { return forward - kHollow * (1.0 - std::pow(2.0 * up - 1.0, 2)); };
    for (int k = 0; k <= kSteps; ++k) {
      const double up = k / static_cast<double>(kSteps);
      section.emplace_back(hollow(up), station.y, up * kHeight);
    }
    for (int k = kSteps; k >= 0; --k) {
      const double up = k / static_cast<double>(kSteps);
      const double rib = station.isRib && k > 1 && k < kSteps - 1 ? kRib : 0.0;
      section.emplace_back(hollow(up) - (k == 0 ? kEdge : kPlate) - rib, station.y, up * kHeight);
    }
    std::reverse(section.begin(), section.end());
    sections.push_back(section);
  }
  return loft(sections);
}

TriangleMesh makePole() {
  constexpr double kRadius = 0.06, kTop = 1.0;
  Profile profile{{0.0, 0.0}, {kRadius, 0.0}};
  for (int k = 0; k < 5; ++k) {
    const double angle = 0.5 * std::numbers::pi * k / 5.0;
    profile.emplace_back(kRadius * std::cos(angle), kTop - kRadius + kRadius * std::sin(angle));
  }
  profile.emplace_back(0.0, kTop);
  return granular::makeRevolution(profile, 24);
}

TriangleMesh makeTerrain() {
  constexpr int kAlong = 52, kAcross = 30;                      // squares
  constexpr double kFromX = -7.5, kHalfY = 3.75, kStep = 0.25;  // m
  constexpr double kBottom = -0.5;
  TriangleMesh mesh;
  const auto at = [](int i, int j) { return static_cast<std::int32_t>(j * (kAlong + 1) + i); };
  for (int j = 0; j <= kAcross; ++j) {
    for (int i = 0; i <= kAlong; ++i) {
      const double x = kFromX + kStep * i, y = -kHalfY + kStep * j;
      mesh.vertices.emplace_back(x, y, terrainHeight(x, y));
    }
  }
  for (int j = 0; j < kAcross; ++j) {
    for (int i = 0; i < kAlong; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  // The rim, counter-clockwise from above, dropped to the bottom; the bottom is a fan.
  std::vector<std::int32_t> rim;
  for (int i = 0; i < kAlong; ++i) rim.push_back(at(i, 0));
  for (int j = 0; j < kAcross; ++j) rim.push_back(at(kAlong, j));
  for (int i = kAlong; i > 0; --i) rim.push_back(at(i, kAcross));
  for (int j = kAcross; j > 0; --j) rim.push_back(at(0, j));
  const auto first = static_cast<std::int32_t>(mesh.vertices.size());
  const auto count = static_cast<std::int32_t>(rim.size());
  for (std::int32_t v : rim) mesh.vertices.emplace_back(mesh.vertices[v][0], mesh.vertices[v][1], kBottom);
  mesh.vertices.emplace_back(kFromX + 0.5 * kStep * kAlong, 0.0, kBottom);
  for (std::int32_t k = 0; k < count; ++k) {
    const std::int32_t next = (k + 1) % count;
    mesh.triangles.push_back({rim[k], first + k, first + next});
    mesh.triangles.push_back({rim[k], first + next, rim[next]});
    mesh.triangles.push_back({first + count, first + next, first + k});
  }
  return mesh;
}

}  // namespace granular_meshes
