// SPDX-License-Identifier: MIT
// Memory of contacts (Bell 2005, eq. 19): which contacts remember, from sub-step to sub-step, from list to
// list and from layout to layout.
#include <algorithm>
#include <numeric>

#include "granular/contact/law_list.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/stage_tools.h"

namespace granular::detail {

RememberedContact Evaluation::endsOf(std::int32_t rank1, std::int32_t rank2) const {
  RememberedContact contact;
  const std::int32_t ranks[2] = {rank1, rank2};
  for (int side = 0; side < 2; ++side) {
    const std::int32_t slot = layout_.slotOfRank[ranks[side]];
    const Owner& owner = layout_.owners[layout_.ownerOfSlot[slot]];
    contact.kind[side] = owner.kind;
    contact.index[side] = owner.index;
    contact.local[side] = slot < layout_.particleCount ? ranks[side] - owner.firstRank : -1;
  }
  return contact;
}

RememberedContact Evaluation::remembered(std::int32_t m, const std::vector<double>& y) const {
  RememberedContact contact = endsOf(memory_[m].rank1, memory_[m].rank2);
  contact.displacement = Eigen::Map<const Vector3>(y.data() + stateSize() + 3 * m);
  contact.stiffness = memory_[m].stiffness;
  contact.slides = memory_[m].slides != 0.0;
  return contact;
}

std::vector<RememberedContact> Evaluation::exportMemory(const std::vector<double>& y) const {
  std::vector<RememberedContact> memory;
  for (std::int32_t m = 0; m < static_cast<std::int32_t>(memory_.size()); ++m) {
    memory.push_back(remembered(m, y));
  }
  // Entries lie as slots do, which depends on the past.
  std::vector<std::size_t> order(memory.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(memory_[a].rank1, memory_[a].rank2) < std::pair(memory_[b].rank1, memory_[b].rank2);
  });
  std::vector<RememberedContact> sorted;
  for (const std::size_t m : order) sorted.push_back(memory[m]);
  return sorted;
}

bool Evaluation::describe(const Contact& contact, const std::vector<double>& y,
                          RememberedContact& description) const {
  const std::int32_t entry = hasMemory_ ? entryOf(contact) : -1;
  description = entry >= 0 ? remembered(entry, y)
                           : endsOf(layout_.rankOfSlot[contact.slot1], layout_.rankOfSlot[contact.slot2]);
  return entry >= 0;
}

void Evaluation::importMemory(const std::vector<RememberedContact>& memory, std::vector<double>& y) {
  if (!hasMemory_ || memory.empty()) return;
  std::vector<std::int32_t> ownerNow[2];  // of grains, of bodies, by index
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(layout_.owners.size()); ++o) {
    const auto index = static_cast<std::size_t>(layout_.owners[o].index);
    std::vector<std::int32_t>& ownerOf = ownerNow[static_cast<int>(layout_.owners[o].kind)];
    if (ownerOf.size() <= index) ownerOf.resize(index + 1, -1);
    ownerOf[index] = o;
  }
  const auto rankNow = [&](OwnerKind kind, std::int32_t index, std::int32_t local) -> std::int32_t {
    const std::vector<std::int32_t>& ownerOf = ownerNow[static_cast<int>(kind)];
    if (index < 0 || index >= std::ssize(ownerOf) || ownerOf[index] < 0) return -1;
    const std::int32_t o = ownerOf[index];
    const Owner& owner = layout_.owners[o];
    if (local >= 0)
      return local < static_cast<std::int32_t>(owner.particles.size()) ? owner.firstRank + local : -1;
    const auto surface = std::find(layout_.ownerOfSurface.begin(), layout_.ownerOfSurface.end(), o);
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
    known.push_back({{.stiffness = contact.stiffness,
                      .slides = contact.slides ? 1.0 : 0.0,
                      .energy = granular::memoryEnergy<double>(contact.stiffness, contact.displacement),
                      .rank1 = std::min(rank1, rank2),
                      .rank2 = std::max(rank1, rank2)},
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

bool Evaluation::remembers(const Contact& contact) const {
  if (isUniform_) return hasMemory_;
  return withShearLaw(ruleOf(contact).pair->def.shear.law, []<class Law>(Law) { return Law::kHasMemory; });
}

/// body(n) for every contact n in the block's own rows that remembers something.
template <class Body>
void Evaluation::forRemembered(std::int32_t block, Body&& body) const {
  const std::int32_t first = firstKept(block), end = first + foundInBlock_[block];
  for (std::int32_t n = first; n < end; ++n) {
    if (contactMemory_[n].touches == 0.0 || !isOwn(block, contacts_[n])) continue;
    if (isUniform_ || remembers(contacts_[n])) body(n);
  }
}

void Evaluation::settleMemory(std::vector<double>& y, std::vector<double>& rate) {
  if (!hasMemory_) return;
  const std::int32_t blocks = blockCount();
  entriesInBlock_.assign(blocks + 1, 0);
  executor_.forPieces(blocks, [&](std::int32_t block) {
    std::int32_t count = 0;
    if (isUniform_) {
      count = extremesInBlock_[block].contacts;
    } else {
      forRemembered(block, [&](std::int32_t) { ++count; });
    }
    entriesInBlock_[block + 1] = count;
  });
  for (std::int32_t block = 0; block < blocks; ++block) entriesInBlock_[block + 1] += entriesInBlock_[block];
  const std::int32_t entries = entriesInBlock_[blocks];
  memoryBefore_.swap(memory_);
  memory_.resize(entries);
  memoryOfCandidateBefore_.swap(memoryOfCandidate_);
  memoryOfCandidate_.resize(list_.size());
  livesOn_.assign(memoryBefore_.size(), 0);
  sumOfRank_.assign(layout_.dynamicParticles, {});
  const std::size_t lacking = lackingOf(rate, y);
  y.resize(stateSize() + 3 * entries);
  rate.resize(y.size() - lacking);
  executor_.forPieces(blocks, [&](std::int32_t block) { settleBlock(block, y, rate); });
  for (std::size_t m = 0; m < memoryBefore_.size(); ++m) {
    if (!livesOn_[m]) sumOfRank_[memoryBefore_[m].rank1].heat += memoryBefore_[m].energy;
  }
  Settled sum;
  for (const Settled& settled : sumOfRank_) {
    sum.heat += settled.heat;
    sum.heating += settled.heating;
  }
  y[heatAt()] += sum.heat;
  rate[heatAt() - lacking] += sum.heating;
}

/// The memory of a block's own contacts, into its places of memory_, y and rate.
void Evaluation::settleBlock(std::int32_t block, std::vector<double>& y, std::vector<double>& rate) {
  std::fill(memoryOfCandidate_.begin() + list_.rowStart()[firstSlotOfBlock_[block]],
            memoryOfCandidate_.begin() + list_.rowStart()[firstSlotOfBlock_[block + 1]], -1);
  const std::size_t lacking = lackingOf(rate, y);
  const auto put = [](const Vector3& v, double* to) { std::copy_n(v.data(), 3, to); };
  std::int32_t m = entriesInBlock_[block];
  forRemembered(block, [&](std::int32_t n) {
    const Contact& contact = contacts_[n];
    const std::int32_t candidate = blocks_.index()[contact.candidate];
    if (const std::int32_t before = memoryOfCandidateBefore_[candidate]; before >= 0) livesOn_[before] = 1;
    memoryOfCandidate_[candidate] = m;
    const SettledMemory& memory = contactMemory_[n];
    const std::int32_t rank = layout_.rankOfSlot[contact.slot1];
    sumOfRank_[rank].heat += memory.loss;
    sumOfRank_[rank].heating += memory.heating;
    memory_[m] = {.stiffness = memory.stiffness,
                  .slides = memory.slides,
                  .energy = granular::memoryEnergy<double>(memory.stiffness, memory.displacement),
                  .rank1 = rank,
                  .rank2 = layout_.rankOfSlot[contact.slot2]};
    put(memory.displacement, y.data() + stateSize() + 3 * m);
    if (memoryHasRates_) put(nextRates_[n].vector, rate.data() + (stateSize() - lacking) + 3 * m);
    ++m;
  });
}

double Evaluation::memoryEnergy() {
  double energy = 0.0;
  if (memory_.empty()) return energy;
  sumOfRank_.assign(layout_.dynamicParticles, {});  // entries of one lie in order
  for (const MemoryEntry& entry : memory_) sumOfRank_[entry.rank1].heat += entry.energy;
  for (const Settled& sum : sumOfRank_) energy += sum.heat;
  return energy;
}

}  // namespace granular::detail
