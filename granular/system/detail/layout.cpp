// SPDX-License-Identifier: MIT
#include "granular/system/detail/layout.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>

namespace granular::detail {

void Layout::finish(const std::vector<std::uint64_t>& excludedPairs) {
  particleCount = dynamicParticles = movingParticles = patchCount = 0;
  ownerOfPatch.clear();
  rules = {};
  bool everythingMeets = true;
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(owners.size()); ++o) {
    Owner& owner = owners[o];
    const auto count = static_cast<std::int32_t>(owner.particles.size());
    owner.firstRank = particleCount;
    particleCount += count;
    if (o < dynamicCount()) dynamicParticles += count;
    if (o < movingCount()) {
      movingParticles += count;
      owner.firstPatch = patchCount;
      owner.patchCount =
          owner.kind == OwnerKind::Grain ? 1 : (count + kParticlesPerPatch - 1) / kParticlesPerPatch;
      patchCount += owner.patchCount;
      ownerOfPatch.insert(ownerOfPatch.end(), owner.patchCount, o);
    }
    everythingMeets &=
        owner.filter.group == ContactFilter{}.group && owner.filter.mask == ContactFilter{}.mask;
  }
  if (!everythingMeets) {
    for (const Owner& owner : owners) {
      rules.group.push_back(owner.filter.group);
      rules.mask.push_back(owner.filter.mask);
    }
  }
  rules.excludedPairs = excludedPairs;
  std::sort(rules.excludedPairs.begin(), rules.excludedPairs.end());
  findKinds();
  std::vector<std::int32_t> order(dynamicCount());
  std::iota(order.begin(), order.end(), 0);
  assignSlots(std::move(order));
}

void Layout::findKinds() {
  kinds.clear();
  kindOfRank.clear();
  kindOfRank.reserve(particleCount);
  std::map<std::tuple<double, double, std::int32_t>, std::int32_t> known;
  smallestRadius = largestRadius = 0.0;
  for (const Owner& owner : owners) {
    for (const ShapeParticle& particle : owner.particles) {
      const double radius = particle.radius * owner.scale;
      smallestRadius = smallestRadius == 0.0 ? radius : std::min(smallestRadius, radius);
      largestRadius = std::max(largestRadius, radius);
      const auto [found, isNew] = known.try_emplace({radius, owner.inverseMass, owner.material},
                                                    static_cast<std::int32_t>(kinds.size()));
      if (isNew) kinds.push_back({radius, owner.inverseMass, owner.material});
      kindOfRank.push_back(found->second);
    }
  }
}

void Layout::assignSlots(std::vector<std::int32_t> order) {
  slotOrder = std::move(order);
  for (auto* bySlot : {&ownerOfSlot, &rankOfSlot, &patchOfSlot, &kindOfSlot, &slotOfRank}) {
    bySlot->resize(particleCount);
  }
  std::int32_t slot = 0;
  const auto lay = [&](std::int32_t o) {
    Owner& owner = owners[o];
    owner.firstSlot = slot;
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(owner.particles.size()); ++k, ++slot) {
      const std::int32_t rank = owner.firstRank + k;
      ownerOfSlot[slot] = o;
      rankOfSlot[slot] = rank;
      slotOfRank[rank] = slot;
      kindOfSlot[slot] = kindOfRank[rank];
      patchOfSlot[slot] = owner.patchCount == 0   ? -1
                          : owner.patchCount == 1 ? owner.firstPatch
                                                  : owner.firstPatch + k / kParticlesPerPatch;
    }
  };
  for (const std::int32_t o : slotOrder) lay(o);
  for (std::int32_t o = dynamicCount(); o < static_cast<std::int32_t>(owners.size()); ++o) lay(o);
}

}  // namespace granular::detail
