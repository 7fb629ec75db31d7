// SPDX-License-Identifier: MIT
// Atom types of LAMMPS: as few as the laws allow, and the coefficients between them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "granular/contact/law_list.h"
#include "granular/io/detail/lammps_model.h"

namespace granular::detail {
namespace {

constexpr double kSame = 1e-9;  // relative: coefficients that differ by rounding only

}  // namespace

int LammpsFamily::typeOf(const LammpsSize& size) const {
  const auto place = std::lower_bound(sizes.begin(), sizes.end(), size) - sizes.begin();
  return firstType + static_cast<int>(place * typeCount / static_cast<std::ptrdiff_t>(sizes.size()));
}

std::pair<std::size_t, std::size_t> LammpsFamily::sizesOf(int type) const {
  const auto begin = [&](int own) {  // least i with i * typeCount / count >= own
    return (static_cast<std::size_t>(own) * sizes.size() + typeCount - 1) / typeCount;
  };
  return {begin(type - firstType), begin(type - firstType + 1)};
}

const LammpsSize& LammpsFamily::middle(int type) const {
  const auto [first, end] = sizesOf(type);
  return sizes[(first + end - 1) / 2];
}

const LammpsFamily& LammpsModel::familyOf(int type) const {
  return *std::find_if(families.begin(), families.end(), [&](const LammpsFamily& family) {
    return type < family.firstType + family.typeCount;
  });
}

LammpsModel::Side LammpsModel::middleOf(int type) const {
  const LammpsFamily& family = familyOf(type);
  return {family.material, family.role, family.middle(type)};
}

std::optional<LammpsContact> LammpsModel::contact(int typeA, int typeB) const {
  return contact(middleOf(typeA), middleOf(typeB));
}

std::optional<LammpsContact> LammpsModel::wallContact(const LammpsWall& wall, int type) const {
  return contact(middleOf(type), sideOf(wall));
}

void LammpsModel::combineMaterialPairs() {
  std::vector<MaterialId> used;
  for (const LammpsFamily& family : families) used.push_back(family.material);
  for (const LammpsWall& wall : walls) used.push_back(wall.material);
  for (const MaterialId a : used) {
    for (const MaterialId b : used) {
      const auto key = std::minmax(a.index, b.index);
      if (materialPairs_.contains(key)) continue;
      materialPairs_[key] =
          combineMaterials(system_.material(a), system_.material(b), system_.materialPair(a, b));
    }
  }
}

const MaterialPair& LammpsModel::materialPair(const Side& a, const Side& b) const {
  return materialPairs_.at(std::minmax(a.material.index, b.material.index));
}

PairSide LammpsModel::pairSide(const Side& side) const {
  const MaterialDef& material = system_.material(side.material);
  const double r = side.size.radius, m = side.size.mass;
  return {.contact = {m > 0.0 ? 1.0 / m : 0.0, r > 0.0 ? 1.0 / r : 0.0, material.youngsModulus,
                      material.poissonRatio},
          .isBody = side.role != LammpsRole::Grain};
}

PairLaw LammpsModel::pairLaw(const Side& a, const Side& b) const {
  return makePairLaw(materialPair(a, b), pairSide(a), pairSide(b));
}

bool LammpsModel::isByArea(const Side& a, const Side& b) const {
  return a.role != LammpsRole::Grain && b.role != LammpsRole::Grain &&
         withNormalLaw(materialPair(a, b).def.bodyNormal.law, []<class Law>(Law) { return Law::kByArea; });
}

std::optional<LammpsContact> LammpsModel::contact(const Side& a, const Side& b) const {
  if (a.size.mass == 0.0 && b.size.mass == 0.0) return std::nullopt;
  if (isByArea(a, b)) return std::nullopt;
  return lammpsContact(pairLaw(a, b), effectiveContact(pairSide(a).contact, pairSide(b).contact),
                       materialPair(a, b).def.restitutionSpeed);
}

bool LammpsModel::dependsOnSize(const LammpsFamily& family) const {
  const Side first{family.material, family.role, family.sizes.front()};
  const Side last{family.material, family.role, family.sizes.back()};
  const auto differ = [&](const Side& a, const Side& b, const Side& otherA, const Side& otherB) {
    const auto one = contact(a, b), other = contact(otherA, otherB);
    return one && other && difference(*one, *other) > kSame;
  };
  bool depends = differ(first, first, last, last) || differ(first, first, first, last);
  for (const LammpsFamily& partner : families) {
    const Side side{partner.material, partner.role, partner.sizes.front()};
    depends = depends || differ(first, side, last, side);
  }
  for (const LammpsWall& wall : walls) depends = depends || differ(first, sideOf(wall), last, sideOf(wall));
  return depends;
}

void LammpsModel::makeTypes(int largestTypeCount) {
  for (LammpsFamily& family : families) {
    std::sort(family.sizes.begin(), family.sizes.end());
    family.sizes.erase(std::unique(family.sizes.begin(), family.sizes.end()), family.sizes.end());
  }
  std::vector<LammpsFamily*> varied;
  std::size_t wanted = 0;
  for (LammpsFamily& family : families) {
    if (!dependsOnSize(family)) continue;
    varied.push_back(&family);
    wanted += family.sizes.size();
  }
  const auto plain = static_cast<int>(families.size() - varied.size());
  const auto count = std::max(1, static_cast<int>(varied.size()));
  const int share = std::max(1, (largestTypeCount - plain) / count);
  const bool allFit = wanted + plain <= static_cast<std::size_t>(largestTypeCount);
  for (LammpsFamily* family : varied) {
    const auto sizes = static_cast<int>(std::min<std::size_t>(family->sizes.size(), 1u << 30));
    family->typeCount = allFit ? sizes : std::min(share, sizes);
  }
  int next = 1;
  for (LammpsFamily& family : families) {
    family.firstType = next;
    next += family.typeCount;
  }
}

/// Shortest contact time, largest error of shared coefficients, and what there is to be said of the laws.
void LammpsModel::measureContacts() {
  shortestContactTime = std::numeric_limits<double>::infinity();
  if (families.empty()) return;
  const auto smallestOf = [](const LammpsFamily& family) {
    return Side{family.material, family.role, family.sizes.front()};
  };
  for (const LammpsFamily& family : families) {
    for (const LammpsFamily& other : families) measureContact(smallestOf(family), smallestOf(other));
    for (const LammpsWall& wall : walls) measureContact(smallestOf(family), sideOf(wall));
  }
  for (int a = 1; a <= typeCount(); ++a) {
    const LammpsFamily& family = familyOf(a);
    const auto [first, end] = family.sizesOf(a);
    for (int b = 1; b <= typeCount(); ++b) {
      const auto shared = contact(a, b);
      for (const std::size_t extreme : {first, end - 1}) {
        // Against itself both are extreme: that is farthest off.
        const Side own{family.material, family.role, family.sizes[extreme]};
        const auto exact = contact(own, a == b ? own : middleOf(b));
        if (shared && exact) coefficientError = std::max(coefficientError, difference(*shared, *exact));
      }
    }
  }
  if (coefficientError > kSame) {
    std::ostringstream text;
    text.precision(2);
    text << "sizes share atom types: coefficients of single pairs are off by up to "
         << 100.0 * coefficientError << " %";
    note(text.str());
  }
}

void LammpsModel::measureContact(const Side& a, const Side& b) {
  if (const auto found = contact(a, b)) {
    noteContact(*found);
    const PairLaw law = pairLaw(a, b);
    const double urgency = withNormalLaw(law.normalLaw, [&]<class Law>(Law) {
      return Law::urgency(law.normal, 0.0, materialPair(a, b).def.restitutionSpeed);
    });
    shortestContactTime = std::min(shortestContactTime, contactTimeOfUrgency(urgency));
  } else if (a.size.mass + b.size.mass > 0.0) {
    note(
        "bodies do not meet one another: LAMMPS has no law by area (ElasticFoundation); give bodyNormal "
        "another");
  }
}

void LammpsModel::noteContact(const LammpsContact& contact) {
  if (contact.mu > 0.0) {
    note("tangential velocities are taken at R from the centres, where the contact point is at R - xi/2");
  }
  if (contact.viscosityIsMatched) {
    note(
        "tangential viscosity follows the normal damping, and is ours at half the deepest overlap of an "
        "impact "
        "at restitutionSpeed");
  }
  if (contact.hasHistory) {
    note(
        "friction springs begin at rest: what contacts remember is left out, and so is their turning about "
        "the "
        "normal");
  }
  if (contact.isCoulomb) note("Coulomb friction (eq. 17) is written as static friction (eq. 19)");
}

}  // namespace granular::detail
