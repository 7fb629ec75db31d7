// SPDX-License-Identifier: MIT
// Volume, centre of mass and inertia of the solid that a closed mesh bounds, exact up to rounding.
// The volume integrals of 1, x and x x^T are sums over the signed tetrahedra that each face spans with one
// fixed point: the same integrals that Mirtich (1996) reduces to line integrals, in a form without
// projections.
#pragma once

#include "granular/geometry/triangle_mesh.h"

namespace granular {

struct MassProperties {
  double volume = 0.0;                     ///< m^3
  double mass = 0.0;                       ///< kg
  Vector3 centerOfMass = Vector3::Zero();  ///< m, frame of the mesh
  Matrix3 inertia = Matrix3::Zero();       ///< kg m^2, about the centre of mass, along the axes of the mesh
  Vector3 principalMoments = Vector3::Zero();  ///< kg m^2, about the axes of principalFrame
  /// Origin at the centre of mass, axes along the principal ones, in the frame of the mesh. Axes are named to
  /// turn the frame as little as possible; where the inertia is already diagonal the orientation stays
  /// identity.
  Pose principalFrame;
};

/// Fills principalMoments and principalFrame from centerOfMass and inertia, for solids put together from
/// others.
void findPrincipalFrame(MassProperties& properties);

/// @param density  kg/m^3, finite and > 0
/// Throws std::invalid_argument if the density is not, or if the mesh is not the closed surface of a solid.
MassProperties massProperties(const TriangleMesh& mesh, double density);

}  // namespace granular
