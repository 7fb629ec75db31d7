// SPDX-License-Identifier: MIT
// Normal law: Hertz with viscoelastic damping, alpha = 1/2, beta = 3/2 (Bell 2005, eqs. 6-7 and 12). The
// default: restitution falls with impact speed as experiments do, 1 - e_n ~ v^(1/5).
#pragma once

#include "granular/contact/hertz.h"

namespace granular {

struct HertzViscoelastic : Hertz<2> {
  /// Magnitude of the normal force, N, > 0 pushes apart. xi = overlap, m, > 0; xiDot = overlap rate, m/s, > 0
  /// while the particles approach.
  template <class Real>
  static Real force(const NormalConstantsOf<Real>& c, Real xi, Real xiDot) {
    return max(c.smallestForce, sqrt(xi) * (c.kr * xi + c.kd * xiDot));
  }
  /// Growth of the force with the overlap rate, N s/m.
  template <class Real>
  static Real damping(const NormalConstantsOf<Real>& c, Real xi) {
    return c.kd * sqrt(xi);
  }
};

}  // namespace granular
