// SPDX-License-Identifier: MIT
// Floaters: sample points that start at random on a surface and push one another along it until they are
// evenly spaced (Bell 2005, sec. 3.3, after Witkin & Heckbert 1994).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "granular/base/random.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// Random start: in each triangle of area A floor(D A / (pi r^2)) points, plus one more with probability
/// equal to the remainder. D is `density`, the number of particles per disc area of one; r `particleRadius`,
/// m.
std::vector<Vector3> seedFloaters(const TriangleMesh& surface, double particleRadius, double density,
                                  const Random& random);

/// Where a floater is relative to the surface it must end on.
struct SurfaceSample {
  double value = 0.0;                 ///< signed distance to that surface, m, positive outside
  Vector3 normal = Vector3::UnitX();  ///< unit, pointing outside
};

/// The surface that floater i must end on, seen from p. Called from several threads at once, never twice for
/// one i.
using FloaterSurface = std::function<SurfaceSample(std::int32_t i, const Vector3& p)>;

struct FloaterDef {
  double spacing = 0.0;      ///< wanted distance between neighbours, m, > 0; sets the reach of the repulsion
  double convergence = 0.0;  ///< m, > 0: done when the root mean square move of an iteration is below this
  int maxIterations = 500;   ///< stop here in any case
  std::int64_t fixed = 0;    ///< the first so many stay where they are, and push the others
  int threads = 1;           ///< any number gives the same bits
};

struct FloaterReport {
  int iterations = 0;
  double meanMove = 0.0;   ///< root mean square move in the last iteration, m
  bool converged = false;  ///< meanMove fell below FloaterDef::convergence
};

/// Moves the floaters until they have converged. Velocity of one at P: -phi(P) N, back to the surface, plus
/// sum K(|P - Pi|) (P - Pi) / |P - Pi| over its neighbours (Bell 2005, eq. 20), K(d) = (1 - d/R)^2 up to R, 0
/// beyond.
/// Differs from the paper: of the repulsion only the part along the surface counts, so that the pressure of
/// floaters across a curved surface does not lift it off; a floater keeps part of its last move, which evens
/// out large patches sooner, and takes smaller steps where it would swing to and fro, so that it comes to
/// rest at sharp edges too. Tests: SurfaceFloaters.EndOnTheZeroSet,
/// SurfaceFloaters.ComeToRestOnABoxWithSharpEdges.
FloaterReport relaxFloaters(std::span<Vector3> positions, const FloaterSurface& surface,
                            const FloaterDef& def);

}  // namespace granular
