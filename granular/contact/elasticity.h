// SPDX-License-Identifier: MIT
// What two touching round particles have in common: effective mass, radius and modulus (Bell 2005, eqs. 11,
// 13, 14).
#pragma once

#include <cmath>

namespace granular {

/// One side of a contact as the laws' constants see it.
struct ContactSide {
  double inverseMass = 0.0;    ///< of the owner, 1/kg; 0 for what the host moves
  double inverseRadius = 0.0;  ///< of the particle, 1/m; 0 for a plane
  double youngsModulus = 0.0;  ///< Pa
  double poissonRatio = 0.0;
};

/// The pair: all > 0.
struct EffectiveContact {
  double mass = 0.0;     ///< m_eff, kg (eq. 11); 1 kg where both sides are held, whose forces move nothing
  double radius = 0.0;   ///< R_eff, m (eq. 13)
  double modulus = 0.0;  ///< E_eff, Pa (eq. 14)

  /// Hertz stiffness kr, N/m^(3/2) (eq. 15).
  double hertzStiffness() const { return 4.0 / 3.0 * modulus * std::sqrt(radius); }
};

inline EffectiveContact effectiveContact(const ContactSide& a, const ContactSide& b) {
  const double inverseMass = a.inverseMass + b.inverseMass;
  const auto compliance = [](const ContactSide& s) {
    return (1.0 - s.poissonRatio * s.poissonRatio) / s.youngsModulus;
  };
  return {.mass = inverseMass > 0.0 ? 1.0 / inverseMass : 1.0,
          .radius = 1.0 / (a.inverseRadius + b.inverseRadius),
          .modulus = 1.0 / (compliance(a) + compliance(b))};
}

}  // namespace granular
