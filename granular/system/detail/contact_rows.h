// SPDX-License-Identifier: MIT
// What contacts read and write, one row each: plain data, shared by the stages of an evaluation and the
// kernels that are compiled for several processors.
#pragma once

#include <cstdint>

#include "granular/base/pose.h"

namespace granular::detail {

/// How an owner moves. Rows lie in the order of places (Layout::placeOfOwner).
struct alignas(64) OwnerRow {
  Vector3 velocity = Vector3::Zero();         ///< of the centre of mass, m/s, world
  double inverseMass = 0.0;                   ///< 1/kg; 0 unless dynamic
  Vector3 angularVelocity = Vector3::Zero();  ///< rad/s, world
  std::int32_t material = 0;
  std::int32_t isBody = 0;
};
static_assert(sizeof(OwnerRow) == 64, "one cache line, read once a side of a contact");

/// Where a particle was when the list was made, and how far it may go until the list is old.
struct alignas(32) ListedRow {
  double x, y, z;        ///< m, world
  double marginSquared;  ///< m^2
};

/// An overlapping pair found by findContacts. slot2 may be that of an exact surface.
struct alignas(16) Contact {
  std::int32_t slot1, slot2;
  std::int32_t candidate;    ///< of CandidateBlocks
  std::int32_t surface = 0;  ///< which SurfaceMeeting, where slot2 is that of a surface
};
static_assert(sizeof(Contact) == 16, "written whole");

/// What a contact does: one cache line.
struct alignas(64) ContactForce {
  Vector3 force;       ///< on the owner of particle 1, N, world
  double dissipation;  ///< power turned into heat, W
  Vector3 torque;      ///< of that force about the centre of owner 2, who bears less both, N m, world
  double overlap;      ///< m; 0: the particles do not touch after all
};
static_assert(sizeof(ContactForce) == 64, "read when wrenches are summed");

/// Where a particle meets an exact surface.
struct alignas(64) SurfaceMeeting {
  Vector3 normal;  ///< out of particle 1, world
  double slope;    ///< of the distance
  Vector3 point;   ///< where they meet, m, world
  double overlap;  ///< m
};
/// Three numbers of a contact that are written as four.
struct alignas(32) VectorRow {
  Vector3 vector = Vector3::Zero();
  double damping = 0.0;  ///< beside torques: ContactResultOf::damping
};

/// Wrench about the owner's centre and heat, of a patch or an owner.
struct alignas(64) PatchWrench {
  Vector3 force = Vector3::Zero();   ///< N, world
  double dissipation = 0.0;          ///< W, of contacts in the rows of its own particles
  Vector3 torque = Vector3::Zero();  ///< N m, world
  double damping = 0.0;              ///< N s/m, summed up over all contacts
};
static_assert(sizeof(PatchWrench) == 64, "two registers of four numbers");

/// Contacts [first, last).
struct ContactRange {
  std::int32_t first, last;
};

/// A contact that remembers (eq. 19); its displacement is in the state vector. Numbers, as they are read
/// whole.
struct alignas(32) MemoryEntry {
  double stiffness = 0.0;  ///< of its spring when the last sub-step was accepted, N/m
  double slides = 0.0;     ///< then: 1, else 0
  double energy = 0.0;     ///< in it, then, J
  std::int32_t rank1 = -1, rank2 = -1;
};

/// What a contact remembers once the sub-step is accepted, and what that costs: as ContactMemoryOf.
struct alignas(64) SettledMemory {
  Vector3 displacement = Vector3::Zero();  ///< m
  double stiffness = 0.0;                  ///< N/m
  double loss = 0.0;                       ///< J
  double heating = 0.0;                    ///< W
  double slides = 0.0;                     ///< 1, else 0
  double touches = 0.0;                    ///< 1; 0: it is none after all
};

/// Of some contacts: largest urgency and overlap (in smaller radii), and how many push.
struct Extremes {
  double urgency = 0.0, overlap = 0.0;
  std::int32_t contacts = 0, pushing = 0;
};

}  // namespace granular::detail
