// SPDX-License-Identifier: MIT
// A system as input for LAMMPS (https://www.lammps.org): a data file, a file of rigid bodies and an input
// script that goes on from the present state under the same laws. For scenes too big for one machine, and as
// a check of both codes against each other.
//
//   grains of one particle    atoms of style sphere             fix nve/sphere
//   other grains, dynamic bodies   rigid clumps with our mass, centre and inertia   fix rigid/small, infile
//   static covered bodies     frozen atoms                      fix freeze
//   kinematic covered bodies  frozen atoms that move on evenly  fix move
//   half-spaces               fix wall/gran, or fix wall/gran/region where no axis is along the normal
//   exact spheres             atoms of that size
//   laws                      pair_style granular, a line of coefficients a pair of atom types
//
// Laws depend on materials and, some of them, on sizes; an atom type is a material and a class of sizes. What
// LAMMPS cannot express is told in LammpsReport::notes, a line each. Written for, and tested with, LAMMPS of
// 29 Sep 2021 (Debian 12's package `lammps`).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "granular/system/granular_system.h"

namespace granular {

enum class LammpsStyle : std::uint8_t {
  Granular,  ///< pair_style granular: every law that LAMMPS has
  /// pair_style gran/hertz/history, older and faster: Hertz with viscoelastic damping, under eq. 19 or
  /// without friction, one set of coefficients for all (those of the middle sizes).
  HertzHistory,
};

struct LammpsDef {
  double timeStep = 0.0;       ///< s; 0: lammpsTimeStep()
  std::int64_t steps = 0;      ///< that the script runs, >= 0
  std::int64_t dumpEvery = 0;  ///< steps from one state in particles.dump to the next; 0: no such file
  double skin = 0.0;           ///< of LAMMPS's neighbour lists, m; 0: 0.3 of the smallest radius
  /// Most atom types, in [1, 24]: LAMMPS has 32 groups in all. Where there are more sizes, and the
  /// coefficients depend on them, neighbouring sizes share those of the middle one; notes say how far off
  /// that is.
  int largestTypeCount = 20;
  LammpsStyle style = LammpsStyle::Granular;
};

struct LammpsReport {
  std::vector<std::filesystem::path> files;
  /// What LAMMPS does otherwise than we, or does not do; one line each.
  std::vector<std::string> notes;
  std::int64_t atoms = 0;
  std::int64_t rigidBodies = 0;
  std::int64_t frozenAtoms = 0;
  std::int64_t walls = 0;
  int types = 0;
  double timeStep = 0.0;  ///< s
  /// Largest relative error of a coefficient, of particles that share those of others.
  double coefficientError = 0.0;
};

/// Writes in.granular, particles.data and, if there are rigid bodies, bodies.rigid into the folder, which is
/// made if it is not there; the script is to be run in it: `lmp -in in.granular`. Atoms are numbered from 1
/// in the order of GranularSystem::readParticles; exact spheres come after them.
/// Throws std::invalid_argument for a value out of range, a system without moving particles, or a style that
/// does not have the system's laws; std::runtime_error if a file cannot be written.
LammpsReport writeLammps(const GranularSystem& system, const std::filesystem::path& folder,
                         const LammpsDef& def = {});

/// The time step that is chosen where none is given, s: a fiftieth of the shortest contact time at
/// restitutionSpeed.
double lammpsTimeStep(const GranularSystem& system);

}  // namespace granular
