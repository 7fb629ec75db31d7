// SPDX-License-Identifier: MIT
// The scenes of the stress matrix: each builds one, runs it and says what it measured.
#pragma once

#include "granular/contact/material.h"
#include "granular/dynamics/integrator.h"
#include "tests/stress_cases.h"

namespace granular::stress {

/// Largest swing of a ball on an undamped linear spring, in its first swing, after 2000 sub-steps of so many
/// over its frequency.
Outcome swing(Stepper stepper, double frequencyTimesStep);
/// Largest speed, over that of the start, of twenty balls in a row between walls, on undamped linear springs,
/// in 300 sub-steps of so many times what the packing bound allows by leapfrog: 2/w with w^2 the largest over
/// the balls of 2 sum over contacts [kn/m].
Outcome row(Stepper stepper, double boundsPerStep);
/// Largest spin, over that of the start, of 4 x 4 x 4 balls in a cubic lattice between walls, on undamped
/// linear springs, of friction too (law 19), in 3000 sub-steps of this length times w, w^2 the largest over
/// the balls of 2 sum over contacts [kt R^2 (1 - (N a)^2)/I] about an axis a, which all turning alike attain.
Outcome lattice(Stepper stepper, double frequencyTimesStep);
/// w h up to which the amplification matrix of leapfrog on a spring of friction has no eigenvalue beyond 1.
double largestFrequencyByLeapfrog();
/// Largest speed with which a ball slides on a plane under law 18, over that of the start, in 300 sub-steps
/// of this length times the rate kt (1/m + R^2/I).
Outcome slide(Stepper stepper, double rateTimesStep);
/// Longest sub-step that the stepper takes by itself while a ball slides on a plane under law 18, times the
/// rate kt (1/m + R^2/I), which is a thousand over the contact time.
Outcome slideOfItself(Stepper stepper);
/// Growth of the swing in 2000 steps of RKF45 on an undamped spring, over |P(i w0 dt)|^2000, its stability
/// polynomial.
Outcome growthByRkf45(double frequencyTimesStep);
/// x at which RKF45's stability polynomial of -x leaves [-1, 1].
double largestRateByRkf45();
/// Young's modulus that advice gives for impacts at this speed, in place of 10 MPa, Pa.
double advisedModulus(double speed);
/// Rebound speed over impact speed of a ball on the floor; restitution 0.5 at that speed.
Outcome rebound(double youngsModulus, double speed);
/// How far above where it was dropped a ball rises at most, in radii.
Outcome riseAfterDrop(Stepper stepper, double tolerance);
/// Way in radii that a ball on the floor makes in a million sub-steps at rest, law 19.
Outcome millionSteps(Stepper stepper);
/// Height in radii at which a ball is 0.2 s after it was dropped from ten, with frames this long.
Outcome bounceAtFrames(double frame);
/// Speed of a grain hit at 1 m/s by a body a million times as heavy, over 1 + e.
Outcome heavyBody();
/// A ball `ratio` times as large, or as heavy, laid on a bed: kinetic energy at the end over m g R of the
/// ball.
Outcome unequal(double radiusRatio, double densityRatio, double youngsModulus);
/// Kinetic energy after two balls that overlap by `overlap` diameters have been let go, over the elastic
/// energy that the start holds.
Outcome letGo(double overlap);
/// A cloud that falls together without outside forces; measured: momentum drift.
Outcome cloud(Stepper stepper);
/// How many of 49 balls shot at 100 m/s cross a covering of particles two radii apart.
Outcome shots(double youngsModulus);
/// Speed of a ball hit by a kinematic wall, over (1 + e) times the wall's.
Outcome movingWall(double speed, double youngsModulus);
/// Of a settled bed, over m g R of all grains: kinetic energy at the end, or energy that came from nowhere in
/// the last half of the time, whichever is more.
Outcome bedAtRest(ShearLaw law, Stepper stepper, double youngsModulus);
/// The same in less time, law 18 with a viscosity a hundred times the one that holds where none is given.
Outcome bedOfHugeViscosity(Stepper stepper);
/// Balls that hold one another by friction alone, whose springs nothing damps: energy that came from nowhere
/// in 0.4 s, over m g R of all.
Outcome crystal(Stepper stepper);
/// Far too long fixed sub-steps: a bed of a stiff material explodes. Measured: whether it says so.
Outcome tooLongSteps();

}  // namespace granular::stress
