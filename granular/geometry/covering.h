// SPDX-License-Identifier: MIT
// The round particles fixed to a body's surface (Bell 2005, sec. 3.3): all that contact ever sees of a body.
#pragma once

#include <vector>

#include "granular/base/pose.h"

namespace granular {

struct Covering {
  std::vector<Vector3> positions = {};  ///< centre of particle i, body frame (origin: centre of mass), m
  std::vector<double> radii = {};       ///< radius of particle i, m; same length
};

}  // namespace granular
