// SPDX-License-Identifier: MIT
// The forces of contacts; included once by the file for each processor, with that processor's packs. All of
// it is local to that file: a function that two of them shared could be taken from the wrong one.
#pragma once

#include <algorithm>

#include "granular/contact/shear_constants.h"
#include "granular/system/detail/contact_meeting_body.h"

namespace granular::detail {
namespace {

/// How the frames of contacts turn: with the line of centres, on flat surfaces with these, and about it as
/// the two owners do on average.
template <class P>
Vector3Of<P> turningOf(const PackMeeting<P>& meeting, bool onSurfaces) {
  const Vector3Of<P>& N = meeting.g.N;
  const P twist = 0.5 * P((meeting.angularVelocity1 + meeting.angularVelocity2).dot(N));
  const Vector3Of<P> ofLine = P(1.0 / meeting.distance) * meeting.velocityOfCenters.cross(N);
  const Vector3Of<P> ofNoLine = onSurfaces ? meeting.angularVelocity2 : Vector3Of<P>::Zero();
  const Vector3Of<P> swing = select<P>(meeting.distance > 0.0, ofLine, ofNoLine);
  return swing + (twist - swing.dot(N)) * N;
}

template <class P>
using Entries = std::array<std::int32_t, P::kSize>;  // of Evaluation's memory; -1: none

/// What contacts remember, as packs; fills in what the geometry wants to know of it.
template <class Normal, class P>
Vector3Of<P> displacementsOf(const ContactArrays& arrays, const Entries<P>& entry,
                             const ShearConstantsOf<P>& shear, ContactGeometryOf<P>& g) {
  // Read with the number that lies before the three.
  const FourPacks<P> remembered = packsOf<P>([&](int lane) {
    return entry[lane] < 0 ? Four{} : loadFour(arrays.displacements + 3 * std::int64_t{entry[lane]} - 1);
  });
  const FourPacks<P> before = packsOf<P>([&](int lane) {
    const Four unknown = {0.0, -1.0, 0.0, 0.0};  // the fourth is no number
    return entry[lane] < 0 ? unknown : withFourth(loadFour(&arrays.memory[entry[lane]].stiffness), unknown);
  });
  g.stiffnessBefore = before.first;
  g.isNew = before.second < P(0.0);
  g.slides = before.second > P(0.0);
  g.memoryStep = select(g.isNew, P(0.0), arrays.at.memoryStep);
  // Begun within this trial: it has slid since its overlap was zero.
  const P xiDot = g.V.dot(g.N);
  const P since = min(P(g.xi / xiDot), P(arrays.at.sinceTrial));
  const P slid = select(g.isNew && xiDot > 0.0, P(since / (1.0 + stiffnessPower<Normal>(shear))), 0.0);
  return Vector3Of<P>{remembered.second, remembered.third, remembered.fourth} + slid * (g.V - xiDot * g.N);
}

/// What contacts remember once the sub-step is accepted, 0 where they do not touch after all; and at what
/// rate what they remember so far changes.
template <class P>
void storeMemory(const ContactArrays& arrays, const ContactRun& run, const std::int32_t* contact,
                 const Entries<P>& entry, const ContactMemoryOf<P>& memory, const MaskOf<P>& touches) {
  const auto ifTouching = [&](const P& value) { return select(touches, value, 0.0); };
  const Vector3Of<P>&D = memory.displacement, &next = memory.nextRate;
  forRows<P>(
      {ifTouching(D.x()), ifTouching(D.y()), ifTouching(D.z()), ifTouching(memory.stiffness)},
      [&](int lane, const Four& row) { storeFour(row, run.memory[contact[lane]].displacement.data()); });
  forRows<P>({ifTouching(memory.loss), ifTouching(memory.heating),
              ifTouching(select(memory.slides, P(1.0), 0.0)), ifTouching(P(1.0))},
             [&](int lane, const Four& row) { storeFour(row, &run.memory[contact[lane]].loss); });
  if (!arrays.at.memoryRates) return;
  forRows<P>({next.x(), next.y(), next.z(), P(0.0)},
             [&](int lane, const Four& row) { storeFour(row, run.nextRates[contact[lane]].vector.data()); });
  for (int lane = 0; lane < P::kSize; ++lane) {
    if (entry[lane] < 0 || !touches[lane] || !run.isOwn(run.contacts[contact[lane]])) continue;
    double* rate = arrays.displacementRates + 3 * std::int64_t{entry[lane]};
    rate[0] = memory.rate.x()[lane], rate[1] = memory.rate.y()[lane], rate[2] = memory.rate.z()[lane];
  }
}

/// Largest urgency in any lane: powers of times, which overflow in single precision. 0 for constants of 0.
template <class Normal>
Pack urgencyOf(const NormalConstantsOf<Pack>& normal, const Pack& xi, const Pack& xiDot) {
  return Normal::urgency(normal, xi, xiDot);
}
template <class Normal>
Pack urgencyOf(const NormalConstantsOf<FloatPack>& normal, const FloatPack& xi, const FloatPack& xiDot) {
  NormalConstantsOf<Pack> low, high;
  low.stiffnessPerMass = wide(normal.stiffnessPerMass.low), low.impactRate = wide(normal.impactRate.low);
  high.stiffnessPerMass = wide(normal.stiffnessPerMass.high), high.impactRate = wide(normal.impactRate.high);
  return max(Normal::urgency(low, wide(xi.low), wide(xiDot.low)),
             Normal::urgency(high, wide(xi.high), wide(xiDot.high)));
}

/// Of the contacts so far, in every lane.
template <class P>
struct PackExtremes {
  Pack urgency = 0.0;
  P overlap = 0.0;
  P contacts = 0.0, pushing = 0.0;  // how many
};

/// What the laws of a pair take from sizes and masses, in the four numbers of its law row.
template <class Normal, class Shear, class P>
struct PairConstants {
  NormalConstantsOf<P> normal = {};
  ShearConstantsOf<P> shear = {};

  static PairConstants from(const MaterialPair& pair, double smallestForce, const FourPacks<P>& row) {
    PairConstants constants;
    constants.shear = shearConstantsFrom<Shear, P>(pair, row.fourth);
    constants.normal.kr = row.first;
    constants.normal.kd = row.second;
    constants.normal.smallestForce = smallestForce;
    Normal::template urgencyConstant<P>(constants.normal) = row.third;
    return constants;
  }
  FourPacks<P> row() {
    return {normal.kr, normal.kd, Normal::template urgencyConstant<P>(normal),
            ownShearConstant<Shear, P>(shear)};
  }
};

/// The law rows of a run.
template <class Normal, class Shear, class P>
GRANULAR_KERNEL void lawsOf(const ContactArrays& arrays, const ContactRun& run) {
  NormalRequestOf<P> request = requestOf<P>(*run.pair, run.ofBodies);
  for (std::size_t n = 0; n < run.which.size(); n += P::kSize) {
    const std::int32_t* contact = run.which.data() + n;
    const auto contactAt = [&](int lane) -> const Contact& { return run.contacts[contact[lane]]; };
    const auto ownerOf = [&](std::int32_t slot) -> const OwnerRow& {
      return arrays.owners[arrays.placeOfSlot[slot]];
    };
    const P inverseMass([&](int lane) {
      return ownerOf(contactAt(lane).slot1).inverseMass + ownerOf(contactAt(lane).slot2).inverseMass;
    });
    const P inverseRadius([&](int lane) {
      const Contact& pair = contactAt(lane);
      return 1.0 / arrays.particles[pair.slot1].radius +
             (run.onSurfaces ? arrays.surfaceInverseRadius[pair.slot2 - arrays.particleCount]
                             : 1.0 / arrays.particles[pair.slot2].radius);
    });
    request.contact.mass = select(inverseMass > 0.0, P(1.0 / inverseMass), 1.0);
    request.contact.radius = 1.0 / inverseRadius;
    PairConstants<Normal, Shear, P> constants;
    constants.normal = Normal::template constants<P>(request);
    constants.shear = shearConstants<Normal, P>(*run.pair, constants.normal, request.contact.mass, 1.0);
    forRows<P>(constants.row(), [&](int lane, const Four& row) {
      const auto narrow = __builtin_convertvector(row, RowOf<P>);
      std::memcpy(lawRowOf<P>(arrays, contactAt(lane)), &narrow, sizeof(narrow));
    });
  }
}

/// Contacts from `first` on in the run, as many as P has lanes, of which `count` are there.
template <class Normal, class Shear, class P, bool kMovesOnlySpheres, bool kOnSurfaces>
void forcesOfPack(const ContactArrays& arrays, const ContactRun& run, double smallestForce,
                  std::int32_t first, std::int32_t count, PackExtremes<P>& packed) {
  MeetingRows<P, kMovesOnlySpheres, kOnSurfaces> rows;
  gatherMeetings(arrays, run, first, rows);
  PackMeeting<P> meeting = meetingOf(rows);
  ContactGeometryOf<P>& g = meeting.g;
  const auto [normal, shear] = PairConstants<Normal, Shear, P>::from(*run.pair, smallestForce, rows.of(kLaw));
  const std::int32_t* contact = run.which.data() + first;  // laws with memory ask who they are

  const auto touches = g.xi > 0.0;  // rounding may disagree with findContacts
  ContactResultOf<P> result;
  if constexpr (Shear::kHasMemory) {
    Entries<P> entry;
    for (int lane = 0; lane < P::kSize; ++lane) {
      entry[lane] = arrays.memoryOfCandidate[arrays.indexOfCandidate[run.contacts[contact[lane]].candidate]];
    }
    ContactMemoryOf<P> memory;
    g.turning = turningOf(meeting, kOnSurfaces);
    const Vector3Of<P> D = displacementsOf<Normal, P>(arrays, entry, shear, g);
    result = resultWithMemory<Normal, Shear, P>(normal, shear, g, D, memory);
    storeMemory<P>(arrays, run, contact, entry, memory, touches);
  } else {
    result = resultWithoutMemory<Normal, Shear, P>(normal, shear, g);
  }
  const auto ifTouching = [&](const P& value) { return select(touches, value, 0.0); };
  const Vector3Of<P> force{ifTouching(result.force.x()), ifTouching(result.force.y()),
                           ifTouching(result.force.z())};
  const Vector3Of<P> torque1 = meeting.toPoint1.cross(force), torque2 = meeting.toPoint2.cross(force);
  forRows<P>({force.x(), force.y(), force.z(), ifTouching(result.dissipation)},
             [&](int lane, const Four& row) { storeFour(row, run.forces[first + lane].force.data()); });
  forRows<P>({torque2.x(), torque2.y(), torque2.z(), g.xi},
             [&](int lane, const Four& row) { storeFour(row, run.forces[first + lane].torque.data()); });
  forRows<P>({torque1.x(), torque1.y(), torque1.z(), ifTouching(result.damping)},
             [&](int lane, const Four& row) { storeFour(row, run.torques[first + lane].vector.data()); });

  const P xiDot = g.V.dot(g.N);
  NormalConstantsOf<P> pressing = normal;
  P& constant = Normal::template urgencyConstant<P>(pressing);
  constant = ifTouching(constant);
  packed.urgency = max(packed.urgency, urgencyOf<Normal>(pressing, g.xi, xiDot));
  packed.overlap = max(packed.overlap, g.xi / meeting.smallerRadius);
  const auto counts = touches && P([](int lane) { return double(lane); }) < P(double(count));
  packed.contacts = packed.contacts + select(counts, meeting.isOwn, 0.0);
  packed.pushing = packed.pushing + select(counts && result.normalForce != 0.0, meeting.isOwn, 0.0);
}

template <class Normal, class Shear, class P, bool kMovesOnlySpheres, bool kOnSurfaces>
GRANULAR_KERNEL void forcesOfRun(const ContactArrays& arrays, const ContactRun& run, Extremes& extremes) {
  const double smallestForce = requestOf<double>(*run.pair, run.ofBodies).smallestForce();
  PackExtremes<P> packed;
  static_assert(kContactsPerPack % P::kSize == 0);
  const auto count = static_cast<std::int32_t>(run.which.size());
  for (std::int32_t n = 0; n < count; n += P::kSize) {
    forcesOfPack<Normal, Shear, P, kMovesOnlySpheres, kOnSurfaces>(arrays, run, smallestForce, n, count - n,
                                                                   packed);
  }
  for (int lane = 0; lane < Pack::kSize; ++lane) {
    extremes.urgency = std::max(extremes.urgency, packed.urgency[lane]);
  }
  for (int lane = 0; lane < P::kSize; ++lane) {
    extremes.overlap = std::max(extremes.overlap, packed.overlap[lane]);
    extremes.contacts += static_cast<std::int32_t>(packed.contacts[lane]);
    extremes.pushing += static_cast<std::int32_t>(packed.pushing[lane]);
  }
}
template <class Normal, class Shear, class P>
void forcesOf(const ContactArrays& arrays, const ContactRun& run, Extremes& extremes) {
  if (arrays.movesOnlySpheres) {
    return run.onSurfaces ? forcesOfRun<Normal, Shear, P, true, true>(arrays, run, extremes)
                          : forcesOfRun<Normal, Shear, P, true, false>(arrays, run, extremes);
  }
  return run.onSurfaces ? forcesOfRun<Normal, Shear, P, false, true>(arrays, run, extremes)
                        : forcesOfRun<Normal, Shear, P, false, false>(arrays, run, extremes);
}

template <class P, class Normal, class... Shears>
constexpr void addKernels(ForceKernels& kernels, LawList<Shears...>, int normal) {
  if constexpr (!Normal::kByArea) {
    kernels.laws[normal] = {lawsOf<Normal, Shears, P>...};
    kernels.forces[normal] = {forcesOf<Normal, Shears, P>...};
  }
}

/// P: of what the laws are worked out in.
template <class P, class... Normals>
constexpr ForceKernels allKernels(LawList<Normals...>) {
  ForceKernels kernels{.lawRowSize = sizeof(RowOf<P>), .laws = {}, .forces = {}};
  int normal = 0;
  (addKernels<P, Normals>(kernels, ShearLaws{}, normal++), ...);
  return kernels;
}

}  // namespace
}  // namespace granular::detail
