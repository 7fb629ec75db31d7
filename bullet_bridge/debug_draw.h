// SPDX-License-Identifier: MIT
// Grains and covered bodies' particles through Bullet's own debug drawer.
#pragma once

#include "bullet_bridge/precision.h"
#include "granular/system/granular_system.h"

class btIDebugDraw;

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

/// Under DBG_DrawWireframe particles, under DBG_DrawContactPoints contacts with their normals; at most
/// `limit` of each, evenly chosen. Up to 500 particles are drawn as spheres, more as crosses of their size (a
/// sphere costs the drawer some hundred lines, a cross three).
void drawSand(btIDebugDraw& drawer, granular::GranularSystem& system, int limit);

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
