// SPDX-License-Identifier: MIT
// Spheres on a shaken grid that touch their neighbours, in a closed box: packed at once, at any size, where
// settling a pile would take hours.
#pragma once

#include <cstdint>

#include "granular/system/granular_system.h"

namespace granular_bench {

struct LatticeDef {
  std::int64_t spheres = 10'000;
  double speed = 0.0;  ///< m/s, of each sphere in a direction of its own
  granular::IntegratorDef integrator = {.stepper = granular::Stepper::Verlet, .fixedSubStep = 4e-5};
  granular::ShearLaw shear = granular::ShearLaw::RegularisedCoulomb;
  int threads = 1;
};

struct LatticeScene {
  granular::GranularSystem system;
  granular::MaterialId material;
};

/// R = 2.5 mm within 5 %, 2500 kg/m^3, E = 10 MPa, mu = 0.5, e = 0.5; about three contacts a sphere.
LatticeScene makeLattice(const LatticeDef& def);

/// Resident memory of this process, now and at most since forgetPeak(), bytes (Linux).
std::int64_t residentBytes();
std::int64_t peakBytes();
void forgetPeak();

}  // namespace granular_bench
