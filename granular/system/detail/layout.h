// SPDX-License-Identifier: MIT
// How grains and bodies are laid out for one evaluation after another. Made anew when something is added,
// removed or changes its kind; everything here is constant while time goes on, but places and slots, which
// follow the cells.
//
// Numbering. Owners: awake grains, awake dynamic bodies, kinematic bodies, static bodies, sleeping grains,
// sleeping bodies; the first two, "dynamic" below, are in the integrator's state. Rank: a particle's place in
// the order of owners and local indices; sums run in it. Slot: where its row lies in memory; dynamic owners
// are kept in cell order. Patch: a grain, or 64 neighbouring particles of a moving body: what one wrench is
// summed for.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "granular/base/pose.h"
#include "granular/contact/pair_law.h"
#include "granular/search/candidate_list.h"
#include "granular/system/granular_system.h"

namespace granular::detail {

/// The integrator's state vector: the poses of dynamic owners by place, then their momenta, which steppers
/// read and write more often.
namespace state {
inline constexpr int kPoseSize = 7, kMomentaSize = 6, kSize = kPoseSize + kMomentaSize;
// After the owners: for each moving body what contacts did to it, and work; then the heat.
inline constexpr int kImpulse = 0;         ///< 3, N s
inline constexpr int kAngularImpulse = 3;  ///< 3, N m s
inline constexpr int kWork = 6;            ///< by the load on a dynamic body; by the body where kinematic, J
inline constexpr int kTallySize = 7;
}  // namespace state

/// One owner's numbers in a state, or in the rate of one.
template <class Number>  // double, or const double
struct OwnerNumbers {
  using Map = Eigen::Map<std::conditional_t<std::is_const_v<Number>, const Vector3, Vector3>>;
  Number *pose, *momenta;

  Map position() const { return Map(pose); }                ///< m
  Map velocity() const { return Map(momenta); }             ///< m/s
  Map angularMomentum() const { return Map(momenta + 3); }  ///< kg m^2/s, world
  Quaternion orientation() const { return {pose[3], pose[4], pose[5], pose[6]}; }
  void setOrientation(const Quaternion& q) const {
    pose[3] = q.w(), pose[4] = q.x(), pose[5] = q.y(), pose[6] = q.z();
  }
};

/// What bodies have and grains have not.
struct BodyTraits {
  std::span<const SurfacePiece> pieces;      ///< as Covering::pieces; may be empty
  std::span<const std::int32_t> firstPiece;  ///< of particle i; one entry more than particles, or none
  const ExactSurface* exact = nullptr;       ///< if there is one
  Pose exactPose;                            ///< of its frame in the body frame
  ExactUse exactUse = ExactUse::Everything;
  Vector3 linearFactor = Vector3::Ones();
  Vector3 angularFactor = Vector3::Ones();
  Vector3 freeAxes = Vector3::Ones();  ///< 0 for a locked axis of rotation, else 1, world
  double length = 0.0, area = 0.0;     ///< of its particles, as in PairSide

  std::span<const SurfacePiece> piecesOf(std::int32_t local) const {
    if (pieces.empty()) return {};
    return pieces.subspan(firstPiece[local], firstPiece[local + 1] - firstPiece[local]);
  }
};
extern const BodyTraits kNoBody;  ///< of every grain

struct Owner {
  OwnerKind kind = OwnerKind::Grain;
  bool isotropic = false;
  bool isSphere = false;    ///< a grain of one particle about the centre: its orientation places nothing
  bool isLocked = false;    ///< some axis of rotation is
  std::int32_t index = -1;  ///< GrainId::index or BodyId::index
  std::span<const ShapeParticle> particles;  ///< principal frame, before scale
  const BodyTraits* body = &kNoBody;
  double scale = 1.0;
  double inverseMass = 0.0;                  ///< 1/kg; 0 unless dynamic or asleep
  Vector3 inverseInertia = Vector3::Zero();  ///< principal, 1/(kg m^2)
  double reach = 0.0;                        ///< farthest particle surface from the centre, m
  std::int32_t material = -1;
  std::int32_t firstRank = 0;
  std::int32_t firstSlot = 0;
};
static_assert(sizeof(Owner) <= 96, "there is one for every grain");

/// omega = R I^-1 R^T L, world, with locked axes left out; rad/s.
inline Vector3 angularVelocityOf(const Owner& owner, const Quaternion& orientation,
                                 const Vector3& angularMomentum) {
  if (owner.isotropic && !owner.isLocked) return owner.inverseInertia.x() * angularMomentum;
  const Vector3 own = orientation.conjugate() * angularMomentum;
  const Vector3 world = orientation * owner.inverseInertia.cwiseProduct(own);
  return owner.isLocked ? Vector3(owner.body->freeAxes.cwiseProduct(world)) : world;
}

/// A particle or exact surface as the pair laws tell it apart.
struct ParticleKind {
  double inverseRadius = 0.0;  ///< 0 for an exact surface but a sphere: it counts as flat
  double inverseMass = 0.0;
  std::int32_t material = -1;
  bool isBody = false;
  double bodyLength = 0.0, bodyArea = 0.0;  ///< as in PairSide

  friend auto operator<=>(const ParticleKind&, const ParticleKind&) = default;
};

/// Of particle `local` of an owner, and of its exact surface.
ParticleKind particleKind(const Owner& owner, std::int32_t local);
ParticleKind surfaceKind(const Owner& owner);

/// What the pair laws are told of it.
inline PairSide sideOf(const ParticleKind& kind, const MaterialDef& material) {
  return {.contact = {kind.inverseMass, kind.inverseRadius, material.youngsModulus, material.poissonRatio},
          .isBody = kind.isBody,
          .bodyLength = kind.bodyLength,
          .bodyArea = kind.bodyArea};
}

struct Layout {
  static constexpr std::int32_t kParticlesPerPatch = 64;
  static constexpr std::size_t kMostKinds = 64;  ///< their pair laws are a table (1 MB)

  std::vector<Owner> owners;
  std::deque<BodyTraits> bodyTraits;  ///< of the bodies among them, which point here
  std::int32_t dynamicGrains = 0, dynamicBodies = 0, kinematicBodies = 0;
  std::int32_t firstSleeper = 0, sleepingGrains = 0;
  std::int32_t dynamicCount() const { return dynamicGrains + dynamicBodies; }
  std::int32_t movingCount() const { return dynamicCount() + kinematicBodies; }
  std::int32_t movingBodies() const { return dynamicBodies + kinematicBodies; }
  std::int32_t sleeperCount() const { return static_cast<std::int32_t>(owners.size()) - firstSleeper; }

  std::int32_t particleCount = 0, dynamicParticles = 0, movingParticles = 0, patchCount = 0;
  double smallestRadius = 0.0, largestRadius = 0.0;
  std::vector<std::int32_t> ownerOfSurface;  ///< surface s has slot and rank particleCount + s
  std::int32_t surfaceCount() const { return static_cast<std::int32_t>(ownerOfSurface.size()); }

  // By slot.
  std::vector<std::int32_t> ownerOfSlot, placeOfSlot, rankOfSlot, patchOfSlot;
  std::vector<std::int32_t> slotOfRank;
  // Place: where an owner's row lies. Those of dynamic owners lie as their slots do, others by number.
  std::vector<std::int32_t> ownerOfPlace, placeOfOwner;
  std::vector<std::int32_t> slotOfPlace, patchOfPlace;  ///< the first ones; one entry more than owners
  /// Whether all that moves are grains of one particle about the centre: owner and particle are one then.
  bool movesOnlySpheres = false;
  /// Before this place owners have no ball of their own about them: it would be their particle.
  std::int32_t firstBall() const { return movesOnlySpheres ? dynamicCount() : 0; }
  // By place: the loops over simple owners read these instead of an Owner.
  std::vector<double> isotropicInverseInertia;  ///< 1/(kg m^2); 0: not the same about all axes
  std::vector<std::uint8_t> isSphere;           ///< a grain of one particle about its centre
  /// Where momenta begin in the state vector; poses come before.
  std::size_t firstMomentum() const { return dynamicCount() * std::size_t{state::kPoseSize}; }
  /// The numbers of the dynamic owner in this place.
  OwnerNumbers<const double> numbersAt(std::int64_t place, const double* y) const {
    return {y + place * state::kPoseSize, y + firstMomentum() + place * state::kMomentaSize};
  }
  OwnerNumbers<double> numbersAt(std::int64_t place, double* y) const {
    return {y + place * state::kPoseSize, y + firstMomentum() + place * state::kMomentaSize};
  }
  /// Its rates, of which those of poses may be lacking: then there is no pose.
  template <class Number>
  OwnerNumbers<Number> ratesAt(std::int64_t place, Number* rate, std::size_t lacking) const {
    return {lacking == 0 ? rate + place * state::kPoseSize : nullptr,
            rate + (firstMomentum() - lacking) + place * state::kMomentaSize};
  }
  template <class Number>
  OwnerNumbers<Number> numbersOf(std::int32_t owner, Number* y) const {
    return numbersAt(placeOfOwner[owner], y);
  }

  /// All kinds that there are; none where they are more than kMostKinds (polydisperse).
  std::vector<ParticleKind> kinds;
  std::vector<std::int32_t> kindOfRank;  ///< in kinds
  ParticleKind kindOf(std::int32_t slot) const {
    const Owner& owner = owners[ownerOfSlot[slot]];
    return slot < particleCount ? particleKind(owner, rankOfSlot[slot] - owner.firstRank)
                                : surfaceKind(owner);
  }
  /// body(kind, owner, isSurface) for every particle and exact surface, by rank.
  template <class Body>
  void forEachKind(Body&& body) const;

  MeetingRules rules;
  std::vector<double> overhang;  ///< by owner: as overhangOf; none where nothing does
  /// How far pieces of the owner reach beyond their particles, at most, m.
  double overhangOf(std::int32_t owner) const { return overhang.empty() ? 0.0 : overhang[owner]; }

  /// Area that particle `local` of a body shows to a contact along N (unit, body frame), m^2.
  static double areaAlong(const Owner& owner, std::int32_t local, const Vector3& N);

  /// What its particles, which are there already, make up for the laws by area.
  static void measureBody(const Owner& owner, BodyTraits& traits);

  /// Numbers ranks, patches and kinds of `owners`, which are in their order. Slots are left to sortPlaces.
  void finish();
  /// Puts places, slots and patches of dynamic owners into the order of cells; centerOf(owner): where it is.
  void sortPlaces(const std::function<Vector3(std::int32_t)>& centerOf);

 private:
  std::int32_t patchCountOf(std::int32_t owner) const;
  void noteBodySurfaces();
  void noteOverhangs();
  void measureRadii();
  void findKinds();
  void assignSlots();
};

template <class Body>
void Layout::forEachKind(Body&& body) const {
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(owners.size()); ++o) {
    const auto count = static_cast<std::int32_t>(owners[o].particles.size());
    for (std::int32_t k = 0; k < count; ++k) body(particleKind(owners[o], k), o, false);
  }
  for (const std::int32_t o : ownerOfSurface) body(surfaceKind(owners[o]), o, true);
}

}  // namespace granular::detail
