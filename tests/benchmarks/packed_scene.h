// SPDX-License-Identifier: MIT
// The scenes that contact pipelines are timed on, ours and others': a box full of spheres or tetrahedra, at
// rest or flowing out where one wall has been taken away.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "granular/system/granular_system.h"

namespace granular_bench {

/// Grains in a box, as plain data: a state to begin with under any law, here or elsewhere.
struct PackedGrains {
  granular::GrainShapeDef shape;
  std::vector<granular::RigidMotion> motions;
  std::vector<double> scales;  ///< of the shape, one a grain
  double width = 0.0;          ///< m, of the box in x and z
  bool isOpen = false;         ///< its wall at +x has been taken away
};

/// Radius of a particle of scale 1, m.
inline constexpr double kPackedRadius = 2.5e-3;

/// About `particles` round ones of R = 2.5 mm within 5 % (tetrahedra: centres 1.6 R apart), in a box as wide
/// as makes 50,000 spheres stand .2 m x .2 m, settled for .3 s under the default laws.
PackedGrains packGrains(bool tetrahedra, std::int64_t particles, int threads);
/// The same .1 s after the wall at +x has been taken away.
PackedGrains letFlow(const PackedGrains& atRest, int threads);

struct PackedScene {
  granular::GranularSystem system;
  granular::MaterialId material;
  std::vector<granular::GrainId> grains;
};
/// 2500 kg/m^3, E = 10 MPa, nu = 0.3, mu = 0.5, e = 0.5 at 1 m/s; `pair` says the laws, of grains and walls.
PackedScene makePackedScene(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                            const granular::IntegratorDef& integrator, int threads);

struct PackedSceneDef {
  bool tetrahedra = false;          ///< rigid clumps of four; else single spheres
  bool flowing = false;             ///< else at rest
  bool memory = false;              ///< law 19; else law 18
  std::int64_t particles = 50'000;  ///< round particles, about
  int threads = 1;

  std::string name() const;
};
/// Packed, and let flow if asked, under the laws of the def; Hertz with viscoelastic damping.
PackedScene makePackedScene(const PackedSceneDef& def);

}  // namespace granular_bench
