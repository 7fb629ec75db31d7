// SPDX-License-Identifier: MIT
// Which candidates overlap, and what the forces of contacts add up to; included once by the file for each
// processor.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/pack_rows.h"

namespace granular::detail {
namespace {

std::int32_t findContacts(const ContactArrays& arrays, std::int32_t row, std::int32_t end, std::int32_t& n) {
  const Four plusOrMinus = {1.0, 1.0, 1.0, -1.0};
  const ParticleRow* particles = arrays.particles;
  const OwnerRow* owners = arrays.owners;  // the forces will want them
  const std::int32_t *rowStart = arrays.rowStart, *partner = arrays.partner,
                     *placeOfSlot = arrays.placeOfSlot;
  Contact* contacts = arrays.contacts;
  std::int32_t* contactOfCandidate = arrays.contactOfCandidate;
  const std::int32_t particleCount = arrays.particleCount;
  const bool slotsArePlaces = arrays.movesOnlySpheres;  // but of what stands still
  std::int32_t next = n;
  bool hasSurfaces = false;
  for (; row < end && !hasSurfaces; ++row) {
    const std::int32_t first = next, begin = rowStart[row];
    std::int32_t stop = rowStart[row + 1];
    while (stop > begin && partner[stop - 1] >= particleCount) --stop;  // surfaces come last in a row
    hasSurfaces = stop < rowStart[row + 1];
    // (x1, y1, z1, -R1), so that one difference gives the way between centres and the sum of radii.
    const Four a = plusOrMinus * loadFour(&particles[row].x);
    for (std::int32_t c = begin; c < stop; ++c) {
      const std::int32_t other = partner[c];
      const Four d = loadFour(&particles[other].x) - a;
      const Four q = d * d;
      // No branch: half of the candidates touch, and no processor guesses which.
      const std::int32_t touches = q[0] + q[1] + q[2] < q[3];
      contacts[next] = {row, other, c};  // overwritten unless it counts
      __builtin_prefetch(owners + (slotsArePlaces ? other : placeOfSlot[other]));
      contactOfCandidate[c] = next | (touches - 1);
      next += touches;
    }
    arrays.contactsOfRow[row] = {first, next};
  }
  n = next;
  return row;
}

/// arm x F and nothing in the fourth place, all finite.
Four crossOf(const Four& a, const Four& b) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3) * __builtin_shufflevector(b, b, 2, 0, 1, 3) -
         __builtin_shufflevector(a, a, 2, 0, 1, 3) * __builtin_shufflevector(b, b, 1, 2, 0, 3);
}

/// What the wrench of a moving owner is about; the fourth number is finite.
Four centerOf(const ContactArrays& arrays, std::int32_t slot, std::int32_t place) {
  return loadFour(arrays.movesOnlySpheres ? &arrays.particles[slot].x : &arrays.balls[place].x);
}

/// What a patch bears. Fours: force and heat; torque.
struct WrenchSum {
  Four center, force = {}, torque = {};

  void add(const ContactForce& contact) {
    const Four f = loadFour(contact.force.data());
    force += f;
    torque += torqueOf(contact, f);
  }
  void subtract(const ContactForce& contact) {
    const Four f = loadFour(contact.force.data());
    force -= f;
    torque -= torqueOf(contact, f);
  }
  Four torqueOf(const ContactForce& contact, const Four& f) const {
    return crossOf(loadFour(contact.point.data()) - center, f);
  }
  void store(PatchWrench& to) const {
    storeFour(force, to.force.data());
    storeFour(torque, to.torque.data());
  }
};

/// Contacts among the candidates of some entries, side by side, so that reading all of their forces can begin
/// before the first is added.
struct TouchingEntries {
  static constexpr std::int32_t kMost = 256;
  static constexpr std::int32_t kEntriesAhead = 24;
  std::array<std::int32_t, kMost + 1> contacts, before;  // before an entry, so many touch

  /// Entries [first, last), kMost at most.
  void collect(const ContactArrays& arrays, std::int32_t first, std::int32_t last) {
    const std::int32_t* contactOfCandidate = arrays.contactOfCandidate;
    const std::int32_t* entries = arrays.incidenceEntries;
    std::int32_t count = 0;
    for (std::int32_t k = first; k < last; ++k) {
      const std::int32_t n = contactOfCandidate[entries[k]];
      __builtin_prefetch(contactOfCandidate + entries[std::min(k + kEntriesAhead, last - 1)]);
      before[k - first] = count;
      contacts[count] = n;
      count += n >= 0;
      __builtin_prefetch(arrays.forces + std::max(n, 0));
    }
    before[last - first] = count;
  }
};

GRANULAR_KERNEL void sumWrenches(const ContactArrays& arrays, std::int32_t begin, std::int32_t end,
                                 PatchWrench* to) {
  TouchingEntries touching;
  for (std::int32_t patch = begin; patch < end;) {
    const std::int32_t first = arrays.incidenceStart[patch];
    std::int32_t last =
        patch + 1;  // of the patches whose entries are collected at once; the first may have more
    while (last < end && arrays.incidenceStart[last + 1] - first <= TouchingEntries::kMost) ++last;
    touching.collect(arrays, first, std::min(arrays.incidenceStart[last], first + TouchingEntries::kMost));
    const auto endOfRows = [&](std::int32_t p) {
      return std::min(arrays.slotOfPatch[p], arrays.dynamicParticles);
    };
    for (; patch < last; ++patch) {
      WrenchSum sum{.center = centerOf(arrays, arrays.slotOfPatch[patch], arrays.placeOfPatch[patch])};
      for (std::int32_t slot = arrays.slotOfPatch[patch]; slot < endOfRows(patch + 1); ++slot) {
        const ContactRange own = arrays.contactsOfRow[slot];
        for (std::int32_t n = own.first; n < own.last; ++n) sum.add(arrays.forces[n]);
      }
      const double dissipation = sum.force[3];
      const auto subtract = [&](std::int32_t k, std::int32_t lastTouching) {
        for (; k < lastTouching; ++k) sum.subtract(arrays.forces[touching.contacts[k]]);
      };
      const std::int32_t from = arrays.incidenceStart[patch], until = arrays.incidenceStart[patch + 1];
      std::int32_t done = std::min(until, first + TouchingEntries::kMost);
      subtract(touching.before[from - first], touching.before[done - first]);
      for (; done < until; done += TouchingEntries::kMost) {  // of a patch with too many
        const std::int32_t count = std::min(until - done, TouchingEntries::kMost);
        touching.collect(arrays, done, done + count);
        subtract(0, touching.before[count]);
      }
      sum.force[3] = dissipation;
      sum.store(to[patch - begin]);
    }
  }
}

}  // namespace
}  // namespace granular::detail
