// SPDX-License-Identifier: MIT
// Particles on a Bullet collision shape: every part of its surface covered, what no grain can reach left out.
#pragma once

#include <vector>

#include "bullet_bridge/shape_surface.h"
#include "granular/geometry/cover.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

/// Covers parts as CoverDef says, shape frame. Solids from within by default; of ground the upper side only;
/// particles deep inside another solid part (children of a compound that reach into one another) are left
/// out. `reports`, if asked for, gets one report a part. Throws what granular::coverMesh throws.
granular::Covering coverParts(const std::vector<ShapePart>& parts, const granular::CoverDef& def,
                              std::vector<granular::CoverReport>* reports = nullptr);

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
