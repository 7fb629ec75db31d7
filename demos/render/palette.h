// SPDX-License-Identifier: MIT
// Colours for things: numbers to a colour scale, owners to distinct tints, grains to sand.
#pragma once

#include <cstdint>

#include "demos/render/color.h"

namespace granular_demo {

/// Position t on the scale "viridis" (van der Walt & Smith 2015), dark violet at 0 to yellow at 1; t is
/// clamped.
Color viridis(double t);

/// viridis of where `value` lies between `low` and `high`; a range without width gives the middle of the
/// scale.
Color colorByScalar(double value, double low, double high);

/// Colour of one grain of mixed quartz sand: the same for the same id, a little different for each.
Color sandColor(std::uint64_t grain);

/// One of endlessly many tints of even lightness that tell neighbours apart (hue steps by the golden angle).
Color ownerColor(std::uint64_t owner);

}  // namespace granular_demo
