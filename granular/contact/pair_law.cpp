// SPDX-License-Identifier: MIT
#include "granular/contact/pair_law.h"

#include <algorithm>
#include <cmath>

#include "granular/base/require.h"
#include "granular/contact/law_list.h"
#include "granular/contact/shear_constants.h"

namespace granular {
namespace {

// Below this a contact loses all but a ten-thousandth of its energy and the damping constant grows without
// bound.
constexpr double kSmallestRestitution = 0.01;

void checkRestitution(double e, std::string_view field) {
  require(std::isfinite(e) && e >= kSmallestRestitution && e <= 1.0, field, e, "", "in [0.01, 1]");
}

void checkNormal(const NormalLawDef& def, const std::string& field) {
  if (def.contactTime) requirePositive(*def.contactTime, field + ".contactTime", "s");
  if (def.stiffness) requirePositive(*def.stiffness, field + ".stiffness", "N/m^beta");
  if (def.damping) requireNotNegative(*def.damping, field + ".damping", "N s/m^(1 + alpha)");
  require(!def.contactTime || def.law == NormalLaw::LinearSpring, field + ".contactTime",
          def.contactTime.value_or(0.0), "s", "left out unless the law is LinearSpring");
  require(!(def.contactTime && def.stiffness), field + ".stiffness", def.stiffness.value_or(0.0), "N/m",
          "left out where contactTime is given: the one decides the other");
}

void checkShear(const ShearLawDef& def) {
  if (def.viscosity) requireNotNegative(*def.viscosity, "MaterialPairDef.shear.viscosity", "N s/m");
  if (def.stiffness) requirePositive(*def.stiffness, "MaterialPairDef.shear.stiffness", "N/m");
  if (def.dampingRatio) {
    require(*def.dampingRatio >= 0.0 && *def.dampingRatio <= 1.0, "MaterialPairDef.shear.dampingRatio",
            *def.dampingRatio, "", "in [0, 1]");
  }
  const bool isSpring = def.law == ShearLaw::StaticFriction || def.law == ShearLaw::Coulomb;
  require(isSpring || !def.stiffness, "MaterialPairDef.shear.stiffness", def.stiffness.value_or(0.0), "N/m",
          "left out unless the law is StaticFriction or Coulomb");
  require(!isSpring || !def.viscosity, "MaterialPairDef.shear.viscosity", def.viscosity.value_or(0.0),
          "N s/m", "left out unless the law is RegularisedCoulomb or Viscous");
}

/// kt/kn of two elastic bodies pressed together: 4 G*/E*, 1/G* = sum (2 - nu)/G (Mindlin 1949).
double mindlinRatio(const MaterialDef& a, const MaterialDef& b) {
  const auto shearCompliance = [](const MaterialDef& m) {
    return (2.0 - m.poissonRatio) * 2.0 * (1.0 + m.poissonRatio) / m.youngsModulus;
  };
  const auto compliance = [](const MaterialDef& m) {
    return (1.0 - m.poissonRatio * m.poissonRatio) / m.youngsModulus;
  };
  return 4.0 * (compliance(a) + compliance(b)) / (shearCompliance(a) + shearCompliance(b));
}

double dampingOf(const NormalLawDef& def, double restitution) {
  if (def.damping) return 0.0;  // given as a constant
  return withNormalLaw(
      def.law, [&]<class Law>(Law) { return Law::dampingForRestitution(restitution, def.attraction); });
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
  checkNormal(def.normal, "MaterialPairDef.normal");
  checkNormal(def.bodyNormal, "MaterialPairDef.bodyNormal");
  checkShear(def.shear);
  require(def.normal.law != NormalLaw::ElasticFoundation, "MaterialPairDef.normal.law", "ElasticFoundation",
          "", "a law between particles: the foundation is for bodies (bodyNormal)");
}

MaterialPair combineMaterials(const MaterialDef& a, const MaterialDef& b, const MaterialPairDef& def) {
  MaterialPair pair;
  pair.restitution = def.restitution.value_or(std::sqrt(a.restitution * b.restitution));
  pair.friction = def.friction.value_or(std::sqrt(a.friction * b.friction));
  pair.modulus = effectiveModulus(a.youngsModulus, a.poissonRatio, b.youngsModulus, b.poissonRatio);
  pair.shearModulusRatio = mindlinRatio(a, b);
  pair.damping = dampingOf(def.normal, pair.restitution);
  pair.bodyDamping = dampingOf(def.bodyNormal, pair.restitution);
  pair.def = def;
  return pair;
}

PairLaw makePairLaw(const MaterialPair& pair, const PairSide& a, const PairSide& b) {
  const bool ofBodies = a.isBody && b.isBody;
  // A plane has no size of its own: its layer is as deep as the other's, and it touches with all of it.
  const auto other = [](double own, double others) { return own > 0.0 ? own : others; };
  NormalRequest request = requestOf<double>(pair, ofBodies);
  request.contact = effectiveContact(a.contact, b.contact);
  request.bodyLength = 0.5 * (other(a.bodyLength, b.bodyLength) + other(b.bodyLength, a.bodyLength));
  request.bodyArea = std::min(other(a.bodyArea, b.bodyArea), other(b.bodyArea, a.bodyArea));

  PairLaw law;
  law.normalLaw = request.def.law;
  law.shearLaw = pair.def.shear.law;
  withNormalLaw(law.normalLaw, [&]<class Law>(Law) {
    law.normal = Law::constants(request);
    law.shear =
        shearConstants<Law>(pair, law.normal, request.contact.mass, Law::kByArea ? request.bodyArea : 1.0);
  });
  return law;
}

}  // namespace granular
