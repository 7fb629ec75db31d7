// SPDX-License-Identifier: MIT
// Normal law: Hertz with the damping of Tsuji et al. 1992, alpha = 1/4, beta = 3/2 (Bell 2005, eqs. 6-7 and
// 12): the same restitution at every impact speed.
#pragma once

#include <algorithm>

#include "granular/contact/hertz.h"

namespace granular {

struct HertzTsuji : Hertz<1> {
  /// Magnitude of the normal force, N, > 0 pushes apart. xi = overlap, m, > 0; xiDot = overlap rate, m/s.
  static double force(const NormalConstants& c, double xi, double xiDot) {
    const double root = std::sqrt(xi);
    return std::max(c.smallestForce, c.kr * xi * root + c.kd * std::sqrt(root) * xiDot);
  }
};

}  // namespace granular
