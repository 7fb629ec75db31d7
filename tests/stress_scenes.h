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
/// Balls that hold one another by friction alone, whose springs nothing damps: energy that came from nowhere
/// in 0.4 s, over m g R of all.
Outcome crystal(Stepper stepper);
/// Far too long fixed sub-steps: a bed of a stiff material explodes. Measured: whether it says so.
Outcome tooLongSteps();

}  // namespace granular::stress
