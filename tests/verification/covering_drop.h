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

inline constexpr double kStiffness = 5e7;  ///< of cubes with a given one, N/m^3: what E = 1e7 Pa gives

struct CubeDrop {
  Covering covering = {};
  CubePose pose = CubePose::Flat;
  double speed = 0.5;  ///< m/s
  MaterialPairDef pair = {.restitution = 0.5, .restitutionSpeed = 0.5, .friction = 0.0};
  IntegratorDef integrator = {};
};
struct CubeBounce {
  double restitution = 0.0;  ///< of the centre
  double overlap = 0.0;      ///< how deep the true cube reaches below the plane, m
};
CubeBounce dropCube(const CubeDrop& drop);

/// With kStiffness: force over depth at rest, depth of the true cube below the plane, N/m; and what it is for
/// the true cube, whose every piece of surface pushes by its depth.
double cubeStiffness(const Covering& covering, CubePose pose, double depth);
double exactStiffness(CubePose pose, double depth);

/// Without loss, at the speed (m/s) that takes the true cube to `depth`.
double exactDropSpeed(CubePose pose, double depth);
CubeBounce dropCubeTo(const Covering& covering, CubePose pose, double depth);

/// Depth of the comparisons, m: a hundredth of the side flat, a tenth on edge and corner, where a covering
/// must have several rows of particles below the plane to be like the solid.
constexpr double depthOf(CubePose pose) {
  return pose == CubePose::Flat ? 0.01 * kCubeSide : 0.1 * kCubeSide;
}

/// A flat cube pushed along the plane, law 19: deceleration over g once it slides, and load over displacement
/// of its foot before that, N/m.
struct CubeFriction {
  double coefficient = 0.0;
  double shearStiffness = 0.0;
};
CubeFriction slideCube(const Covering& covering, double friction);

/// Of the stone's material: kt/kn = 2 (1 - nu)/(2 - nu) (Mindlin 1949) times kStiffness times the foot's
/// area.
double exactShearStiffness();

/// A cube turned about z, the middle of its foot `depth` below the plane: force of the plane on it and its
/// torque about the cube's centre, by kStiffness. Of the solid: each point of the plane pushes as deep as the
/// underside is there.
struct TiltedCube {
  double force = 0.0;   ///< N
  double torque = 0.0;  ///< N m, about z
};
TiltedCube tiltCube(const Covering& covering, double depth, double angle);
TiltedCube tiltedSolid(double depth, double angle);

/// By the number of particles, for the figure: restitution where 0.5 is asked, stiffness and deepest overlap
/// over those of the true cube; flat also friction and shear stiffness over what was asked for. Coverings
/// made by floaters on the cube's mesh.
struct CoveringSeries {
  CubePose pose = CubePose::Flat;
  std::vector<double> particles = {}, restitution = {}, stiffness = {}, overlap = {}, friction = {},
                      shearStiffness = {};
};
std::vector<CoveringSeries> coveringSeries(const std::vector<double>& radii);

}  // namespace granular::verification
