// SPDX-License-Identifier: MIT
#include "granular/contact/pair_law.h"

#include <cmath>
#include <numbers>

#include "granular/base/require.h"
#include "granular/contact/restitution.h"

namespace granular {
namespace {

// Below this a contact loses all but a ten-thousandth of its energy and the damping constant grows without
// bound.
constexpr double kSmallestRestitution = 0.01;

void checkRestitution(double e, std::string_view field) {
  require(std::isfinite(e) && e >= kSmallestRestitution && e <= 1.0, field, e, "", "in [0.01, 1]");
}

}  // namespace

void checkMaterial(const MaterialDef& def) {
  requirePositive(def.density, "MaterialDef.density", "kg/m^3");
  requirePositive(def.youngsModulus, "MaterialDef.youngsModulus", "Pa");
  require(def.poissonRatio > -1.0 && def.poissonRatio <= 0.5, "MaterialDef.poissonRatio", def.poissonRatio,
          "", "in (-1, 0.5]");
  checkRestitution(def.restitution, "MaterialDef.restitution");
  requireNotNegative(def.friction, "MaterialDef.friction", "");
}

void checkMaterialPair(const MaterialPairDef& def) {
  if (def.restitution) checkRestitution(*def.restitution, "MaterialPairDef.restitution");
  requirePositive(def.restitutionSpeed, "MaterialPairDef.restitutionSpeed", "m/s");
  if (def.friction) requireNotNegative(*def.friction, "MaterialPairDef.friction", "");
  if (def.shearViscosity) requireNotNegative(*def.shearViscosity, "MaterialPairDef.shearViscosity", "N s/m");
}

MaterialPair combineMaterials(const MaterialDef& a, const MaterialDef& b, const MaterialPairDef& def) {
  MaterialPair pair;
  pair.restitution = def.restitution.value_or(std::sqrt(a.restitution * b.restitution));
  pair.restitutionSpeed = def.restitutionSpeed;
  pair.friction = def.friction.value_or(std::sqrt(a.friction * b.friction));
  pair.damping = dampingForRestitution(0.5, 1.5, pair.restitution);
  pair.shearViscosity = def.shearViscosity;
  return pair;
}

PairLaw makePairLaw(const MaterialPair& pair, const ContactSide& a, const ContactSide& b) {
  const EffectiveContact contact = effectiveContact(a, b);
  const double kr = contact.hertzStiffness();
  const double m = contact.mass;
  const double v = pair.restitutionSpeed;
  // Default viscosity of eq. 18: a sliding contact of two round particles is brought to rest within one
  // contact time (2/7 is the tangential effective mass of solid spheres over m_eff), so that it asks for no
  // shorter a sub-step than the normal law does.
  const double kt =
      pair.shearViscosity.value_or(2.0 / 7.0 * std::numbers::pi * m / hertzContactTime(kr, m, v));
  return {.normal = {.kr = kr, .kd = hertzDampingConstant(0.5, pair.damping, kr, m, v)},
          .shear = {.mu = pair.friction, .kt = kt},
          .stiffnessPerMass = kr / m};
}

}  // namespace granular
