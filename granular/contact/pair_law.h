// SPDX-License-Identifier: MIT
// The constants of the contact laws for one kind of pair, worked out from the two materials and the pair
// rule.
#pragma once

#include <string_view>

#include "granular/contact/elasticity.h"
#include "granular/contact/hertz_viscoelastic.h"
#include "granular/contact/material.h"
#include "granular/contact/regularised_coulomb.h"

namespace granular {

/// Throw std::invalid_argument naming the field, its value and what is allowed.
void checkMaterial(const MaterialDef& def);
void checkMaterialPair(const MaterialPairDef& def);

/// What holds between two materials, whatever the sizes: the pair rule with everything filled in.
struct MaterialPair {
  double restitution = 1.0;
  double restitutionSpeed = 1.0;  ///< m/s
  double friction = 0.0;
  double damping = 0.0;  ///< D of restitution.h that gives the restitution
  std::optional<double> shearViscosity = std::nullopt;
};
MaterialPair combineMaterials(const MaterialDef& a, const MaterialDef& b, const MaterialPairDef& def);

/// All that the force between two particles of given kinds needs.
struct PairLaw {
  HertzViscoelastic normal;
  RegularisedCoulomb shear;
  double stiffnessPerMass = 0.0;  ///< kr / m_eff, for the contact time

  /// What hertzContactTime would be for the impact that this contact is the middle of, as its (-5/2)th power
  /// scaled: (kr/m)^4 v0^2, where v0 is the impact speed with the present energy. Cheap, and a maximum of it
  /// is a minimum of contact times; contactTimeOfMeasure turns it back.
  double urgency(double xi, double xiDot) const {
    const double v0Squared = xiDot * xiDot + 0.8 * stiffnessPerMass * xi * xi * std::sqrt(xi);
    const double k2 = stiffnessPerMass * stiffnessPerMass;
    return k2 * k2 * v0Squared;
  }
};

/// Contact time, s, of an urgency > 0.
inline double contactTimeOfUrgency(double urgency) {
  return hertzContactTime(1.0, 1.0, std::sqrt(urgency));
}

PairLaw makePairLaw(const MaterialPair& pair, const ContactSide& a, const ContactSide& b);

}  // namespace granular
