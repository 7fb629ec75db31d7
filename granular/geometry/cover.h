// SPDX-License-Identifier: MIT
// Covers the surface of a closed mesh with round particles (Bell 2005, sec. 3.3): distance band, iso-surface
// at the offset, random seeds, floaters; then what the paper leaves open: every floater is put exactly on the
// offset surface, the largest hole is measured, and holes too large are filled and relaxed again.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "granular/geometry/covering.h"
#include "granular/geometry/mesh_repair.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular {

/// How to cover a mesh. A hole is measured by the largest sphere centred on the surface of the particles'
/// centres that touches no particle.
struct CoverDef {
  double particleRadius = 0.0;  ///< r, m, > 0

  /// Distance of the particles' centres from the mesh, m, negative inside; at most 1000 r either way. Default
  /// -r: the envelope of the particles touches the mesh surface from within. 0: centres on it. +r: wholly
  /// outside. Inside, a part thinner than twice the depth has no such surface; there a particle sits at 0.9
  /// of half the local thickness, so its offset goes towards 0 and it stands out of the part on both sides.
  std::optional<double> offset = {};

  /// D, particles per disc area pi r^2 (Bell 2005, sec. 3.3), > 0. Default: just enough for largestHole.
  /// Three neighbours of an even layer leave a hole of radius a/sqrt(3) - r, a their distance, and D = 2 pi
  /// r^2 / (sqrt(3) a^2); relaxed layers are not quite even, their largest hole is as if a were kUnevenness
  /// = 1.25 times as long. For grains of radius r this gives D = 0.84.
  std::optional<double> density = {};

  /// Along edges whose faces' normals differ by more than this, and at their ends, particles are placed first
  /// and stay, so that the covering keeps edges and corners; degrees, in (0, 180]. 180: none.
  double sharpEdgeDegrees = 40.0;

  /// Radius of further, smaller particles along sharp convex edges, m: the envelope's error
  /// there falls with it. None unless asked for. Contact laws and searches like similar sizes: at least a
  /// third of particleRadius.
  std::optional<double> edgeParticleRadius = {};

  /// Covers a sheet: the mesh, which may be open, is given this thickness (makeSheet), m, > 0.
  std::optional<double> sheetThickness = {};

  double smallestGrainRadius = 0.0;  ///< m; of the grains that must not pass. 0: r

  /// Bound on the radius of a hole, m, > 0. Default: half the smallest grain's radius. A grain could pass
  /// unhindered only where a hole is as large as itself; with half, it would have to overlap every particle
  /// round the hole by half its radius, which is far more than contact forces allow it in any working scene.
  std::optional<double> largestHole = {};

  std::uint64_t seed = 1;
  double convergence = 0.01;  ///< of r: done when the root mean square move of the floaters is below this
  int maxIterations = 500;    ///< of the floaters, in each round
  int maxFillRounds = 2;      ///< of filling holes and relaxing again
  std::int64_t maxParticles = 2'000'000;  ///< more than this is refused before anything is built
  int threads = 1;                        ///< any number gives the same bits
};

/// Factor by which the largest hole of a relaxed layer is wider than that of an even one (CoverDef::density).
inline constexpr double kUnevenness = 1.25;

/// What came of it. Lengths in m.
struct CoverReport {
  std::int64_t particleCount = 0;
  double particleRadius = 0.0;
  double smallestGrainRadius = 0.0;
  double density = 0.0;        ///< D that was used for the seeds
  double spacingMin = 0.0;     ///< distance of a particle to its nearest neighbour: smallest,
  double spacingMedian = 0.0;  ///< median,
  double spacingMax = 0.0;     ///< and largest
  double largestHole = 0.0;    ///< radius of the largest hole found on samples 0.3 r apart
  double holeBound = 0.0;      ///< radius that was allowed
  bool holesClosed = false;    ///< largestHole <= holeBound
  double envelopeMean = 0.0;   ///< distance of the mesh surface from the nearest particle's surface: mean
  double envelopeMax = 0.0;    ///< and largest; edges and corners are rounded off by a covering from within
  double edgeLength = 0.0;     ///< of sharp convex edges of the mesh
  double edgeMean = 0.0;       ///< distance of these edges from the nearest particle's surface: mean
  double edgeMax = 0.0;        ///< and largest
  std::int64_t edgeParticles = 0;  ///< particles placed along sharp edges, of either radius
  int iterations = 0;              ///< of the floaters, all rounds together
  int fillRounds = 0;
  std::int64_t filledParticles = 0;  ///< floaters added to close holes
  std::int64_t thinParticles = 0;    ///< particles in parts too thin for the offset
  bool converged = false;            ///< the floaters, in the last round
  MeshRepair repair = {};            ///< what was done to the mesh before

  std::string text() const;
};

/// Covers the surface of a solid. Positions are in the frame of the mesh; for a body, hand in
/// seenFrom(massProperties.principalFrame, mesh). The same def gives the same bits on any number of threads.
/// A mesh that is not quite the surface of a solid is repaired (repairMesh). Throws std::invalid_argument if
/// a field is out of range, the mesh cannot be the surface of a solid, or the covering would need more than
/// maxParticles.
Covering coverMesh(const TriangleMesh& mesh, const CoverDef& def, CoverReport* report = nullptr);

/// Adds the particles of `more`, e.g. a second layer of other radius, offset and seed that roughens the
/// surface.
void append(Covering& covering, const Covering& more);

/// Leaves only the particles for which keep(position, radius) holds, with their pieces of surface.
void keepOnly(Covering& covering, const std::function<bool(const Vector3&, double)>& keep);

}  // namespace granular
