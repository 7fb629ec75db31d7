// SPDX-License-Identifier: MIT
// The constants of the shear laws (Bell 2005, eqs. 16-19), from the pair rule and the constants of the normal
// law; for one contact or several at a time.
#pragma once

#include <numbers>

#include "granular/contact/law_constants.h"
#include "granular/contact/pair_law.h"

namespace granular {

/// Of the holding spring of eq. 17 when nothing is given: it must not swing on.
inline constexpr double kHoldingDamping = 0.5;

/// Of the dashpot beside the spring of eqs. 17 and 19.
inline double dashpotRatio(const ShearLawDef& def) {
  return def.dampingRatio.value_or(def.law == ShearLaw::Coulomb ? kHoldingDamping : 0.0);
}

/// mass: m_eff, kg. area: what a law by area is multiplied with when all of a body touches, m^2; 1 for laws
/// between particles. Given constants and masses are those of the whole contact.
template <class Normal, class Real>
ShearConstantsOf<Real> shearConstants(const MaterialPair& pair, const NormalConstantsOf<Real>& normal,
                                      const Real& mass, double area) {
  const ShearLawDef& def = pair.def.shear;
  const double v = pair.def.restitutionSpeed;
  // The normal spring at half the deepest overlap of an impact at the reference speed.
  const Real stiffness = area * Normal::tangentStiffness(normal, Real(0.25 * v / normal.impactRate));
  // 2/7: tangential effective mass of solid spheres over m_eff. The default viscosity brings a sliding
  // contact to rest within one contact time, so that it asks for no shorter a sub-step than the normal law
  // does.
  const Real tangentialMass = 2.0 / 7.0 * mass;
  const Real kt = def.stiffness ? Real(*def.stiffness) : Real(pair.shearModulusRatio * stiffness);
  const double ratio = dashpotRatio(def);
  const Real viscosity =
      def.viscosity ? Real(*def.viscosity) : Real(tangentialMass * (std::numbers::pi * normal.impactRate));
  return {.mu = pair.friction,
          .viscosity = viscosity / area,
          .stiffness = def.stiffness.value_or(0.0) / area,
          .stiffnessRatio = pair.shearModulusRatio,
          .slipCompliance = area / sqrt(kt * tangentialMass),
          .dashpot = ratio > 0.0 ? Real(2.0 * ratio * sqrt(kt * tangentialMass) / area) : Real(0.0)};
}

/// Of the constants of a shear law between particles the one that depends on their sizes and masses.
template <class Shear, class Real>
Real ownShearConstant(const ShearConstantsOf<Real>& shear) {
  return Shear::kHasMemory ? shear.slipCompliance : shear.viscosity;
}
/// All of them again, as shearConstants() gave them for an area of 1.
template <class Shear, class Real>
ShearConstantsOf<Real> shearConstantsFrom(const MaterialPair& pair, const Real& own) {
  const double ratio = dashpotRatio(pair.def.shear);
  ShearConstantsOf<Real> shear{.mu = pair.friction,
                               .stiffness = pair.def.shear.stiffness.value_or(0.0),
                               .stiffnessRatio = pair.shearModulusRatio};
  if constexpr (Shear::kHasMemory) {
    shear.slipCompliance = own;
    shear.dashpot = ratio > 0.0 ? Real(2.0 * ratio / own) : Real(0.0);
  } else {
    shear.viscosity = own;
  }
  return shear;
}

}  // namespace granular
