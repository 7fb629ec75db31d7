// SPDX-License-Identifier: MIT
// The round particles fixed to a body's surface (Bell 2005, sec. 3.3): all that contact ever sees of a body.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "granular/base/pose.h"

namespace granular {

/// A triangle of surface that one particle stands for.
struct SurfacePiece {
  std::int32_t particle = 0;  ///< its index
  /// Body frame, m, counter-clockwise seen from outside.
  std::array<Vector3, 3> corners = {Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};

  /// Outward, as long as the piece has area, m^2.
  Vector3 areaVector() const { return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]); }
};

struct Covering {
  std::vector<Vector3> positions = {};  ///< centre of particle i, body frame (origin: centre of mass), m
  std::vector<double> radii = {};       ///< radius of particle i, m; same length
  /// What the particles stand for when bodies press against each other, in the order of their particles; one
  /// at an edge has some of either side. A particle without a piece carries no such load. Empty: every
  /// particle shows 2 sqrt(3) r^2 in every direction, its share in a hexagonal layer of touching ones.
  std::vector<SurfacePiece> pieces = {};
};

}  // namespace granular
