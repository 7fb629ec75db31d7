// SPDX-License-Identifier: MIT
// Grains: rigid groups of round particles (Bell 2005, sec. 3.1).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "granular/base/pose.h"

namespace granular {

/// Names a grain shape of one GranularSystem.
struct GrainShapeId {
  std::int32_t index = -1;
  friend bool operator==(GrainShapeId, GrainShapeId) = default;
};

/// One round particle of a shape.
struct ShapeParticle {
  Vector3 position = Vector3::Zero();  ///< s_i, m, shape frame
  double radius = 0.0;                 ///< m, > 0
};

/// A grain shape as its user draws it, in any frame. Mass and inertia are sums over the particles, also where
/// particles overlap.
struct GrainShapeDef {
  std::string name = "grain";
  std::vector<ShapeParticle> particles = {};  ///< at least one
};

GrainShapeDef sphereShape(double particleRadius);
/// Four touching particles at the corners of a regular tetrahedron.
GrainShapeDef tetrahedronShape(double particleRadius);
/// Eight touching particles at the corners of a cube.
GrainShapeDef cubeShape(double particleRadius);

/// A grain shape in its principal frame: origin at the centre of mass, axes along the principal axes of
/// inertia.
struct GrainShape {
  std::string name;
  std::vector<ShapeParticle> particles;   ///< principal frame
  Pose principalFrame;                    ///< of the frame above, in the frame of the GrainShapeDef
  double volume = 0.0;                    ///< sum over particles, m^3; mass = density * volume
  Vector3 unitInertia = Vector3::Zero();  ///< principal moments at density 1, m^5
  double boundingRadius = 0.0;            ///< m, about the centre of mass
  bool isotropic = false;                 ///< all three moments equal: spheres, tetrahedra, cubes
};

/// Throws std::invalid_argument for no particles, a radius that is not > 0, a position that is not finite.
GrainShape makeGrainShape(const GrainShapeDef& def);

}  // namespace granular
