// SPDX-License-Identifier: MIT
// Normal law: Hertz with a constant damper, alpha = 0, beta = 3/2 (Bell 2005, eqs. 6-7 and 12): more elastic
// the faster the impact, which no material is. For comparison.
#pragma once

#include "granular/contact/hertz.h"

namespace granular {

struct HertzConstantDamping : Hertz<0> {
  /// Magnitude of the normal force, N, > 0 pushes apart. xi = overlap, m, > 0; xiDot = overlap rate, m/s.
  template <class Real>
  static Real force(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    return max(c.smallestForce, c.kr * xi * sqrt(xi) + c.kd * xiDot);
  }
  /// Growth of the force with the overlap rate, N s/m.
  template <class Real>
  static Real damping(const NormalConstantsOf<Real>& c, Real) {
    return c.kd;
  }
};

}  // namespace granular
