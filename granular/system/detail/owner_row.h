// SPDX-License-Identifier: MIT
// Where an owner is and how it moves, as contacts read it.
#pragma once

#include <array>

#include "granular/base/pose.h"

namespace granular::detail {

struct OwnerRow {
  Vector3 center, velocity, angularVelocity;
  std::array<double, 3> padding;
};
static_assert(sizeof(OwnerRow) == 96);

}  // namespace granular::detail
