// SPDX-License-Identifier: MIT
// The loops that an evaluation spends its time in, in packs: which candidates overlap, and what contacts
// between round particles do, and what that adds up to. They are compiled for several processors
// (contact_kernels_*.cpp), and the best that this one has is taken when the program runs. Every lane does
// what a single number would: the same bits on every processor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "granular/contact/contact_kernel.h"
#include "granular/contact/law_list.h"
#include "granular/contact/pair_law.h"
#include "granular/dynamics/equations.h"
#include "granular/search/candidate_list.h"
#include "granular/system/detail/contact_rows.h"

namespace granular::detail {

/// Where the numbers are.
struct ContactArrays {
  std::int32_t particleCount = 0;
  std::int32_t dynamicParticles = 0;
  const ParticleRow* particles = nullptr;  ///< [slot]
  const OwnerRow* owners = nullptr;        ///< [place]
  /// [place - firstBall] centre and reach. Not of what moves where that is spheres only: their particles are
  /// these balls.
  const ParticleRow* balls = nullptr;
  std::int32_t firstBall = 0;  ///< 0 unless movesOnlySpheres
  bool movesOnlySpheres = false;
  const std::int32_t* placeOfSlot = nullptr;     ///< place of the owner
  const double* surfaceInverseRadius = nullptr;  ///< [surface], 1/m; 0: no sphere, counts as flat
  const std::int32_t* patchOfSlot = nullptr;     ///< -1: nobody asks what it bears
  /// [candidate of CandidateBlocks] what its laws take from sizes and masses, in the precision of the forces.
  void* lawRows = nullptr;
  // Laws with memory only.
  const std::int32_t* indexOfCandidate = nullptr;   ///< in the list
  const std::int32_t* memoryOfCandidate = nullptr;  ///< [candidate of the list] -1: none
  const MemoryEntry* memory = nullptr;
  const double* displacements = nullptr;  ///< three numbers an entry, m
  double* displacementRates = nullptr;    ///< to be filled
  Moment at;
};

/// Candidates of a block, as CandidateBlocks.
struct CandidateSpan {
  const std::int32_t *row, *partner;  ///< slots of particles 1 and 2
};

/// The most that a kernel works on at a time; a power of two.
inline constexpr std::int32_t kContactsPerPack = 32;

/// Candidates [begin, end) that overlap become contacts behind the n that are there. Stops at the first one
/// on an exact surface, or at the end: returns that one. There must be room for kContactsPerPack contacts
/// more than there are.
using FindKernel = std::int32_t (*)(const ContactArrays& arrays, const CandidateSpan& candidates,
                                    std::int32_t begin, std::int32_t end, Contact* contacts, std::int32_t& n);

/// Contacts under one rule, some of a block. What is known of them, and what they do, lies in the order in
/// which `which` names them.
struct ContactRun {
  const MaterialPair* pair = nullptr;
  bool ofBodies = false;
  bool onSurfaces = false;  ///< of round particles on exact surfaces; else both are round particles
  /// Slots of the block's own rows. Contacts in others are told of by another block too: they are not
  /// counted, and nothing is written of them but forces.
  std::int32_t firstSlot = 0, endSlot = 0;
  /// Of the block. Behind its end some are said again, or others that are there, until there are a multiple
  /// of kContactsPerPack.
  std::span<const std::int32_t> which;
  bool isOwn(const Contact& contact) const {
    return (contact.slot1 >= firstSlot) & (contact.slot1 < endSlot);
  }
  // Of the block.
  const Contact* contacts = nullptr;
  const SurfaceMeeting* surfaces = nullptr;  ///< [Contact::surface]
  SettledMemory* memory = nullptr;           ///< to be filled under laws with memory
  VectorRow* nextRates =
      nullptr;  ///< as ContactMemoryOf::nextRate, m/s; to be filled with Moment::memoryRates
  // Of the run.
  ContactForce* forces = nullptr;  ///< to be filled by ForceKernel
  VectorRow* torques = nullptr;    ///< of forces about the centres of owners 1, N m, world; to be filled
};

/// The forces of a run.
using ForceKernel = void (*)(const ContactArrays& arrays, const ContactRun& run, Extremes& extremes);

/// Contacts side by side, few enough to stay in the nearest cache, and where what they do is found: in forces
/// those of a block on surfaces come first, then the others as they lie in runs; so in torques, but that
/// there `shift` of the others are lacking.
struct ContactChunk {
  std::int32_t count = 0;
  const Contact* contacts = nullptr;
  const std::int32_t* position = nullptr;  ///< in forces
  const ContactForce* forces = nullptr;
  const VectorRow* torques = nullptr;
  std::int32_t surfaceCount = 0, shift = 0;
};

/// Adds what contacts do to patches [firstPatch, firstPatch + patchCount), one after the other from `sums`
/// on. Behind them is room for one more, of what goes elsewhere.
using AddKernel = void (*)(const ContactArrays& arrays, const ContactChunk& chunk, std::int32_t firstPatch,
                           std::int32_t patchCount, PatchWrench* sums);

/// What a drift reads and writes: poses and momenta of a state by place, and the rates of these momenta.
struct DriftArrays {
  Drift drift;
  const double *poses, *momenta, *rates;
  double *posesTo, *momentaTo;
  const double* inverseInertia;  ///< [place] as Layout::isotropicInverseInertia
  bool turns;                    ///< else orientations stay
};

/// Drifts owners in places [begin, end). Lists in `left` the places of those that turn as no sphere does, or
/// too far: they have to be done one by one. Returns how many these are.
using DriftKernel = std::int32_t (*)(const DriftArrays& arrays, std::int32_t begin, std::int32_t end,
                                     std::int32_t* left);

/// What placing single spheres reads and writes, all by place.
struct PlaceArrays {
  const double *poses, *momenta;
  const double* inverseInertia;
  ParticleRow* particles;
  OwnerRow* owners;
  const ListedRow* listed;  ///< null: nothing to compare with
};
/// Of some owners: how much farther than its margin one has gone since the list was made, squares, m^2, 0 if
/// none has; and how fast any point of them may be, m/s.
struct PlacedExtremes {
  double beyond = 0.0, speed = 0.0;
};

/// Rows of single spheres in places [begin, end) that are their own particles.
using PlaceKernel = PlacedExtremes (*)(const PlaceArrays& arrays, std::int32_t begin, std::int32_t end);

/// Rates of the momenta of grains in places [begin, end), patches of the same numbers, from what contacts do
/// to them, one after the other from `wrench` on, and gravity, m/s^2; and how fast their velocities are
/// damped, 1/s, by place.
using AccelerationKernel = void (*)(const OwnerRow* owners, const PatchWrench* wrench, const Vector3& gravity,
                                    std::int32_t begin, std::int32_t end, double* rates, double* damping);

/// What errors of momenta mean for single spheres in places [begin, end): how far the fastest point of their
/// surface goes wrong in so many seconds, m. inverseInertia, particles: by place; ways: from `begin` on.
using ErrorKernel = void (*)(const double* errors, const double* inverseInertia, const ParticleRow* particles,
                             double seconds, std::int32_t begin, std::int32_t end, double* ways);

/// Positions move on by so many seconds of three rates of velocities each; by place.
struct CarryArrays {
  std::array<double, 3> weights;
  std::array<const double*, 3> rates;
  double* poses;
};
using CarryKernel = void (*)(const CarryArrays& arrays, std::int32_t begin, std::int32_t end);

/// Fills ContactArrays::lawRows of the candidates in a run.
using LawKernel = void (*)(const ContactArrays& arrays, const ContactRun& run);

struct ForceKernels {
  /// By normal and shear law; null for laws by area.
  template <class Kernel>
  using ByLaws = std::array<std::array<Kernel, ShearLaws::kCount>, NormalLaws::kCount>;
  std::size_t lawRowSize;  ///< bytes
  ByLaws<LawKernel> laws;
  ByLaws<ForceKernel> forces;
};

struct ContactKernels {
  const char* processor;  ///< what it is for
  FindNear findNear;
  DriftKernel drift;
  CarryKernel carry;
  PlaceKernel placeSpheres;
  FindKernel findContacts;
  AddKernel addWrenches;
  AccelerationKernel accelerateGrains;
  ErrorKernel errorsOfSpheres;
  const ForceKernels *forces, *mixedForces;  ///< ContactPrecision::Double, Mixed
};

/// The best for the processor at hand; environment variable GRANULAR_PROCESSOR ("baseline", "avx2", "avx512")
/// asks for less.
const ContactKernels& contactKernels();
/// All that this processor can run, the best last.
std::span<const ContactKernels* const> availableContactKernels();

}  // namespace granular::detail
