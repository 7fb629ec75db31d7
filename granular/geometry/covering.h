// SPDX-License-Identifier: MIT
// The round particles fixed to a body's surface (Bell 2005, sec. 3.3): all that contact ever sees of a body.
#pragma once

#include <vector>

#include "granular/base/pose.h"

namespace granular {

struct Covering {
  std::vector<Vector3> positions = {};  ///< centre of particle i, body frame (origin: centre of mass), m
  std::vector<double> radii = {};       ///< radius of particle i, m; same length
  /// The surface that particle i stands for: sum of a n n^T over its pieces of area a and outward normal n,
  /// body frame, m^2. The area it shows to a contact along N is N^T A N. Empty: 2 sqrt(3) r^2 in every
  /// direction, a particle's share in a hexagonal layer of touching ones.
  std::vector<Matrix3> areas = {};
};

}  // namespace granular
