// SPDX-License-Identifier: MIT
// What a user says about time integration (Bell 2005, sec. 3.4).
#pragma once

#include <cstdint>

namespace granular {

enum class Stepper : std::uint8_t {
  Rkf45,  ///< adaptive Runge-Kutta-Fehlberg 4(5), six evaluations a trial: the paper's, the default
};

struct IntegratorDef {
  Stepper stepper = Stepper::Rkf45;

  /// Local error allowed in one sub-step, as a fraction of the smallest particle radius. Position error
  /// counts as it is; a velocity error counts as the way it makes in one contact time, a rotation as the way
  /// it moves the outermost particle. Normal range 1e-6 ... 1e-2.
  double tolerance = 1e-4;

  /// A sub-step in which anything touches is at most this fraction of the shortest contact time (pairs at
  /// their present speed and overlap). Above 0.3 RKF45 may overlook a whole impact: its second stage has
  /// weight zero.
  double contactTimeFraction = 0.1;

  /// Shortest sub-step, s; reaching it is reported (StepFlag::SmallestSubStepReached), not looped on.
  double smallestSubStep = 1e-10;

  /// Trials in one step() before the rest of it is done at a step bounded by stability alone, not by the
  /// tolerance (StepFlag::TrialLimitReached). Time is never dropped.
  int trialLimit = 100000;
};

}  // namespace granular
