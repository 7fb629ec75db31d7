// SPDX-License-Identifier: MIT
// Normal law: Hertz with a constant damper, alpha = 0, beta = 3/2 (Bell 2005, eqs. 6-7 and 12): more elastic
// the faster the impact, which no material is. For comparison.
#pragma once

#include <algorithm>

#include "granular/contact/hertz.h"

namespace granular {

struct HertzConstantDamping : Hertz<0> {
  /// Magnitude of the normal force, N, > 0 pushes apart. xi = overlap, m, > 0; xiDot = overlap rate, m/s.
  static double force(const NormalConstants& c, double xi, double xiDot) {
    return std::max(c.smallestForce, c.kr * xi * std::sqrt(xi) + c.kd * xiDot);
  }
};

}  // namespace granular
