// SPDX-License-Identifier: MIT
// What a user says about time integration (Bell 2005, sec. 3.4).
#pragma once

#include <cstdint>

namespace granular {

enum class Stepper : std::uint8_t {
  Rkf45,  ///< Runge-Kutta-Fehlberg 4(5), six evaluations a trial: the paper's, the default
  /// Leapfrog with forces at predicted velocities, one evaluation a trial. Under error control what its
  /// estimate says is taken off again: third order. With fixedSubStep second order, and energy has no trend.
  Leapfrog,
  Verlet,             ///< velocity Verlet as other DEM codes step, one evaluation; no error control
  SemiImplicitEuler,  ///< velocities, then positions with the new ones, one evaluation; no error control
  BogackiShampine,    ///< Runge-Kutta 3(2), three evaluations a trial
};

/// What forces of contacts are worked out in. States, differences of positions and velocities, sums of forces
/// and laws by area are in double precision always.
enum class ContactPrecision : std::uint8_t {
  Double,
  /// Laws in single precision, twice as many contacts at a time: forces are off by some 1e-6 of themselves,
  /// the same on both sides of a contact. For tolerances of 1e-5 and above, and for particles between a
  /// micrometre and a kilometre.
  Mixed,
};

struct IntegratorDef {
  Stepper stepper = Stepper::Rkf45;

  /// > 0: every sub-step is this long, s (a little less, so that a whole number of them fills the step),
  /// without error control, whatever meets in it: for comparisons, and for energy without a trend. 0:
  /// adaptive; steppers without error control are then bound by contactTimeFraction alone.
  double fixedSubStep = 0.0;

  /// Local error allowed in one sub-step, as a fraction of the smallest particle radius: of grains the root
  /// mean square, of bodies the largest, and no single grain's beyond a hundred times as much. Position error
  /// counts as it is; a velocity error counts as the way it makes in one contact time, a rotation as the way
  /// it moves the outermost particle. Normal range 1e-6 ... 1e-2.
  double tolerance = 1e-4;

  /// A sub-step in which anything touches is at most this fraction of the shortest contact time (pairs at
  /// their present speed and overlap); with other steppers that times how much damping they bear, over
  /// RKF45's 3: a third of it for Leapfrog, two thirds for Verlet and SemiImplicitEuler. Above 0.3 RKF45 may
  /// overlook a whole impact: its second stage has weight zero.
  double contactTimeFraction = 0.1;

  /// In small scenes also: a sub-step in which a contact begins, lets go or ends is at most this fraction of
  /// its contact time. Forces have corners there, which decide how exactly a restitution asked for is
  /// obtained.
  double eventFraction = 0.004;
  /// Largest number of contacts for which eventFraction holds; 0: never. In large scenes something begins in
  /// every sub-step, and resolving it all costs ten times the work for errors that average out.
  int eventContacts = 32;

  /// Shortest sub-step, s; reaching it is reported (StepFlag::SmallestSubStepReached), not looped on.
  double smallestSubStep = 1e-10;

  ContactPrecision precision = ContactPrecision::Double;

  /// Whether orientations of grains that are single spheres follow their spin, which only pictures can tell.
  /// Without, where nothing else moves, steppers of one evaluation leave orientations as they are and need
  /// not work them out.
  bool turnSpheres = true;

  /// Trials in one step() before the rest of it is done at a tolerance a thousand times looser, and with that
  /// many again at whatever comes (StepFlag::TrialLimitReached). Drops no time: a WorkBudget does.
  int trialLimit = 1000000;
};

}  // namespace granular
