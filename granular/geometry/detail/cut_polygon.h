// SPDX-License-Identifier: MIT
// Cuts a polygon into triangles by clipping ears: a corner whose triangle holds no other corner is cut off,
// until three are left. Concave polygons come out right; convex ones take one look.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "granular/base/pose.h"

namespace granular::detail {

/// Triangles of a nearly plane polygon, as positions in `corners` (at least 3, m, in order round it), turning
/// the same way. Always corners.size() - 2 of them, so that closed surfaces stay closed; of a polygon that
/// crosses itself some may overlap. Time grows with the cube of the number of corners at worst.
std::vector<std::array<std::int32_t, 3>> cutPolygon(std::span<const Vector3> corners);

}  // namespace granular::detail
