// SPDX-License-Identifier: MIT
// A covered cube against the exact plane: how it bounces, how stiff it is and how it slides, by how many
// particles.
#pragma once

#include <string>
#include <vector>

#include "granular/granular.h"

namespace granular::verification {

/// Which part of the cube meets the plane. Its centre is above that part: the impact sets up no spin.
enum class CubePose { Flat, Edge, Corner };
const char* nameOf(CubePose pose);
Quaternion orientationOf(CubePose pose);

inline constexpr double kCubeSide = 0.1;  ///< m
inline constexpr double kCubeMass = 2.5;  ///< kg

/// Particles in the middle of the n x n cells of every face, half a cell deep, each with the surface of its
/// cells: at an edge two, at a corner three, of different normals. n^3 - (n - 2)^3 particles.
Covering cubeCovering(int n);
/// The same of the face y = -side/2 alone, which stands for its whole area: n^2 particles.
Covering footCovering(int n);

struct CubeDrop {
  Covering covering = {};
  CubePose pose = CubePose::Flat;
  double speed = 0.5;             ///< m/s
  double restitution = 0.5;       ///< asked, at `restitutionSpeed`
  double restitutionSpeed = 0.5;  ///< m/s
  IntegratorDef integrator = {};
};
struct CubeBounce {
  double restitution = 0.0;  ///< of the centre
  double overlap = 0.0;      ///< how deep the true cube reaches below the plane, m
};
CubeBounce dropCube(const CubeDrop& drop);

/// Force over depth at rest, depth of the true cube below the plane, N/m.
double cubeStiffness(const Covering& covering, CubePose pose, double depth);

/// A flat cube pushed along the plane: deceleration once it slides over g, and the depth over which it
/// springs back, N/m (law 19).
struct CubeFriction {
  double coefficient = 0.0;
  double shearStiffness = 0.0;
};
CubeFriction slideCube(const Covering& covering, double friction);

/// By the number of particles, for the figure.
struct CoveringSeries {
  CubePose pose = CubePose::Flat;
  std::vector<double> particles = {}, restitution = {}, stiffness = {}, overlap = {};
};
std::vector<CoveringSeries> coveringSeries(const std::vector<int>& cellsPerEdge);

}  // namespace granular::verification
