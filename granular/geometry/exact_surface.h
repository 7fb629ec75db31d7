// SPDX-License-Identifier: MIT
// Surfaces that particles meet exactly instead of through surface particles: smooth and cheap.
// Differs from the paper: there, everything a particle can touch is a particle. Scenes of the paper use
// coverings. Test: ExactSurface.*.
#pragma once

#include <memory>
#include <string>
#include <variant>

#include "granular/base/pose.h"

namespace granular {

class MeshField;

/// Solid below the plane y = 0, of no mass properties: static and kinematic bodies only.
struct HalfSpace {};

/// Solid ball about the origin.
struct ExactSphere {
  double radius = 0.0;  ///< m, > 0
};

/// Solid box about the origin, along the axes.
struct ExactBox {
  Vector3 halfSize = Vector3::Zero();  ///< m, > 0
};

/// All points within `radius` of a piece of the y axis, origin in the middle.
struct ExactCapsule {
  double radius = 0.0;      ///< m, > 0
  double halfLength = 0.0;  ///< of the piece, m, >= 0
};

/// Solid cylinder round the y axis, origin in the middle.
struct ExactCylinder {
  double radius = 0.0;      ///< m, > 0
  double halfLength = 0.0;  ///< m, > 0
};

/// The solid inside a closed mesh, by its signed distance (mesh_field.h). Bodies may share one.
struct ExactMesh {
  std::shared_ptr<const MeshField> field = {};
};

/// In a frame of its own (BodyDef::exactPose). Met by particles, never by other exact surfaces. One contact a
/// particle: the nearest point of the surface; within the solid the way out is the shorter one. Stiffness
/// against grains: a sphere counts with its radius, all else as flat.
using ExactSurface = std::variant<HalfSpace, ExactSphere, ExactBox, ExactCapsule, ExactCylinder, ExactMesh>;

/// What a particle needs to know of a surface.
struct SurfaceDistance {
  double distance = 0.0;              ///< m, negative inside
  Vector3 normal = Vector3::UnitY();  ///< unit, towards growing distance: away from the solid
  double slope = 1.0;  ///< of the distance along the normal; 1 but for meshes, where samples are interpolated
};

/// At a point of the surface's own frame, as below.
SurfaceDistance surfaceDistance(const ExactSurface& surface, const Vector3& p);

/// Whether p may be nearer to the surface than `reach`, m: false only if it is not.
bool mayBeWithin(const ExactSurface& surface, const Vector3& p, double reach);

/// Of the solid about the origin, m; infinite for a half-space.
double boundingRadius(const ExactSurface& surface);

/// What the solid shows along each axis, both sides together, m^2; 0 for a half-space.
Vector3 shownArea(const ExactSurface& surface);

/// Throws std::invalid_argument naming the field below `what`.
void checkExactSurface(const ExactSurface& surface, const std::string& what);

}  // namespace granular
