// SPDX-License-Identifier: MIT
// One impact integrated independently of the system under test: classical Runge-Kutta with many thousand
// equal steps on the equations of a ball that meets a plane (or, in one dimension, of any two round things).
#pragma once

#include <functional>

namespace granular::verification {

/// Normal force, N, > 0 pushes apart, before any clamp: of overlap (m) and overlap rate (m/s).
using NormalForce = std::function<double(double xi, double xiDot)>;

/// kr xi^beta + kd xi^alpha xi' (Bell 2005, eqs. 6-7).
NormalForce powerLaw(double alpha, double beta, double kr, double kd);

struct ReferenceImpact {
  double restitution = 0.0;
  double release = 0.0;         ///< when the force ends, s
  double largestOverlap = 0.0;  ///< m
  double impulse = 0.0;         ///< integral of fn, N s
  double meanOverlap = 0.0;     ///< integral of fn xi over integral of fn, m
};

/// Head-on impact of the reduced mass `mass` (kg) at `speed` (m/s). Not attraction: the contact ends when the
/// force has fallen to zero. timeScale: about the contact time, s.
ReferenceImpact referenceImpact(const NormalForce& force, double mass, double speed, double timeScale,
                                bool attraction = false);

/// Restitution of x'' + D x^alpha x' + x^beta = 0, force clamped at no attraction, from unit speed.
double referenceRestitution(double alpha, double beta, double D, bool attraction = false);

/// The ball above the plane, and friction by a virtual spring (Bell 2005, eq. 19), kt = shearStiffness
/// xi^stiffnessPower, no dashpot. While the contact is pressed deeper the spring keeps its force, not its
/// displacement: else it would hand back more energy than it took (Elata & Berryman 1996).
struct ObliqueDef {
  NormalForce normal = {};
  double shearStiffness = 0.0;  ///< kt over xi^stiffnessPower, N/m^(1 + stiffnessPower)
  double stiffnessPower = 0.0;  ///< 1/2 after Mindlin, 0 for a constant stiffness
  double friction = 0.0;
  double mass = 0.0, radius = 0.0;                              ///< of the ball, kg, m
  double normalSpeed = 0.0, tangentialSpeed = 0.0, spin = 0.0;  ///< m/s, m/s, rad/s: surface speed v + w R
  double timeScale = 0.0;                                       ///< about the contact time, s
};
struct ObliqueResult {
  double normalSpeed = 0.0, tangentialSpeed = 0.0, spin = 0.0;  ///< afterwards
};
ObliqueResult referenceOblique(const ObliqueDef& def);

}  // namespace granular::verification
