// SPDX-License-Identifier: MIT
// The constants of the contact laws for one kind of pair, worked out from the two materials and the pair
// rule.
#pragma once

#include <string_view>

#include "granular/contact/law_constants.h"
#include "granular/contact/material.h"

namespace granular {

/// Throw std::invalid_argument naming the field, its value and what is allowed.
void checkMaterial(const MaterialDef& def);
void checkMaterialPair(const MaterialPairDef& def);

/// What holds between two materials, whatever the sizes: the pair rule with everything filled in.
struct MaterialPair {
  double restitution = 1.0;
  double friction = 0.0;
  double modulus = 0.0;  ///< E_eff, Pa (eq. 14)
  double shearModulusRatio =
      0.0;                   ///< tangential over normal stiffness of a pressed contact, after Mindlin 1949
  double damping = 0.0;      ///< dimensionless, of the normal law between grains
  double bodyDamping = 0.0;  ///< the same between bodies
  MaterialPairDef def;

  const NormalLawDef& normalOf(bool ofBodies) const { return ofBodies ? def.bodyNormal : def.normal; }
  double dampingOf(bool ofBodies) const { return ofBodies ? bodyDamping : damping; }
};

/// What the constants of a normal law are worked out from, but for the sizes and masses of the two.
template <class Real>
NormalRequestOf<Real> requestOf(const MaterialPair& pair, bool ofBodies) {
  NormalRequestOf<Real> request;
  request.contact.modulus = pair.modulus;
  request.damping = pair.dampingOf(ofBodies);
  request.speed = pair.def.restitutionSpeed;
  request.def = pair.normalOf(ofBodies);
  return request;
}

MaterialPair combineMaterials(const MaterialDef& a, const MaterialDef& b, const MaterialPairDef& def);

/// One side of a pair: a round particle or an exact surface of a grain or a body.
struct PairSide {
  ContactSide contact;
  bool isBody = false;
  double bodyLength = 0.0;  ///< of a body, m: how deep its elastic layer is; 0: as deep as the other's
  double bodyArea = 0.0;    ///< of a body, m^2: what it can touch with at once; 0: no matter
};

/// All that the force between two sides needs.
struct PairLaw {
  NormalConstants normal;
  ShearConstants shear;
  NormalLaw normalLaw = NormalLaw::HertzViscoelastic;
  ShearLaw shearLaw = ShearLaw::RegularisedCoulomb;

  bool sameKernel(const PairLaw& other) const {
    return normalLaw == other.normalLaw && shearLaw == other.shearLaw;
  }
};

PairLaw makePairLaw(const MaterialPair& pair, const PairSide& a, const PairSide& b);

}  // namespace granular
