// SPDX-License-Identifier: MIT
// Finds the particles of contacts in a list of all particles.
#pragma once

#include <map>
#include <span>
#include <utility>

#include "granular/system/granular_system.h"

namespace granular::detail {

/// Where each owner's particles begin in a list made by GranularSystem::readParticles.
class FirstParticles {
 public:
  explicit FirstParticles(std::span<const ParticleView> particles) {
    for (std::size_t i = 0; i < particles.size(); ++i)
      first_.try_emplace({particles[i].ownerKind, particles[i].ownerIndex}, static_cast<std::int64_t>(i));
  }

  /// Place in the list of one side's particle; -1: its exact surface.
  std::int64_t of(const ContactView& contact, int side) const {
    if (contact.particle[side] < 0) return -1;
    const auto found = first_.find({contact.ownerKind[side], contact.ownerIndex[side]});
    return found == first_.end() ? -1 : found->second + contact.particle[side];
  }

 private:
  std::map<std::pair<OwnerKind, std::int32_t>, std::int64_t> first_;
};

}  // namespace granular::detail
