// SPDX-License-Identifier: MIT
// The forces of contacts; included once by the file for each processor, with that processor's packs. All of
// it is local to that file: a function that two of them shared could be taken from the wrong one.
#pragma once

#include <algorithm>
#include <cstddef>

#include "granular/contact/shear_constants.h"
#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/pack_rows.h"

namespace granular::detail {
namespace {

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

/// How their owners move.
struct PackMotion {
  Vector3Of<Pack> velocity, angularVelocity;
  Pack inverseMass;
};
template <class Function>
PackMotion motionsOf(Function&& rowOf) {
  static_assert(offsetof(OwnerRow, inverseMass) == 3 * sizeof(double));
  const FourPacks<Pack> motion = packsOf([&](int lane) { return rowOf(lane).velocity.data(); });
  const FourPacks<Pack> spin = packsOf([&](int lane) { return rowOf(lane).angularVelocity.data(); });
  return {{motion.first, motion.second, motion.third}, {spin.first, spin.second, spin.third}, motion.fourth};
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

/// How the frames of contacts turn: with the line of centres, on flat surfaces with these, and about it as
/// the two owners do on average. distance: of the centres; 0 where there is no line.
Vector3Of<Pack> turningOf(const PackMotion& motion1, const PackMotion& motion2, const Vector3Of<Pack>& N,
                          const Pack& distance, const Vector3Of<Pack>& velocityOfCenters, bool onSurfaces) {
  const Pack twist = 0.5 * Pack((motion1.angularVelocity + motion2.angularVelocity).dot(N));
  const Vector3Of<Pack> ofLine = Pack(1.0 / distance) * velocityOfCenters.cross(N);
  const Vector3Of<Pack> ofNoLine = onSurfaces ? motion2.angularVelocity : Vector3Of<Pack>::Zero();
  const Vector3Of<Pack> swing = select<Pack>(distance > 0.0, ofLine, ofNoLine);
  return swing + (twist - swing.dot(N)) * N;
}

using Entries = std::array<std::int32_t, kPackSize>;  // of Evaluation's memory; -1: none

/// What contacts remember, as packs; fills in what the geometry wants to know of it.
template <class Normal>
Vector3Of<Pack> displacementsOf(const ContactArrays& arrays, const Entries& entry,
                                const ShearConstantsOf<Pack>& shear, ContactGeometryOf<Pack>& g) {
  static constexpr std::array<double, 3> kNothing = {};
  const auto remembered = [&](int axis) {
    return Pack([&](int lane) {
      return (entry[lane] < 0 ? kNothing.data() : arrays.displacements + 3 * entry[lane])[axis];
    });
  };
  for (int lane = 0; lane < kPackSize; ++lane) {
    g.isNew.set(lane, entry[lane] < 0);
    g.slides.set(lane, entry[lane] >= 0 && arrays.memory[entry[lane]].slides);
  }
  g.stiffnessBefore =
      Pack([&](int lane) { return entry[lane] < 0 ? 0.0 : arrays.memory[entry[lane]].stiffness; });
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
  storeRows({ifTouching(D.x()), ifTouching(D.y()), ifTouching(D.z()), ifTouching(memory.stiffness)},
            [&](int lane) { return of(lane).displacement.data(); });
  storeRows({ifTouching(next.x()), ifTouching(next.y()), ifTouching(next.z()), ifTouching(memory.loss)},
            [&](int lane) { return of(lane).nextRate.data(); });
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
  Pack contacts = 0.0, pushing = 0.0;  // how many
};

/// Which contacts are in one pack, and of what. Lanes to spare read what the last contact reads.
struct PackContacts {
  std::array<std::int32_t, kPackSize> contact, slot1, slot2, place1, place2;

  PackContacts(const ContactArrays& arrays, const std::int32_t* which, std::int32_t count) {
    for (int lane = 0; lane < kPackSize; ++lane) {
      contact[lane] = which[count < kPackSize ? std::min(lane, count - 1) : lane];
      slot1[lane] = arrays.contacts[contact[lane]].slot1;
      slot2[lane] = arrays.contacts[contact[lane]].slot2;
      place1[lane] = arrays.placeOfSlot[slot1[lane]];
      place2[lane] = arrays.placeOfSlot[slot2[lane]];
    }
  }
};

/// Where they meet and how they move there.
struct PackMeeting {
  PackParticles a;
  PackMotion motion1, motion2;
  ContactGeometryOf<Pack> g;
  Pack distance;  ///< of the centres, m; 0 on flat surfaces
  Vector3Of<Pack> velocityOfCenters;
  Pack effectiveRadius, smallerRadius;
};

PackMeeting meetingOf(const ContactArrays& arrays, const PackContacts& pack, bool onSurfaces) {
  PackMeeting meeting;
  PackParticles& a = meeting.a;
  ContactGeometryOf<Pack>& g = meeting.g;
  a = particlesOf([&](int lane) -> auto& { return arrays.particles[pack.slot1[lane]]; });
  PackParticles b;
  if (onSurfaces) {
    const FourPacks<Pack> way =
        packsOf([&](int lane) { return arrays.forces[pack.contact[lane]].force.data(); });
    const FourPacks<Pack> place =
        packsOf([&](int lane) { return arrays.forces[pack.contact[lane]].point.data(); });
    const Pack inverseRadius =
        Pack([&](int lane) { return arrays.surfaceInverseRadius[pack.slot2[lane] - arrays.particleCount]; });
    g.N = {way.first, way.second, way.third};
    g.share = way.fourth;
    g.point = {place.first, place.second, place.third};
    g.xi = place.fourth;
    meeting.distance = select(inverseRadius > 0.0, Pack(a.radius + 1.0 / inverseRadius - g.xi), 0.0);
    b.center = a.center + meeting.distance * g.N;
    meeting.effectiveRadius = a.radius / (1.0 + a.radius * inverseRadius);
    meeting.smallerRadius = a.radius;
  } else {
    b = particlesOf([&](int lane) -> auto& { return arrays.particles[pack.slot2[lane]]; });
    meeting.distance = placeContacts(a, b, g);
    meeting.effectiveRadius = a.radius * b.radius / (a.radius + b.radius);
    meeting.smallerRadius = min(a.radius, b.radius);
  }
  const PackMotion motion1 = meeting.motion1 =
      motionsOf([&](int lane) -> auto& { return arrays.owners[pack.place1[lane]]; });
  const PackMotion motion2 = meeting.motion2 =
      motionsOf([&](int lane) -> auto& { return arrays.owners[pack.place2[lane]]; });
  if (arrays.movesOnlySpheres && !onSurfaces) {
    const Vector3Of<Pack> apart = motion1.velocity - motion2.velocity;
    const Pack arm1 = a.radius - 0.5 * g.xi, arm2 = b.radius - 0.5 * g.xi;
    g.V = apart + (arm1 * motion1.angularVelocity + arm2 * motion2.angularVelocity).cross(g.N);  // eq. 3
    meeting.velocityOfCenters = apart;  // what turns spheres moves the point only
    return meeting;
  }
  const PackParticles ball1 = arrays.movesOnlySpheres ? a : particlesOf([&](int lane) -> auto& {
    return arrays.balls[pack.place1[lane]];
  });
  const PackParticles ball2 =
      particlesOf([&](int lane) -> auto& { return arrays.balls[pack.place2[lane] - arrays.firstBall]; });
  const auto between = [&](const Vector3Of<Pack>& on1, const Vector3Of<Pack>& on2) {
    return motion1.velocity + motion1.angularVelocity.cross(on1 - ball1.center) -
           (motion2.velocity + motion2.angularVelocity.cross(on2 - ball2.center));
  };
  g.V = between(g.point, g.point);  // eq. 3
  meeting.velocityOfCenters = between(a.center, b.center);
  return meeting;
}

/// At most kPackSize contacts. request: all but sizes and masses.
template <class Normal, class Shear>
[[gnu::flatten]] void forcesOfPack(const ContactArrays& arrays, const ContactRun& run,
                                   NormalRequestOf<Pack>& request, std::span<const std::int32_t> which,
                                   PackExtremes& packed) {
  const auto count = static_cast<std::int32_t>(std::min(which.size(), std::size_t{kPackSize}));
  const PackContacts pack(arrays, which.data(), count);
  PackMeeting meeting = meetingOf(arrays, pack, run.onSurfaces);
  ContactGeometryOf<Pack>& g = meeting.g;
  const Pack inverseMass = meeting.motion1.inverseMass + meeting.motion2.inverseMass;
  request.contact.mass = select(inverseMass > 0.0, Pack(1.0 / inverseMass), 1.0);
  request.contact.radius = meeting.effectiveRadius;
  const NormalConstantsOf<Pack> normal = Normal::template constants<Pack>(request);
  const ShearConstantsOf<Pack> shear =
      shearConstants<Normal, Pack>(*run.pair, normal, request.contact.mass, 1.0);

  const auto touches = g.xi > 0.0;  // the test of findContacts and the exact overlap disagree by rounding
  ContactResultOf<Pack> result;
  if constexpr (Shear::kHasMemory) {
    Entries entry;
    for (int lane = 0; lane < kPackSize; ++lane) {
      entry[lane] = arrays.memoryOfCandidate[arrays.contacts[pack.contact[lane]].candidate];
    }
    ContactMemoryOf<Pack> memory;
    g.turning = turningOf(meeting.motion1, meeting.motion2, g.N, meeting.distance, meeting.velocityOfCenters,
                          run.onSurfaces);
    const Vector3Of<Pack> D = displacementsOf<Normal>(arrays, entry, shear, g);
    result = resultWithMemory<Normal, Shear, Pack>(normal, shear, g, D, memory);
    SettledMemory nowhere;
    storeMemory(arrays, entry, memory, touches, count, [&](int lane) -> SettledMemory& {
      return lane < count ? arrays.contactMemory[pack.contact[lane]] : nowhere;
    });
  } else {
    result = resultWithoutMemory<Normal, Shear, Pack>(normal, shear, g);
  }
  const auto ifTouching = [&](const Pack& value) { return select(touches, value, 0.0); };
  ContactForce nowhere;
  const auto to = [&](int lane) -> ContactForce& {
    return lane < count ? arrays.forces[pack.contact[lane]] : nowhere;
  };
  storeRows({ifTouching(result.force.x()), ifTouching(result.force.y()), ifTouching(result.force.z()),
             ifTouching(result.dissipation)},
            [&](int lane) { return to(lane).force.data(); });
  storeRows({g.point.x(), g.point.y(), g.point.z(), g.xi}, [&](int lane) { return to(lane).point.data(); });

  packed.urgency = max(packed.urgency, ifTouching(Normal::urgency(normal, g.xi, Pack(g.V.dot(g.N)))));
  packed.overlap = max(packed.overlap, g.xi / meeting.smallerRadius);
  const auto counts = touches && Pack([](int lane) { return double(lane); }) < Pack(double(count));
  packed.contacts = packed.contacts + select(counts, Pack(1.0), 0.0);
  packed.pushing = packed.pushing + select(counts && result.normalForce != 0.0, Pack(1.0), 0.0);
}

template <class Normal, class Shear>
void forcesOf(const ContactArrays& arrays, const ContactRun& run, Extremes& extremes) {
  NormalRequestOf<Pack> request = requestOf<Pack>(*run.pair, run.ofBodies);
  PackExtremes packed;
  for (std::size_t n = 0; n < run.which.size(); n += kPackSize) {
    forcesOfPack<Normal, Shear>(arrays, run, request, run.which.subspan(n), packed);
  }
  for (int lane = 0; lane < kPackSize; ++lane) {
    extremes.urgency = std::max(extremes.urgency, packed.urgency[lane]);
    extremes.overlap = std::max(extremes.overlap, packed.overlap[lane]);
    extremes.contacts += static_cast<std::int32_t>(packed.contacts[lane]);
    extremes.pushing += static_cast<std::int32_t>(packed.pushing[lane]);
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
