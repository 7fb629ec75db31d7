// SPDX-License-Identifier: MIT
// What a body of a scene file is as a solid: its surface as triangles, its mass properties and its Bullet
// shape, all in the body's frame (origin at the centre of mass, axes along the principal axes of inertia).
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

#include "demos/scene/scene_def.h"
#include "granular/geometry/triangle_mesh.h"

namespace granular_demo {

struct BodySolid {
  std::vector<granular::TriangleMesh> parts;  ///< each closed (but plane patch and half-space), body frame, m
  Pose frame;                                 ///< of the body frame, in the frame the shape was drawn in
  double volume = 0.0;                    ///< m^3; of a compound the sum of its parts; 0 without an inside
  Vector3 unitInertia = Vector3::Zero();  ///< principal moments at density 1, m^5

  /// Bullet's shape; those it is made of live beside it. Particles meet particles, so Bullet's shape matters
  /// only against uncovered bodies and for ray casts: a moving mesh is its convex hull there.
  std::vector<std::unique_ptr<btCollisionShape>> shapes;  ///< the last one is the body's
  std::vector<std::unique_ptr<btTriangleMesh>> triangles;

  btCollisionShape& shape() const { return *shapes.back(); }
};

/// Axes of the body frame.
enum class BodyAxes {
  principal,  ///< of the shape at even density
  drawn,      ///< those the shape is drawn in
};

/// Throws std::runtime_error naming the file if a mesh cannot be read or is not the surface of a solid.
BodySolid makeBodySolid(const BodyShapeDef& shape, BodyKind motion, BodyAxes axes = BodyAxes::principal);

/// The closed surface of a mesh file, scaled and put where the shape says. Throws as makeBodySolid.
granular::TriangleMesh readSolidMesh(const MeshShape& shape);

/// Smallest box round a shape, in the frame it was drawn in.
Box boundsOf(const BodyShapeDef& shape);

/// All parts as one mesh, for pictures.
granular::TriangleMesh joinedMesh(const BodySolid& solid);

}  // namespace granular_demo
