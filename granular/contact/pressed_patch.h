// SPDX-License-Identifier: MIT
// How pieces of a surface press against another surface as an elastic foundation: the pressure is the
// stiffness times the depth below the other surface, on the area projected onto it (Johnson, Contact
// Mechanics 1985, sec. 4.3). Pieces that look away from it do not press. For a convex solid against a plane
// every point of the plane is a spring, pushed in by as much as the underside of the solid is below it there:
// the sum does not depend on how the surface is cut into pieces, it is smooth, and it keeps energy while the
// solid turns.
#pragma once

#include <array>
#include <span>

#include "granular/geometry/covering.h"
#include "granular/geometry/exact_surface.h"

namespace granular {

/// The part of some pieces that is below another surface.
struct PressedPatch {
  double area = 0.0;                 ///< projected onto the other surface, m^2; 0: nothing presses
  double depth = 0.0;                ///< mean over that area, m
  double meanSquareDepth = 0.0;      ///< m^2
  double areaSlope = 0.0;            ///< how fast the area grows with the depth, m^2 a metre
  Vector3 center = Vector3::Zero();  ///< of the pressure, frame of the pieces, m
};

/// A rectangle: a face of a box.
struct Face {
  Vector3 center = Vector3::Zero();  ///< m
  Vector3 normal = Vector3::UnitY();
  std::array<Vector3, 2> along = {Vector3::Zero(), Vector3::Zero()};  ///< unit, its edges
  std::array<double, 2> half = {0.0, 0.0};                            ///< of its edges, m

  double distance(const Vector3& p) const { return normal.dot(p - center); }
};

/// The face that p is farthest outside of, or least inside; in the frame of the box.
Face faceOf(const ExactBox& box, const Vector3& p);

/// distance: of the point `from` from the other surface, m, positive outside. N: unit, towards that surface,
/// which is taken to be flat. Everything in the frame of the pieces. face: what of the plane there is, so
/// that a piece over its edge presses by as much as lies on it; null: all.
PressedPatch pressedPatch(std::span<const SurfacePiece> pieces, const Vector3& from, double distance,
                          const Vector3& N, const Face* face = nullptr);

}  // namespace granular
