// SPDX-License-Identifier: MIT
// The particles on a body of a scene: one layer on each of its parts, a second one for roughness where asked
// for.
#pragma once

#include <vector>

#include "demos/world/body_solid.h"
#include "granular/geometry/cover.h"

namespace granular_demo {

struct BodyCovering {
  granular::Covering covering;                 ///< body frame
  std::vector<granular::CoverReport> reports;  ///< one a part and layer
};

/// @param smallestGrainRadius  m, of the grains that must not pass; 0: there are none
/// Throws std::invalid_argument as granular::coverMesh does.
BodyCovering coverSolid(const BodyShapeDef& shape, const BodySolid& solid, const CoveringPart& def,
                        double smallestGrainRadius, int threads);

}  // namespace granular_demo
