// SPDX-License-Identifier: MIT
// Bullet comes in float and in double, told apart by one macro only; a program that mixes the two mostly
// links and then reads the wrong memory. So the precision is part of every name this library exports, and a
// program whose btScalar is not the one the library was built for stops here.
#pragma once

#include <LinearMath/btScalar.h>

#ifndef BULLET_BRIDGE_DOUBLE
#error "BULLET_BRIDGE_DOUBLE is not set: link the CMake target granular::bullet_bridge, which sets it"
#endif

#if BULLET_BRIDGE_DOUBLE
static_assert(
    sizeof(btScalar) == 8,
    "this bullet_bridge is built for double Bullet, but btScalar is float: define BT_USE_DOUBLE_PRECISION "
    "everywhere, or build with GRANULAR_BULLET_PRECISION=float");
#define BULLET_BRIDGE_PRECISION float64
#else
static_assert(sizeof(btScalar) == 4,
              "this bullet_bridge is built for float Bullet, but btScalar is double: do not define "
              "BT_USE_DOUBLE_PRECISION, or build with GRANULAR_BULLET_PRECISION=double");
#define BULLET_BRIDGE_PRECISION float32
#endif

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {}
}  // namespace bullet_bridge
