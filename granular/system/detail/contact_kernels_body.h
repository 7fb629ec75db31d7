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
  for (int lane = 0; lane < P::kSize; ++lane) {
    g.isNew.set(lane, entry[lane] < 0);
    g.slides.set(lane, entry[lane] >= 0 && arrays.memory[entry[lane]].slides);
  }
  g.stiffnessBefore =
      P([&](int lane) { return entry[lane] < 0 ? 0.0 : arrays.memory[entry[lane]].stiffness; });
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
void storeMemory(const ContactArrays& arrays, const std::int32_t* contact, const Entries<P>& entry,
                 const ContactMemoryOf<P>& memory, const MaskOf<P>& touches) {
  const auto ifTouching = [&](const P& value) { return select(touches, value, 0.0); };
  const auto of = [&](int lane) -> SettledMemory& { return arrays.contactMemory[contact[lane]]; };
  const Vector3Of<P>&D = memory.displacement, &next = memory.nextRate;
  forRows<P>({ifTouching(D.x()), ifTouching(D.y()), ifTouching(D.z()), ifTouching(memory.stiffness)},
             [&](int lane, const Four& row) { storeFour(row, of(lane).displacement.data()); });
  forRows<P>({ifTouching(next.x()), ifTouching(next.y()), ifTouching(next.z()), ifTouching(memory.loss)},
             [&](int lane, const Four& row) { storeFour(row, of(lane).nextRate.data()); });
  const P heating = ifTouching(memory.heating);
  for (int lane = 0; lane < P::kSize; ++lane) {
    of(lane).heating = heating[lane];
    of(lane).slides = touches[lane] && memory.slides[lane];
    of(lane).touches = touches[lane];
    if (!arrays.at.poseRates || entry[lane] < 0 || !touches[lane]) continue;
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

/// Contacts from `contact` on, as many as P has lanes, of which `count` count. request: all but sizes and
/// masses.
template <class Normal, class Shear, class P>
GRANULAR_KERNEL void forcesOfPack(const ContactArrays& arrays, const ContactRun& run,
                                  NormalRequestOf<P>& request, const std::int32_t* contact,
                                  std::int32_t count, PackExtremes<P>& packed) {
  PackMeeting<P> meeting = meetingOf<P>(arrays, run, contact);
  ContactGeometryOf<P>& g = meeting.g;
  request.contact.mass = select(meeting.inverseMass > 0.0, P(1.0 / meeting.inverseMass), 1.0);
  request.contact.radius = meeting.effectiveRadius;
  const NormalConstantsOf<P> normal = Normal::template constants<P>(request);
  const ShearConstantsOf<P> shear = shearConstants<Normal, P>(*run.pair, normal, request.contact.mass, 1.0);

  const auto touches = g.xi > 0.0;  // rounding may disagree with findContacts
  ContactResultOf<P> result;
  if constexpr (Shear::kHasMemory) {
    Entries<P> entry;
    for (int lane = 0; lane < P::kSize; ++lane) {
      entry[lane] = arrays.memoryOfCandidate[arrays.contacts[contact[lane]].candidate];
    }
    ContactMemoryOf<P> memory;
    g.turning = turningOf(meeting, run.onSurfaces);
    const Vector3Of<P> D = displacementsOf<Normal, P>(arrays, entry, shear, g);
    result = resultWithMemory<Normal, Shear, P>(normal, shear, g, D, memory);
    storeMemory<P>(arrays, contact, entry, memory, touches);
  } else {
    result = resultWithoutMemory<Normal, Shear, P>(normal, shear, g);
  }
  const auto ifTouching = [&](const P& value) { return select(touches, value, 0.0); };
  forRows<P>({ifTouching(result.force.x()), ifTouching(result.force.y()), ifTouching(result.force.z()),
              ifTouching(result.dissipation)},
             [&](int lane, const Four& row) { storeFour(row, arrays.forces[contact[lane]].force.data()); });
  if (!run.onSurfaces) {  // whose points are there already
    const Vector3Of<P> toPoint = meeting.arm1 * g.N;
    forRows<P>({toPoint.x(), toPoint.y(), toPoint.z(), g.xi}, [&](int lane, const Four& row) {
      const ParticleRow& particle = arrays.particles[arrays.contacts[contact[lane]].slot1];
      storeFour(withFourth(loadFour(&particle.x), Four{}) + row, arrays.forces[contact[lane]].point.data());
    });
  }

  const P xiDot = g.V.dot(g.N);
  NormalConstantsOf<P> pressing;
  pressing.stiffnessPerMass = ifTouching(normal.stiffnessPerMass);
  pressing.impactRate = ifTouching(normal.impactRate);
  packed.urgency = max(packed.urgency, urgencyOf<Normal>(pressing, g.xi, xiDot));
  packed.overlap = max(packed.overlap, g.xi / meeting.smallerRadius);
  const auto counts = touches && P([](int lane) { return double(lane); }) < P(double(count));
  packed.contacts = packed.contacts + select(counts, P(1.0), 0.0);
  packed.pushing = packed.pushing + select(counts && result.normalForce != 0.0, P(1.0), 0.0);
}

template <class Normal, class Shear, class P>
void forcesOf(const ContactArrays& arrays, const ContactRun& run, Extremes& extremes) {
  NormalRequestOf<P> request = requestOf<P>(*run.pair, run.ofBodies);
  PackExtremes<P> packed;
  static_assert(kContactsPerPack % P::kSize == 0);
  const auto count = static_cast<std::int32_t>(run.which.size());
  for (std::int32_t n = 0; n < count; n += P::kSize) {
    forcesOfPack<Normal, Shear, P>(arrays, run, request, run.which.data() + n, count - n, packed);
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
constexpr ForceKernel kernelFor() {
  if constexpr (Normal::kByArea) {
    return nullptr;
  } else {
    return forcesOf<Normal, Shear, P>;
  }
}

template <class P, class Normal, class... Shears>
constexpr std::array<ForceKernel, sizeof...(Shears)> kernelsOf(LawList<Shears...>) {
  return {kernelFor<Normal, Shears, P>()...};
}

/// P: of what the laws are worked out in.
template <class P, class... Normals>
constexpr ForceKernels allKernels(LawList<Normals...>) {
  return {gatherMeetings<P>, {kernelsOf<P, Normals>(ShearLaws{})...}};
}

}  // namespace
}  // namespace granular::detail
