// SPDX-License-Identifier: MIT
#include <algorithm>

#include "demos/scene_readers.h"

namespace granular_demo {
namespace {

constexpr Range kRestitution = {.low = 0.0, .high = 1.0, .openLow = true};

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

void readNormalLaw(JsonObject object, granular::MaterialPairDef& law) {
  object.choice("law", {"hertz-viscoelastic"});
  law.restitution = object.optionalNumber("restitution", kRestitution);
  law.restitutionSpeed = object.number("atSpeed", Range::positive(), law.restitutionSpeed);
  object.finish();
}

void readShearLaw(JsonObject object, granular::MaterialPairDef& law) {
  object.choice("law", {"regularised-coulomb"});
  law.friction = object.optionalNumber("friction", Range::notNegative());
  law.shearViscosity = object.optionalNumber("viscosity", Range::notNegative());
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
  if (object.has("shear")) readShearLaw(object.object("shear"), pair.law);
  object.finish();
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
