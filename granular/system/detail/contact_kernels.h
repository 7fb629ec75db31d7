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
  std::int32_t dynamicParticles = 0;       ///< have rows of candidates
  const ParticleRow* particles = nullptr;  ///< [slot]
  const OwnerRow* owners = nullptr;        ///< [place]
  /// [place - firstBall] centre and reach. Not of what moves where that is spheres only: their particles are
  /// these balls.
  const ParticleRow* balls = nullptr;
  std::int32_t firstBall = 0;  ///< 0 unless movesOnlySpheres
  bool movesOnlySpheres = false;
  const std::int32_t* placeOfSlot = nullptr;     ///< place of the owner
  const double* surfaceInverseRadius = nullptr;  ///< [surface], 1/m; 0: no sphere, counts as flat
  // The candidate list.
  const std::int32_t* rowStart = nullptr;
  const std::int32_t* partner = nullptr;  ///< [candidate]
  // To be filled by RowKernel; read by the others.
  Contact* contacts = nullptr;
  std::int32_t* contactOfCandidate = nullptr;  ///< -1: apart
  ContactRange* contactsOfRow = nullptr;
  ContactForce* forces = nullptr;  ///< [contact], to be filled by ForceKernel
  // Laws with memory only.
  const std::int32_t* memoryOfCandidate = nullptr;  ///< -1: none
  const MemoryEntry* memory = nullptr;
  const double* displacements = nullptr;   ///< three numbers an entry, m
  double* displacementRates = nullptr;     ///< to be filled
  SettledMemory* contactMemory = nullptr;  ///< [contact], to be filled
  Moment at;
  // Patches.
  const std::int32_t* placeOfPatch = nullptr;
  const std::int32_t* slotOfPatch = nullptr;     ///< one entry more than patches
  const std::int32_t* incidenceStart = nullptr;  ///< as CandidateIncidence
  const std::int32_t* incidenceEntries = nullptr;
};

/// Contacts between particles of rows [row, end), numbered from n on, which is moved behind them. Comes back
/// behind the first row that has candidates on surfaces, which are left out, or at the end: returns that row.
using RowKernel = std::int32_t (*)(const ContactArrays& arrays, std::int32_t row, std::int32_t end,
                                   std::int32_t& n);

/// Room for four numbers of a contact, in single or double precision: what the laws want to know of it,
/// brought together from its particles and their owners.
struct alignas(32) MeetingRow {
  static constexpr int kMost = 6;  ///< a contact
  std::byte numbers[32];
};

/// Fills `to`, MeetingRow::kMost a contact at most, for the contacts of rows [begin, end).
using GatherKernel = void (*)(const ContactArrays& arrays, std::int32_t begin, std::int32_t end,
                              MeetingRow* to);

/// Some contacts under one rule.
struct ContactRun {
  const MaterialPair* pair;
  bool ofBodies;
  /// Round particles on exact surfaces: where they meet is in `forces` already, as surfaceMeeting() leaves
  /// it. Else both are round particles.
  bool onSurfaces;
  /// Behind its end the last is said again until there are a multiple of kContactsPerPack.
  std::span<const std::int32_t> which;
  const MeetingRow* meetings;  ///< from GatherKernel
  std::int32_t firstMeeting;   ///< of this contact is the first
};
/// The most that a kernel works on at a time; a power of two.
inline constexpr std::int32_t kContactsPerPack = 16;

/// The forces of a run.
using ForceKernel = void (*)(const ContactArrays& arrays, const ContactRun& run, Extremes& extremes);

/// What touches patches [begin, end), to `to`: contacts in their own rows, then in the rows of others.
using WrenchKernel = void (*)(const ContactArrays& arrays, std::int32_t begin, std::int32_t end,
                              PatchWrench* to);

/// What a drift reads and writes: poses and momenta of a state by place, and the rates of these momenta.
struct DriftArrays {
  Drift drift;
  const double *poses, *momenta, *rates;
  double *posesTo, *momentaTo;
  const double* inverseInertia;  ///< [place] as Layout::isotropicInverseInertia
};

/// Drifts owners in places [begin, end). Lists in `left` the places of those that turn as no sphere does, or
/// too far: they have to be done one by one. Returns how many these are.
using DriftKernel = std::int32_t (*)(const DriftArrays& arrays, std::int32_t begin, std::int32_t end,
                                     std::int32_t* left);

struct ForceKernels {
  GatherKernel gather;
  /// By normal and shear law; null for laws by area.
  std::array<std::array<ForceKernel, ShearLaws::kCount>, NormalLaws::kCount> forces;
};

struct ContactKernels {
  const char* processor;  ///< what it is for
  DriftKernel drift;
  RowKernel findContacts;
  WrenchKernel sumWrenches;
  const ForceKernels *forces, *mixedForces;  ///< ContactPrecision::Double, Mixed
};

/// The best for the processor at hand; environment variable GRANULAR_PROCESSOR ("baseline", "avx2") asks for
/// less.
const ContactKernels& contactKernels();
/// All that this processor can run, the best last.
std::span<const ContactKernels* const> availableContactKernels();

}  // namespace granular::detail
