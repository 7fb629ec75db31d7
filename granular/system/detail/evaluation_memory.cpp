// SPDX-License-Identifier: MIT
// Memory of contacts (Bell 2005, eq. 19): which contacts remember, from sub-step to sub-step, from list to
// list and from layout to layout.
#include <algorithm>
#include <map>

#include "granular/contact/law_list.h"
#include "granular/system/detail/evaluation.h"

namespace granular::detail {

std::vector<RememberedContact> Evaluation::exportMemory(const std::vector<double>& y) const {
  std::vector<RememberedContact> memory;
  for (std::size_t m = 0; m < memory_.size(); ++m) {
    RememberedContact contact;
    const std::int32_t ranks[2] = {memory_[m].rank1, memory_[m].rank2};
    for (int side = 0; side < 2; ++side) {
      const std::int32_t slot = layout_.slotOfRank[ranks[side]];
      const Owner& owner = layout_.owners[layout_.ownerOfSlot[slot]];
      contact.kind[side] = owner.kind;
      contact.index[side] = owner.index;
      contact.local[side] = slot < layout_.particleCount ? ranks[side] - owner.firstRank : -1;
    }
    contact.displacement = Eigen::Map<const Vector3>(y.data() + stateSize() + 3 * m);
    contact.stiffness = memory_[m].stiffness;
    contact.slides = memory_[m].slides;
    memory.push_back(contact);
  }
  return memory;
}

void Evaluation::importMemory(const std::vector<RememberedContact>& memory, std::vector<double>& y) {
  if (!hasMemory_ || memory.empty()) return;
  std::map<std::pair<OwnerKind, std::int32_t>, std::int32_t> ownerNow;
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(layout_.owners.size()); ++o) {
    ownerNow[{layout_.owners[o].kind, layout_.owners[o].index}] = o;
  }
  const auto rankNow = [&](OwnerKind kind, std::int32_t index, std::int32_t local) -> std::int32_t {
    const auto found = ownerNow.find({kind, index});
    if (found == ownerNow.end()) return -1;
    const Owner& owner = layout_.owners[found->second];
    if (local >= 0)
      return local < static_cast<std::int32_t>(owner.particles.size()) ? owner.firstRank + local : -1;
    const auto surface =
        std::find(layout_.ownerOfSurface.begin(), layout_.ownerOfSurface.end(), found->second);
    if (surface == layout_.ownerOfSurface.end()) return -1;
    return layout_.particleCount + static_cast<std::int32_t>(surface - layout_.ownerOfSurface.begin());
  };
  std::vector<std::pair<MemoryEntry, Vector3>> known;
  for (const RememberedContact& contact : memory) {
    const std::int32_t rank1 = rankNow(contact.kind[0], contact.index[0], contact.local[0]);
    const std::int32_t rank2 = rankNow(contact.kind[1], contact.index[1], contact.local[1]);
    // Seen from the other side where the two have changed places in the order: D turns with the point of
    // view.
    if (rank1 < 0 || rank2 < 0) continue;
    const bool swapped = rank2 < rank1;
    known.push_back({{std::min(rank1, rank2), std::max(rank1, rank2), contact.stiffness,
                      granular::memoryEnergy<double>(contact.stiffness, contact.displacement), contact.slides},
                     swapped ? Vector3(-contact.displacement) : contact.displacement});
  }
  std::sort(known.begin(), known.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.rank1, a.first.rank2) < std::pair(b.first.rank1, b.first.rank2);
  });
  for (const auto& [entry, displacement] : known) {
    memory_.push_back(entry);
    y.insert(y.end(), displacement.data(), displacement.data() + 3);
  }
}

void Evaluation::settleMemory(std::vector<double>& y, std::vector<double>& rate) {
  if (!hasMemory_) return;
  double heat = 0.0, heating = 0.0;
  std::vector<MemoryEntry> kept;
  std::vector<double> displacements, displacementRates;
  std::vector<bool> lives(memory_.size(), false);
  for (std::int32_t rank = 0; rank < layout_.dynamicParticles; ++rank) {
    const std::int32_t slot = layout_.slotOfRank[rank];
    for (std::int32_t c = list_.rowStart()[slot]; c < list_.rowStart()[slot + 1]; ++c) {
      const std::int32_t n = contactOfCandidate_[c];
      if (!touches(n)) {
        memoryOfCandidate_[c] = -1;
        continue;
      }
      const ShearLaw shear = ruleOf(contacts_[n]).pair->def.shear.law;
      if (!withShearLaw(shear, []<class Law>(Law) { return Law::kHasMemory; })) continue;
      const ContactMemory& memory = contactMemory_[n];
      const std::int32_t before = memoryOfCandidate_[c];
      if (before >= 0) lives[before] = true;
      heat += memory.loss;
      heating += memory.heating;
      memoryOfCandidate_[c] = static_cast<std::int32_t>(kept.size());
      kept.push_back({rank, layout_.rankOfSlot[contacts_[n].slot2], memory.stiffness,
                      granular::memoryEnergy<double>(memory.stiffness, memory.displacement), memory.slides});
      for (int k = 0; k < 3; ++k) {
        displacements.push_back(memory.displacement[k]);
        displacementRates.push_back(memory.nextRate[k]);
      }
    }
  }
  for (std::size_t m = 0; m < memory_.size(); ++m) {
    if (!lives[m]) heat += memory_[m].energy;
  }
  memory_ = std::move(kept);
  y.resize(stateSize());
  y.insert(y.end(), displacements.begin(), displacements.end());
  y[heatAt()] += heat;
  rate.resize(stateSize());
  rate[heatAt()] += heating;
  rate.insert(rate.end(), displacementRates.begin(), displacementRates.end());
}

double Evaluation::memoryEnergy() const {
  double energy = 0.0;
  for (const MemoryEntry& entry : memory_) energy += entry.energy;
  return energy;
}

}  // namespace granular::detail
