// SPDX-License-Identifier: MIT
#include <algorithm>
#include <stdexcept>

#include "demos/scene/scene_readers.h"
#include "granular/contact/pair_law.h"

namespace granular_demo {
namespace {

constexpr Range kRestitution = {.low = 0.01, .high = 1.0};

granular::MaterialDef readMaterial(const std::string& name, const JsonPlace& place) {
  JsonObject object(place);
  granular::MaterialDef def;
  def.name = name;
  def.density = object.number("density", Range::positive(), def.density);
  def.youngsModulus = object.number("youngsModulus", Range::positive(), def.youngsModulus);
  def.poissonRatio =
      object.number("poissonRatio", {.low = -1.0, .high = 0.5, .openLow = true}, def.poissonRatio);
  def.restitution = object.number("restitution", kRestitution, def.restitution);
  def.friction = object.number("friction", Range::notNegative(), def.friction);
  object.finish();
  return def;
}

void readNormalConstants(JsonObject& object, const std::vector<std::string>& names,
                         granular::NormalLawDef& law) {
  law.law = static_cast<granular::NormalLaw>(object.choice("law", names, static_cast<std::size_t>(law.law)));
  law.stiffness = object.optionalNumber("stiffness", Range::positive());
  law.damping = object.optionalNumber("damping", Range::notNegative());
  law.attraction = object.boolean("attraction", law.attraction);
}

// In the order of granular::NormalLaw; the last one is for bodies only.
const std::vector<std::string> kBodyLaws = {"hertz-viscoelastic", "hertz-tsuji", "hertz-constant-damping",
                                            "linear-spring", "elastic-foundation"};
const std::vector<std::string> kParticleLaws(kBodyLaws.begin(), kBodyLaws.end() - 1);

void readNormalLaw(JsonObject object, granular::MaterialPairDef& pair) {
  pair.restitution = object.optionalNumber("restitution", kRestitution);
  pair.restitutionSpeed = object.number("atSpeed", Range::positive(), pair.restitutionSpeed);
  pair.normal.contactTime = object.optionalNumber("contactTime", Range::positive());
  readNormalConstants(object, kParticleLaws, pair.normal);
  object.finish();
}

void readBodyNormalLaw(JsonObject object, granular::MaterialPairDef& pair) {
  readNormalConstants(object, kBodyLaws, pair.bodyNormal);
  object.finish();
}

void readShearLaw(JsonObject object, granular::MaterialPairDef& pair) {
  static const std::vector<std::string> kNames = {"regularised-coulomb", "static-friction", "coulomb",
                                                  "viscous"};
  pair.shear.law = static_cast<granular::ShearLaw>(object.choice("law", kNames, 0));
  pair.friction = object.optionalNumber("friction", Range::notNegative());
  pair.shear.viscosity = object.optionalNumber("viscosity", Range::notNegative());
  pair.shear.stiffness = object.optionalNumber("stiffness", Range::positive());
  pair.shear.dampingRatio = object.optionalNumber("dampingRatio", {.low = 0.0, .high = 1.0});
  object.finish();
}

PairDef readPair(const JsonPlace& place, const std::vector<std::string>& materialNames) {
  JsonObject object(place);
  PairDef pair;
  const JsonPlace between = object.at("between");
  const std::vector<JsonPlace> elements = between.elements();
  if (elements.size() != 2) between.fail("two names of materials");
  for (int i = 0; i < 2; ++i) {
    pair.materials[i] = elements[i].string();
    if (std::find(materialNames.begin(), materialNames.end(), pair.materials[i]) == materialNames.end()) {
      elements[i].fail("one of " + joined(materialNames));
    }
  }
  if (object.has("normal")) readNormalLaw(object.object("normal"), pair.law);
  if (object.has("bodyNormal")) readBodyNormalLaw(object.object("bodyNormal"), pair.law);
  if (object.has("shear")) readShearLaw(object.object("shear"), pair.law);
  object.finish();
  try {
    granular::checkMaterialPair(pair.law);  // laws and constants that contradict each other
  } catch (const std::invalid_argument& error) {
    place.fail(std::string("laws that agree with each other (") + error.what() + ")");
  }
  return pair;
}

}  // namespace

std::vector<granular::MaterialDef> readMaterials(const JsonPlace& place) {
  std::vector<granular::MaterialDef> all;
  for (const auto& [name, member] : JsonObject(place).members()) all.push_back(readMaterial(name, member));
  if (all.empty()) place.fail("at least one material");
  return all;
}

std::vector<PairDef> readPairs(const JsonPlace& place, const std::vector<std::string>& materialNames) {
  std::vector<PairDef> all;
  for (const JsonPlace& element : place.elements()) all.push_back(readPair(element, materialNames));
  return all;
}

}  // namespace granular_demo
