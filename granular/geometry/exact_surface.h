// SPDX-License-Identifier: MIT
// Surfaces that particles meet exactly instead of through surface particles: smooth and cheap.
// Differs from the paper: there, everything a particle can touch is a particle. Scenes of the paper use
// coverings.
#pragma once

#include <variant>

namespace granular {

/// Solid below the plane y = 0 of the body frame, of no mass properties: static and kinematic bodies only.
struct HalfSpace {};

/// Solid ball about the origin of the body frame.
struct ExactSphere {
  double radius = 0.0;  ///< m, > 0
};

/// Met by particles, never by other exact surfaces.
using ExactSurface = std::variant<HalfSpace, ExactSphere>;

}  // namespace granular
