// SPDX-License-Identifier: MIT
// Where two things meet and how they move there: first side by side in memory, a contact after the other,
// then in packs. Part of contact_kernels_body.h, and local to the file
// that includes it as all of that.
#pragma once

#include <array>
#include <cstddef>
#include <cstring>

#include "granular/contact/contact_kernel.h"
#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/pack_rows.h"

namespace granular::detail {
namespace {

/// Four numbers of a contact, as exact as P's. Differences of positions and velocities are taken in double
/// precision before: what they are between neighbours is all that a law wants to know.
template <class P>
using RowOf = std::conditional_t<std::is_same_v<P, Pack>, Four, FourFloats>;

/// What is known of a contact before its law, in rows of four numbers. Arms only where something else than
/// spheres moves.
enum MeetingRowIndex : int {
  kApart,   ///< velocity of owner 1 less that of owner 2, m/s; 1 in the block's own rows, else 0
  kSpin1,   ///< angular velocity of owner 1, rad/s; R1, m. Right behind kApart
  kSpin2,   ///< angular velocity of owner 2, rad/s; R2, m; on surfaces one over the surface's radius, 1/m
  kLaw,     ///< as ContactArrays::lawRows
  kArm1,    ///< from the centre of owner 1 to that of particle 1, m; on surfaces to the point
            ///< and the slope of the surface's distance
  kArm2,    ///< the same for owner and particle 2
  kNormal,  ///< on surfaces: the normal and the overlap, m
};
constexpr int rowsOfMeeting(bool movesOnlySpheres, bool onSurfaces) {
  return onSurfaces ? kNormal + 1 : movesOnlySpheres ? kArm1 : kNormal;
}

/// Of as many contacts as P has lanes.
template <class P, bool kMovesOnlySpheres, bool kOnSurfaces>
struct MeetingRows {
  static constexpr int kRows = rowsOfMeeting(kMovesOnlySpheres, kOnSurfaces);
  alignas(64) RowOf<P> rows[P::kSize * kRows];
  /// Of two round particles: from particle 1 to particle 2 and the sum of radii, m, in double precision: an
  /// overlap is a small difference.
  alignas(64) Four ways[kOnSurfaces ? 1 : P::kSize];

  void put(int lane, int row, const Four& numbers) {
    rows[lane * kRows + row] = __builtin_convertvector(numbers, RowOf<P>);
  }
  FourPacks<P> of(int row) const {
    return packsOf<P>([&](int lane) { return rows[lane * kRows + row]; });
  }
};

static_assert(offsetof(ParticleRow, radius) == 3 * sizeof(double));

/// How owner 1 moves against owner 2, and turns: the rows kApart and kSpin1 of a lane.
template <class Rows>
void putMotion(Rows& to, int lane, const OwnerRow& owner1, const OwnerRow& owner2, double isOwn,
               const double& radius1) {
#ifdef __AVX512F__
  const __m512d one = _mm512_load_pd(owner1.velocity.data());
  __m512d motion = _mm512_mask_sub_pd(one, 0b0000'0111, one, _mm512_load_pd(owner2.velocity.data()));
  motion = _mm512_mask_mov_pd(motion, 0b0000'1000, _mm512_set1_pd(isOwn));
  motion = _mm512_mask_mov_pd(motion, 0b1000'0000, _mm512_set1_pd(radius1));
  auto* row = &to.rows[lane * Rows::kRows + kApart];
  if constexpr (sizeof(*row) == sizeof(Four)) {
    std::memcpy(row, &motion, sizeof(motion));
  } else {
    const __m256 narrow = _mm512_cvtpd_ps(motion);
    std::memcpy(row, &narrow, sizeof(narrow));
  }
#else
  const Four flag = {0.0, 0.0, 0.0, isOwn}, radius = {0.0, 0.0, 0.0, radius1};
  to.put(lane, kApart, withFourth(loadFour(owner1.velocity.data()) - loadFour(owner2.velocity.data()), flag));
  to.put(lane, kSpin1, withFourth(loadFour(owner1.angularVelocity.data()), radius));
#endif
}

template <class P>
char* lawRowOf(const ContactArrays& arrays, const Contact& contact) {
  return static_cast<char*>(arrays.lawRows) + contact.candidate * std::ptrdiff_t{sizeof(RowOf<P>)};
}

/// Of contacts from `first` on in the run.
template <class P, bool kMovesOnlySpheres, bool kOnSurfaces>
void gatherMeetings(const ContactArrays& arrays, const ContactRun& run, std::int32_t first,
                    MeetingRows<P, kMovesOnlySpheres, kOnSurfaces>& to) {
  const Four minus = {-1.0, -1.0, -1.0, 1.0};
  const double counts[2] = {0.0, 1.0};
  const ParticleRow *particles = arrays.particles, *balls = arrays.balls;
  const OwnerRow* owners = arrays.owners;
  const Contact* contacts = run.contacts;
  const std::int32_t* placeOfSlot = arrays.placeOfSlot;
  const std::int32_t dynamicParticles = arrays.dynamicParticles, firstSlot = run.firstSlot;
  const auto ownSlots = static_cast<std::uint32_t>(run.endSlot - run.firstSlot);
  const std::int32_t* which = run.which.data() + first;
  for (int lane = 0; lane < P::kSize; ++lane) {
    const Contact& contact = contacts[which[lane]];
    const std::int32_t slot1 = contact.slot1, slot2 = contact.slot2;
    const std::int32_t place1 = kMovesOnlySpheres ? slot1 : placeOfSlot[slot1];
    const std::int32_t place2 =
        kMovesOnlySpheres && !kOnSurfaces && slot2 < dynamicParticles ? slot2 : placeOfSlot[slot2];
    const OwnerRow &owner1 = owners[place1], &owner2 = owners[place2];
    const Four a = loadFour(&particles[slot1].x);
    const bool isOwn = static_cast<std::uint32_t>(slot1 - firstSlot) < ownSlots;
    putMotion(to, lane, owner1, owner2, counts[isOwn], particles[slot1].radius);
    std::memcpy(&to.rows[lane * to.kRows + kLaw], lawRowOf<P>(arrays, contact), sizeof(RowOf<P>));
    if constexpr (kOnSurfaces) {
      const SurfaceMeeting& meeting = run.surfaces[contact.surface];
      const double inverseRadius = arrays.surfaceInverseRadius[slot2 - arrays.particleCount];
      const Four point = loadFour(meeting.point.data()), normal = loadFour(meeting.normal.data());
      to.put(lane, kNormal, withFourth(normal, point));
      to.put(lane, kSpin2,
             withFourth(loadFour(owner2.angularVelocity.data()), Four{0.0, 0.0, 0.0, inverseRadius}));
      const Four center1 = loadFour(kMovesOnlySpheres ? &particles[slot1].x : &balls[place1].x);
      to.put(lane, kArm1, withFourth(point - center1, normal));
      to.put(lane, kArm2, point - loadFour(&balls[place2 - arrays.firstBall].x));
    } else {
      const Four b = loadFour(&particles[slot2].x);
      to.ways[lane] = b + minus * a;
      to.put(lane, kSpin2, withFourth(loadFour(owner2.angularVelocity.data()), b));
      if constexpr (!kMovesOnlySpheres) {
        to.put(lane, kArm1, a - loadFour(&balls[place1].x));
        to.put(lane, kArm2, b - loadFour(&balls[place2 - arrays.firstBall].x));
      }
    }
  }
}

/// Where some contacts meet and how they move there.
template <class P>
struct PackMeeting {
  ContactGeometryOf<P> g;
  P isOwn;              ///< 1 in the block's own rows, else 0
  P radius1, distance;  ///< distance: of the centres, m; 0 on flat surfaces
  P smallerRadius;
  P arm1, arm2;  ///< from the centres of the particles to the point, along N and against it, m
  Vector3Of<P> toPoint1, toPoint2;  ///< from the centres of the owners to the point, m
  Vector3Of<P> angularVelocity1, angularVelocity2;
  Vector3Of<P> velocityOfCenters;  ///< of particle 1 against 2, m/s
};

/// From particle 1 to particle 2, m, and (R1 + R2)^2 less its square, m^2, which single precision would not
/// see in R1 + R2 and the way.
FourPacks<Pack> wayAndDepth(const Four* ways) {
  const FourPacks<Pack> d = packsOf<Pack>([&](int lane) { return ways[lane]; });
  const Pack depth = (d.fourth * d.fourth - d.third * d.third) - (d.first * d.first + d.second * d.second);
  return {d.first, d.second, d.third, depth};
}
template <class P>
FourPacks<P> waysOf(const Four* ways) {
  const FourPacks<Pack> low = wayAndDepth(ways);
  if constexpr (std::is_same_v<P, Pack>) {
    return low;
  } else {
    const FourPacks<Pack> high = wayAndDepth(ways + Pack::kSize);
    return {narrowed(low.first, high.first), narrowed(low.second, high.second),
            narrowed(low.third, high.third), narrowed(low.fourth, high.fourth)};
  }
}

/// Of two round particles. radius2: of particle 2.
template <class P>
void meetRound(const FourPacks<P>& way, const P& radius2, PackMeeting<P>& meeting) {
  ContactGeometryOf<P>& g = meeting.g;
  const Vector3Of<P> apart{way.first, way.second, way.third};
  const P sum = meeting.radius1 + radius2;
  const P distance = sqrt(apart.squaredNorm()), inverse = 1.0 / distance;
  const auto isClear = distance > 0.0;  // else any direction does, as long as it is always the same
  g.xi = max(P(0.0), way.fourth / (sum + distance));  // eq. 1
  g.N = {select(isClear, apart.x() * inverse, 0.0), select(isClear, apart.y() * inverse, 1.0),
         select(isClear, apart.z() * inverse, 0.0)};  // eq. 2
  meeting.arm1 = meeting.radius1 - 0.5 * g.xi;
  meeting.distance = distance;
  meeting.smallerRadius = min(meeting.radius1, radius2);
}

/// Of round particles on exact surfaces. inverseRadius: of the surfaces.
template <class P>
void meetSurface(const FourPacks<P>& way, const P& slope, const P& inverseRadius, PackMeeting<P>& meeting) {
  ContactGeometryOf<P>& g = meeting.g;
  g.N = {way.first, way.second, way.third};
  g.share = slope;
  g.xi = way.fourth;
  const P R = meeting.radius1;
  meeting.arm1 = R - g.xi;
  meeting.distance = select(inverseRadius > 0.0, P(R + 1.0 / inverseRadius - g.xi), 0.0);
  meeting.smallerRadius = R;
}

template <class P, bool kMovesOnlySpheres, bool kOnSurfaces>
PackMeeting<P> meetingOf(const MeetingRows<P, kMovesOnlySpheres, kOnSurfaces>& rows) {
  const auto vectorOf = [](const FourPacks<P>& row) -> Vector3Of<P> {
    return {row.first, row.second, row.third};
  };
  PackMeeting<P> meeting;
  ContactGeometryOf<P>& g = meeting.g;
  const FourPacks<P> apart = rows.of(kApart), spin1 = rows.of(kSpin1), spin2 = rows.of(kSpin2);
  const Vector3Of<P> w1 = meeting.angularVelocity1 = vectorOf(spin1);
  const Vector3Of<P> w2 = meeting.angularVelocity2 = vectorOf(spin2);
  meeting.isOwn = apart.fourth;
  meeting.radius1 = spin1.fourth;
  if constexpr (kOnSurfaces) {
    meetSurface<P>(rows.of(kNormal), rows.of(kArm1).fourth, spin2.fourth, meeting);
  } else {
    meetRound<P>(waysOf<P>(rows.ways), spin2.fourth, meeting);
  }
  // How the point moves (eq. 3), and the centres. What turns round particles moves the point alone.
  meeting.arm2 = meeting.distance - meeting.arm1;
  const Vector3Of<P> ofPoint = (meeting.arm1 * w1 + meeting.arm2 * w2).cross(g.N);
  g.V = vectorOf(apart) + ofPoint;
  meeting.velocityOfCenters = vectorOf(apart);
  meeting.toPoint1 = meeting.arm1 * g.N;
  meeting.toPoint2 = P(-meeting.arm2) * g.N;
  if constexpr (kMovesOnlySpheres && !kOnSurfaces) return meeting;
  const Vector3Of<P> arm1 = vectorOf(rows.of(kArm1)), arm2 = vectorOf(rows.of(kArm2));
  const Vector3Of<P> ofArms = w1.cross(arm1) - w2.cross(arm2);
  if constexpr (kOnSurfaces) {  // arms reach to the point
    g.V = vectorOf(apart) + ofArms;
    meeting.velocityOfCenters = g.V - ofPoint;
    meeting.toPoint1 = arm1;
    meeting.toPoint2 = arm2;
  } else {
    g.V = g.V + ofArms;
    meeting.velocityOfCenters = vectorOf(apart) + ofArms;
    meeting.toPoint1 = meeting.toPoint1 + arm1;
    meeting.toPoint2 = meeting.toPoint2 + arm2;
  }
  return meeting;
}

}  // namespace
}  // namespace granular::detail
