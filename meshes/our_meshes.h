// SPDX-License-Identifier: MIT
// The meshes of this folder, made from numbers: closed, outward, lengths in m, z up. What each is for and how
// its parts fit together is in README.md.
#pragma once

#include "granular/geometry/triangle_mesh.h"

namespace granular_meshes {

using granular::TriangleMesh;
using granular::Vector3;

/// A two-humped camel, 2.6 m from tail to nose, looking along +x, feet on z = 0: a smooth union of limbs.
TriangleMesh makeCamel();

/// Five points, 1 m from centre to point, 0.4 m thick.
TriangleMesh makeStar();

/// A convex block with no two faces alike: no symmetry hides a mistake in its inertia.
TriangleMesh makeWedge();

/// A glass hourglass, 1 m high inside: an outer wall and, inside out, the cavity that holds the grains.
/// @param neckRadius  of the cavity at its narrowest, m, in (0, 0.15]
TriangleMesh makeHourglass(double neckRadius);

/// Two discs and four turned posts that hold makeHourglass, not touching it: for pictures.
TriangleMesh makeHourglassFrame();

/// The blade of a bulldozer, 3.2 m wide, hollow side towards +x, ribs at its back, wings bent forward.
TriangleMesh makeBlade();

/// A post with a round top, 1 m high, foot on z = 0.
TriangleMesh makePole();

/// A slope of 38 degrees with a gully, foot at x = 0, and a plain, exactly z = 0 for x >= 0.5 m.
TriangleMesh makeTerrain();

/// Parts of one house, 4 x 3 m, drawn where they stand in it; joints are 5 mm wide.
TriangleMesh makeHouseFront();    ///< a long wall with a door and two windows, at y = -1.5
TriangleMesh makeHouseBack();     ///< a long wall with two windows, at y = 1.5
TriangleMesh makeHouseGable();    ///< a short wall up to the ridge, at x = 2; turned by 180 degrees the other
TriangleMesh makeHouseRoof();     ///< half the roof, y > 0; turned by 180 degrees about z the other half
TriangleMesh makeHouseChimney();  ///< a square tube on the ground, beside the gable at x = 2

}  // namespace granular_meshes
