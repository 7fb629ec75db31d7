// SPDX-License-Identifier: MIT
// The kernels themselves, included once by the file for each processor, with that processor's packs. All of
// it is local to that file: a function that two of them shared could be taken from the wrong one.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>

#include "granular/base/pack.h"
#include "granular/contact/shear_constants.h"
#include "granular/system/detail/contact_kernels.h"

namespace granular::detail {
namespace {

// Rows are read as the rest of the library lays them out, whatever this processor would like.
static_assert(alignof(Quaternion) == 16 && alignof(Vector3) == 8);

/// Four numbers that lie side by side: a row, or half of one.
using Four = double __attribute__((vector_size(32)));

Four loadFour(const double* from) {
  Four four;
  std::memcpy(&four, from, sizeof(four));
  return four;
}
void storeFour(const Four& four, double* to) {
  std::memcpy(to, &four, sizeof(four));
}

/// Four packs; named one by one, as arrays would be kept in memory.
template <class P>
struct FourPacks {
  P first, second, third, fourth;
};

/// Rows of four numbers, one a lane, into packs of first, second, third and fourth ones. of(lane): where.
template <class P = Pack, class Function>
FourPacks<P> packsOf(Function&& of) {
  if constexpr (sizeof(P) == sizeof(Four)) {
    const Four a = loadFour(of(0)), b = loadFour(of(1)), c = loadFour(of(2)), d = loadFour(of(3));
    const Four ab02 = __builtin_shufflevector(a, b, 0, 4, 2, 6),
               ab13 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Four cd02 = __builtin_shufflevector(c, d, 0, 4, 2, 6),
               cd13 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    return {P(__builtin_shufflevector(ab02, cd02, 0, 1, 4, 5)),
            P(__builtin_shufflevector(ab13, cd13, 0, 1, 4, 5)),
            P(__builtin_shufflevector(ab02, cd02, 2, 3, 6, 7)),
            P(__builtin_shufflevector(ab13, cd13, 2, 3, 6, 7))};
  } else {
    return {packOf([&](int lane) { return of(lane)[0]; }), packOf([&](int lane) { return of(lane)[1]; }),
            packOf([&](int lane) { return of(lane)[2]; }), packOf([&](int lane) { return of(lane)[3]; })};
  }
}
/// The way back, into the rows of the first `count` lanes.
template <class P, class Function>
void storeRows(const FourPacks<P>& packs, int count, Function&& of) {
  if constexpr (sizeof(P) == sizeof(Four)) {
    const auto a = static_cast<Four>(packs.first), b = static_cast<Four>(packs.second),
               c = static_cast<Four>(packs.third), d = static_cast<Four>(packs.fourth);
    const Four ab02 = __builtin_shufflevector(a, b, 0, 4, 2, 6),
               ab13 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Four cd02 = __builtin_shufflevector(c, d, 0, 4, 2, 6),
               cd13 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    storeFour(__builtin_shufflevector(ab02, cd02, 0, 1, 4, 5), of(0));
    if (count > 1) storeFour(__builtin_shufflevector(ab13, cd13, 0, 1, 4, 5), of(1));
    if (count > 2) storeFour(__builtin_shufflevector(ab02, cd02, 2, 3, 6, 7), of(2));
    if (count > 3) storeFour(__builtin_shufflevector(ab13, cd13, 2, 3, 6, 7), of(3));
  } else {
    for (int lane = 0; lane < count; ++lane) {
      double* to = of(lane);
      to[0] = packs.first[lane], to[1] = packs.second[lane];
      to[2] = packs.third[lane], to[3] = packs.fourth[lane];
    }
  }
}

/// The particles of some contacts.
struct PackParticles {
  Vector3Of<Pack> center;
  Pack radius;
};
template <class Function>
PackParticles particlesOf(Function&& rowOf) {
  static_assert(offsetof(ParticleRow, radius) == 3 * sizeof(double));
  const FourPacks<Pack> row = packsOf([&](int lane) { return &rowOf(lane).x; });
  return {{row.first, row.second, row.third}, row.fourth};
}

/// Their owners.
struct PackMotion {
  Vector3Of<Pack> center, velocity, angularVelocity;
  Pack inverseMass;

  Vector3Of<Pack> at(const Vector3Of<Pack>& point) const {
    return velocity + angularVelocity.cross(point - center);
  }
};
template <class Function>
PackMotion motionsOf(Function&& rowOf) {
  const FourPacks<Pack> place = packsOf([&](int lane) { return rowOf(lane).center.data(); });
  const FourPacks<Pack> motion = packsOf([&](int lane) { return rowOf(lane).velocity.data(); });
  const FourPacks<Pack> spin = packsOf([&](int lane) { return rowOf(lane).angularVelocity.data(); });
  return {{place.first, place.second, place.third},
          {motion.first, motion.second, motion.third},
          {spin.first, spin.second, spin.third},
          place.fourth};
}

/// Where they meet; xi is 0 where they do not touch after all. Returns the distance of their centres.
Pack placeContacts(const PackParticles& a, const PackParticles& b, ContactGeometryOf<Pack>& g) {
  const Vector3Of<Pack> apart = b.center - a.center;
  const Pack distance = sqrt(apart.squaredNorm());
  const auto isClear = distance > 0.0;  // else any direction does, as long as it is always the same
  const Pack inverse = 1.0 / distance;
  g.xi = max(Pack(0.0), a.radius + b.radius - distance);  // eq. 1
  g.N = {select(isClear, apart.x() * inverse, 0.0), select(isClear, apart.y() * inverse, 1.0),
         select(isClear, apart.z() * inverse, 0.0)};  // eq. 2
  g.point = a.center + (a.radius - 0.5 * g.xi) * g.N;
  return distance;
}

/// How the frames of contacts turn: with the line of centres, and about it as the two owners do on average.
Vector3Of<Pack> turningOf(const PackParticles& a, const PackParticles& b, const PackMotion& motion1,
                          const PackMotion& motion2, const Vector3Of<Pack>& N, const Pack& distance) {
  const Pack twist = 0.5 * Pack((motion1.angularVelocity + motion2.angularVelocity).dot(N));
  const Pack inverse = select(distance > 0.0, Pack(1.0 / distance), 0.0);
  const Vector3Of<Pack> swing = inverse * N.cross(motion2.at(b.center) - motion1.at(a.center));
  return swing + (twist - swing.dot(N)) * N;
}

using Entries = std::array<std::int32_t, kPackSize>;  // of Evaluation's memory; -1: none

/// What contacts remember, as packs; fills in what the geometry wants to know of it.
template <class Normal>
Vector3Of<Pack> displacementsOf(const ContactArrays& arrays, const Entries& entry,
                                const ShearConstantsOf<Pack>& shear, ContactGeometryOf<Pack>& g) {
  static constexpr std::array<double, 3> kNothing = {};
  const auto remembered = [&](int axis) {
    return packOf([&](int lane) {
      return (entry[lane] < 0 ? kNothing.data() : arrays.displacements + 3 * entry[lane])[axis];
    });
  };
  for (int lane = 0; lane < kPackSize; ++lane) {
    g.isNew[lane] = entry[lane] < 0;
    g.slides[lane] = entry[lane] >= 0 && arrays.memory[entry[lane]].slides;
  }
  g.stiffnessBefore =
      packOf([&](int lane) { return entry[lane] < 0 ? 0.0 : arrays.memory[entry[lane]].stiffness; });
  g.memoryStep = select(g.isNew, Pack(0.0), arrays.at.memoryStep);
  // Begun within this trial: it has slid since its overlap was zero.
  const Pack xiDot = g.V.dot(g.N);
  const Pack since = min(Pack(g.xi / xiDot), Pack(arrays.at.sinceTrial));
  const Pack slid = select(g.isNew && xiDot > 0.0, Pack(since / (1.0 + stiffnessPower<Normal>(shear))), 0.0);
  return Vector3Of<Pack>{remembered(0), remembered(1), remembered(2)} + slid * (g.V - xiDot * g.N);
}

/// What `count` contacts remember once the sub-step is accepted, 0 where they do not touch after all; and at
/// what rate what they remember so far changes.
template <class Function>
void storeMemory(const ContactArrays& arrays, const Entries& entry, const ContactMemoryOf<Pack>& memory,
                 const MaskOf<Pack>& touches, int count, Function&& of) {
  const auto ifTouching = [&](const Pack& value) { return select(touches, value, 0.0); };
  const Vector3Of<Pack>&D = memory.displacement, &next = memory.nextRate;
  storeRows<Pack>({ifTouching(D.x()), ifTouching(D.y()), ifTouching(D.z()), ifTouching(memory.stiffness)},
                  count, [&](int lane) { return of(lane).displacement.data(); });
  storeRows<Pack>({ifTouching(next.x()), ifTouching(next.y()), ifTouching(next.z()), ifTouching(memory.loss)},
                  count, [&](int lane) { return of(lane).nextRate.data(); });
  const Pack heating = ifTouching(memory.heating);
  for (int lane = 0; lane < count; ++lane) {
    of(lane).heating = heating[lane];
    of(lane).slides = touches[lane] && memory.slides[lane];
    of(lane).touches = touches[lane];
    if (entry[lane] < 0 || !touches[lane]) continue;
    double* rate = arrays.displacementRates + 3 * entry[lane];
    rate[0] = memory.rate.x()[lane], rate[1] = memory.rate.y()[lane], rate[2] = memory.rate.z()[lane];
  }
}

/// Of the contacts so far, in every lane.
struct PackExtremes {
  Pack urgency = 0.0, overlap = 0.0;
};

/// At most kPackSize contacts; lanes to spare do the last one again. request: all but sizes and masses.
template <class Normal, class Shear>
[[gnu::flatten]] void forcesOfPack(const ContactArrays& arrays, const MaterialPair& pair,
                                   NormalRequestOf<Pack>& request, const std::int32_t* which,
                                   std::int32_t count, PackExtremes& packed, Extremes& extremes) {
  const auto contactOf = [&](int lane) -> const Contact& {
    return arrays.contacts[which[std::min(lane, count - 1)]];
  };
  const auto ownerOf = [&](std::int32_t slot) -> const OwnerRow& {
    return arrays.owners[arrays.placeOfSlot[slot]];
  };
  Entries entry{};
  if constexpr (Shear::kHasMemory) {
    for (int lane = 0; lane < kPackSize; ++lane) {
      entry[lane] = arrays.memoryOfCandidate[contactOf(lane).candidate];
    }
  }
  const PackParticles a =
      particlesOf([&](int lane) -> auto& { return arrays.particles[contactOf(lane).slot1]; });
  const PackParticles b =
      particlesOf([&](int lane) -> auto& { return arrays.particles[contactOf(lane).slot2]; });
  const PackMotion motion1 = motionsOf([&](int lane) -> auto& { return ownerOf(contactOf(lane).slot1); });
  const PackMotion motion2 = motionsOf([&](int lane) -> auto& { return ownerOf(contactOf(lane).slot2); });
  ContactGeometryOf<Pack> g;
  const Pack distance = placeContacts(a, b, g);
  g.V = motion1.at(g.point) - motion2.at(g.point);  // eq. 3

  const Pack inverseMass = motion1.inverseMass + motion2.inverseMass;
  request.contact.mass = select(inverseMass > 0.0, Pack(1.0 / inverseMass), 1.0);
  request.contact.radius = a.radius * b.radius / (a.radius + b.radius);
  const NormalConstantsOf<Pack> normal = Normal::template constants<Pack>(request);
  const ShearConstantsOf<Pack> shear = shearConstants<Normal, Pack>(pair, normal, request.contact.mass, 1.0);

  const auto touches = g.xi > 0.0;  // the test of findContacts and the exact overlap disagree by rounding
  ContactResultOf<Pack> result;
  if constexpr (Shear::kHasMemory) {
    ContactMemoryOf<Pack> memory;
    g.turning = turningOf(a, b, motion1, motion2, g.N, distance);
    const Vector3Of<Pack> D = displacementsOf<Normal>(arrays, entry, shear, g);
    result = resultWithMemory<Normal, Shear, Pack>(normal, shear, g, D, memory);
    storeMemory(arrays, entry, memory, touches, count,
                [&](int lane) -> SettledMemory& { return arrays.contactMemory[which[lane]]; });
  } else {
    result = resultWithoutMemory<Normal, Shear, Pack>(normal, shear, g.xi, g.N, g.V);
  }
  const auto ifTouching = [&](const Pack& value) { return select(touches, value, 0.0); };
  const auto forceOf = [&](int lane) { return arrays.forces[which[lane]].force.data(); };
  const auto pointOf = [&](int lane) { return arrays.forces[which[lane]].point.data(); };
  storeRows<Pack>({ifTouching(result.force.x()), ifTouching(result.force.y()), ifTouching(result.force.z()),
                   ifTouching(result.dissipation)},
                  count, forceOf);
  storeRows<Pack>({g.point.x(), g.point.y(), g.point.z(), g.xi}, count, pointOf);

  packed.urgency = max(packed.urgency, ifTouching(Normal::urgency(normal, g.xi, Pack(g.V.dot(g.N)))));
  packed.overlap = max(packed.overlap, g.xi / min(a.radius, b.radius));
  auto counts = touches;
  for (int lane = count; lane < kPackSize; ++lane) counts[lane] = false;
  extremes.contacts += popcount(counts);
  extremes.pushing += popcount(counts && result.normalForce != 0.0);
}

// So many contacts ahead the rows of the second side are asked for; those of the first lie in order.
constexpr std::int32_t kContactsAhead = 12;

void prefetchOther(const ContactArrays& arrays, std::int32_t slot) {
  const char* owner = reinterpret_cast<const char*>(arrays.owners + arrays.placeOfSlot[slot]);
  __builtin_prefetch(arrays.particles + slot);
  __builtin_prefetch(owner);
  __builtin_prefetch(owner + sizeof(OwnerRow) - 1);
}

template <class Normal, class Shear>
void forcesOf(const ContactArrays& arrays, const MaterialPair& pair, bool ofBodies, const std::int32_t* which,
              std::int32_t count, Extremes& extremes) {
  NormalRequestOf<Pack> request = requestOf<Pack>(pair, ofBodies);
  PackExtremes packed;
  for (std::int32_t n = 0; n < count; n += kPackSize) {
    for (std::int32_t ahead = n + kContactsAhead; ahead < std::min(count, n + kContactsAhead + kPackSize);
         ++ahead) {
      prefetchOther(arrays, arrays.contacts[which[ahead]].slot2);
    }
    forcesOfPack<Normal, Shear>(arrays, pair, request, which + n, std::min(kPackSize, count - n), packed,
                                extremes);
  }
  extremes.urgency = std::max<double>(extremes.urgency, hmax(packed.urgency));
  extremes.overlap = std::max<double>(extremes.overlap, hmax(packed.overlap));
}

std::int32_t findContacts(const ContactArrays& arrays, std::int32_t row, std::int32_t end, std::int32_t& n) {
  const Four plusOrMinus = {1.0, 1.0, 1.0, -1.0};
  const ParticleRow* particles = arrays.particles;
  const std::int32_t *rowStart = arrays.rowStart, *partner = arrays.partner;
  Contact* contacts = arrays.contacts;
  std::int32_t* contactOfCandidate = arrays.contactOfCandidate;
  const std::int32_t particleCount = arrays.particleCount;
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

/// What a row or patch bears. Fours: force and heat; torque.
struct WrenchSum {
  Four center, force = {}, torque = {};

  Four torqueOf(const ContactForce& contact, const Four& f) const {
    return crossOf(loadFour(contact.point.data()) - center, f);
  }
  void store(PatchWrench& to) const {
    storeFour(force, to.force.data());
    storeFour(torque, to.torque.data());
  }
};

[[gnu::flatten]] void sumRows(const ContactArrays& arrays, std::int32_t begin, std::int32_t end) {
  for (std::int32_t row = begin; row < end; ++row) {
    WrenchSum sum{.center = loadFour(arrays.owners[arrays.placeOfSlot[row]].center.data())};
    const ContactRange own = arrays.contactsOfRow[row];
    for (std::int32_t n = own.first; n < own.last; ++n) {
      const Four f = loadFour(arrays.forces[n].force.data());
      sum.force += f;
      sum.torque += sum.torqueOf(arrays.forces[n], f);
    }
    sum.store(arrays.rowWrenches[row]);
  }
}

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

[[gnu::flatten]] void sumWrenches(const ContactArrays& arrays, std::int32_t begin, std::int32_t end) {
  TouchingEntries touching;
  for (std::int32_t patch = begin; patch < end;) {
    const std::int32_t first = arrays.incidenceStart[patch];
    std::int32_t last =
        patch + 1;  // of the patches whose entries are collected at once; the first may have more
    while (last < end && arrays.incidenceStart[last + 1] - first <= TouchingEntries::kMost) ++last;
    touching.collect(arrays, first, std::min(arrays.incidenceStart[last], first + TouchingEntries::kMost));
    for (; patch < last; ++patch) {
      WrenchSum sum{.center = loadFour(arrays.owners[arrays.placeOfPatch[patch]].center.data())};
      const std::int32_t lastSlot = std::min(arrays.slotOfPatch[patch + 1], arrays.dynamicParticles);
      for (std::int32_t slot = arrays.slotOfPatch[patch]; slot < lastSlot; ++slot) {
        sum.force += loadFour(arrays.rowWrenches[slot].force.data());
        sum.torque += loadFour(arrays.rowWrenches[slot].torque.data());
      }
      const double dissipation = sum.force[3];
      const auto subtract = [&](std::int32_t k, std::int32_t lastTouching) {
        for (; k < lastTouching; ++k) {
          const ContactForce& contact = arrays.forces[touching.contacts[k]];
          const Four f = loadFour(contact.force.data());
          sum.force -= f;
          sum.torque -= sum.torqueOf(contact, f);
        }
      };
      const std::int32_t from = arrays.incidenceStart[patch], to = arrays.incidenceStart[patch + 1];
      std::int32_t done = std::min(to, first + TouchingEntries::kMost);
      subtract(touching.before[from - first], touching.before[done - first]);
      for (; done < to; done += TouchingEntries::kMost) {  // of a patch with too many
        const std::int32_t count = std::min(to - done, TouchingEntries::kMost);
        touching.collect(arrays, done, done + count);
        subtract(0, touching.before[count]);
      }
      sum.force[3] = dissipation;
      sum.store(arrays.wrenches[patch]);
    }
  }
}

template <class Normal, class Shear>
constexpr ForceKernel kernelFor() {
  if constexpr (Normal::kByArea) {
    return nullptr;
  } else {
    return forcesOf<Normal, Shear>;
  }
}

template <class Normal, class... Shears>
constexpr std::array<ForceKernel, sizeof...(Shears)> kernelsOf(LawList<Shears...>) {
  return {kernelFor<Normal, Shears>()...};
}

template <class... Normals>
constexpr std::array<std::array<ForceKernel, ShearLaws::kCount>, sizeof...(Normals)> allKernels(
    LawList<Normals...>) {
  return {kernelsOf<Normals>(ShearLaws{})...};
}

}  // namespace
}  // namespace granular::detail
