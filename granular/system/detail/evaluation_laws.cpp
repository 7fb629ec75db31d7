// SPDX-License-Identifier: MIT
// Which laws hold between which kinds of particles, with which constants.
#include <algorithm>
#include <limits>

#include "granular/contact/law_list.h"
#include "granular/system/detail/evaluation.h"

namespace granular::detail {

PairLaw Evaluation::makeLaw(const ParticleKind& a, const ParticleKind& b) const {
  return makePairLaw(materialPairs_[a.material * materials_.size() + b.material],
                     sideOf(a, materials_[a.material]), sideOf(b, materials_[b.material]));
}

void Evaluation::makePairLaws() {
  const auto kinds = static_cast<std::int32_t>(layout_.kinds.size());
  pairLaws_.assign(layout_.kinds.size() * layout_.kinds.size(), PairLaw{});
  for (std::int32_t a = 0; a < kinds; ++a) {
    for (std::int32_t b = 0; b < kinds; ++b) {
      // Two planes, or two held things: they never meet, and nothing could be said of them.
      const ParticleKind &kindA = layout_.kinds[a], &kindB = layout_.kinds[b];
      if (kindA.inverseMass + kindB.inverseMass > 0.0 && kindA.inverseRadius + kindB.inverseRadius > 0.0) {
        pairLaws_[a * kinds + b] = makeLaw(kindA, kindB);
      }
    }
  }
}

namespace {

bool hasMemory(ShearLaw law) {
  return withShearLaw(law, []<class Law>(Law) { return Law::kHasMemory; });
}

}  // namespace

/// Whether anything that is there remembers, whose damping of sliding was not worked out from contact times,
/// and whether it is all grains of one material: scenes without memory, and plain ones, do not pay for what
/// others need.
void Evaluation::noteLaws() {
  std::vector<bool> isThere(materials_.size(), false);
  for (const Owner& owner : layout_.owners) isThere[owner.material] = true;
  isUniform_ = layout_.dynamicBodies == 0 && std::count(isThere.begin(), isThere.end(), true) == 1;
  hasMemory_ = isDampingGiven_ = false;
  for (std::size_t a = 0; a < materials_.size(); ++a) {
    for (std::size_t b = 0; b < materials_.size(); ++b) {
      if (!isThere[a] || !isThere[b]) continue;
      const ShearLawDef& shear = materialPairs_[a * materials_.size() + b].def.shear;
      hasMemory_ |= hasMemory(shear.law);
      isDampingGiven_ |=
          hasMemory(shear.law) ? shear.dampingRatio.value_or(0.0) > 0.0 : shear.viscosity.value_or(0.0) > 0.0;
    }
  }
}

PairLaw Evaluation::pairLaw(const Contact& contact) const {
  if (layout_.kinds.empty()) return makeLaw(layout_.kindOf(contact.slot1), layout_.kindOf(contact.slot2));
  const std::int32_t kind1 = layout_.kindOfRank[layout_.rankOfSlot[contact.slot1]];
  const std::int32_t kind2 = layout_.kindOfRank[layout_.rankOfSlot[contact.slot2]];
  return pairLaws_[kind1 * layout_.kinds.size() + kind2];
}

Evaluation::PairRule Evaluation::ruleBetween(std::int32_t material1, std::int32_t material2,
                                             bool ofBodies) const {
  return {&materialPairs_[material1 * materials_.size() + material2], ofBodies};
}

Evaluation::PairRule Evaluation::ruleOf(const Contact& contact) const {
  const std::int32_t first = layout_.owners.front().material;
  if (isUniform_) return ruleBetween(first, first, false);
  const OwnerRow& owner1 = owners_[layout_.placeOfSlot[contact.slot1]];
  const OwnerRow& owner2 = owners_[layout_.placeOfSlot[contact.slot2]];
  const bool ofBodies = owner1.isBody != 0 && owner2.isBody != 0;
  return ruleBetween(owner1.material, owner2.material, ofBodies);
}

/// What the user gave to damp the sliding of this contact, N s/m; 0 where it was not given.
double Evaluation::givenDamping(const Contact& contact) const {
  const PairRule rule = ruleOf(contact);
  const ShearLawDef& shear = rule.pair->def.shear;
  if (rule.ofBodies) return 0.0;
  if (!hasMemory(shear.law)) return shear.viscosity.value_or(0.0);
  return shear.dampingRatio ? pairLaw(contact).shear.dashpot : 0.0;
}

double Evaluation::shearRate(const std::vector<double>& y) {
  if (!isDampingGiven_) return 0.0;
  listContacts(y);
  dampingOfOwner_.assign(layout_.owners.size(), 0.0);
  forEachContact([&](const Contact& contact, const ContactForce& f) {
    const double damping = givenDamping(contact);
    if (damping == 0.0) return;
    for (const std::int32_t slot : {contact.slot1, contact.slot2}) {
      const std::int32_t o = layout_.ownerOfSlot[slot];
      if (o >= layout_.dynamicCount()) continue;
      const Owner& owner = layout_.owners[o];
      const double arm = (pointOf(contact, f) - center(o)).squaredNorm();
      dampingOfOwner_[o] += damping * (owner.inverseMass + arm * owner.inverseInertia.maxCoeff());
    }
  });
  double largest = 0.0;
  forEachContact([&](const Contact& contact, const ContactForce&) {
    largest = std::max(largest, dampingOfOwner_[layout_.ownerOfSlot[contact.slot1]] +
                                    dampingOfOwner_[layout_.ownerOfSlot[contact.slot2]]);
  });
  return largest;
}

double Evaluation::referenceContactTime() const {
  double shortest = std::numeric_limits<double>::infinity();
  const auto consider = [&](const ParticleKind& kind) {
    if (!(kind.inverseMass > 0.0 && kind.inverseRadius > 0.0)) return;
    const PairLaw law = makeLaw(kind, kind);
    shortest = std::min(shortest, withNormalLaw(law.normalLaw, [&]<class Normal>(Normal) {
                          return contactTimeOfUrgency(Normal::urgency(law.normal, 0.0, 1.0));
                        }));
  };
  for (const ParticleKind& kind : layout_.kinds) consider(kind);
  if (layout_.kinds.empty()) {
    layout_.forEachKind([&](const ParticleKind& kind, std::int32_t, bool) { consider(kind); });
  }
  return shortest;
}

}  // namespace granular::detail
