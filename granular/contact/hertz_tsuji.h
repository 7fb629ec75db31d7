// SPDX-License-Identifier: MIT
// Normal law: Hertz with the damping of Tsuji et al. 1992, alpha = 1/4, beta = 3/2 (Bell 2005, eqs. 6-7 and
// 12): the same restitution at every impact speed.
#pragma once

#include "granular/contact/hertz.h"

namespace granular {

struct HertzTsuji : Hertz<1> {
  /// Magnitude of the normal force, N, > 0 pushes apart. xi = overlap, m, > 0; xiDot = overlap rate, m/s.
  template <class Real>
  static Real force(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    const Real root = sqrt(xi);
    return max(c.smallestForce, c.kr * xi * root + c.kd * sqrt(root) * xiDot);
  }
  /// Growth of the force with the overlap rate, N s/m.
  template <class Real>
  static Real damping(const NormalConstantsOf<Real>& c, Real xi) {
    return c.kd * sqrt(Real(sqrt(xi)));
  }
};

}  // namespace granular
