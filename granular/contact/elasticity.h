// SPDX-License-Identifier: MIT
// What two touching round particles have in common: effective mass, radius and modulus (Bell 2005, eqs. 11,
// 13, 14).
#pragma once

#include "granular/base/pack.h"

namespace granular {

/// One side of a contact as the laws' constants see it.
struct ContactSide {
  double inverseMass = 0.0;    ///< of the owner, 1/kg; 0 for what the host moves
  double inverseRadius = 0.0;  ///< of the particle, 1/m; 0 for a plane
  double youngsModulus = 0.0;  ///< Pa
  double poissonRatio = 0.0;
};

/// The pair, or several of the same materials at a time: all > 0.
template <class Real>
struct EffectiveContactOf {
  Real mass = 0.0;       ///< m_eff, kg (eq. 11); 1 kg where both sides are held, whose forces move nothing
  Real radius = 0.0;     ///< R_eff, m (eq. 13)
  double modulus = 0.0;  ///< E_eff, Pa (eq. 14)

  /// Hertz stiffness kr, N/m^(3/2) (eq. 15).
  Real hertzStiffness() const { return 4.0 / 3.0 * modulus * sqrt(radius); }
};
using EffectiveContact = EffectiveContactOf<double>;

/// E_eff of two materials, Pa (eq. 14).
inline double effectiveModulus(double modulus1, double poisson1, double modulus2, double poisson2) {
  return 1.0 / ((1.0 - poisson1 * poisson1) / modulus1 + (1.0 - poisson2 * poisson2) / modulus2);
}

inline EffectiveContact effectiveContact(const ContactSide& a, const ContactSide& b) {
  const double inverseMass = a.inverseMass + b.inverseMass;
  return {.mass = inverseMass > 0.0 ? 1.0 / inverseMass : 1.0,
          .radius = 1.0 / (a.inverseRadius + b.inverseRadius),
          .modulus = effectiveModulus(a.youngsModulus, a.poissonRatio, b.youngsModulus, b.poissonRatio)};
}

}  // namespace granular
