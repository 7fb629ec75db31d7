// SPDX-License-Identifier: MIT
// Everything a user of granular needs. Programs with Bullet include bullet_bridge/bullet_bridge.h instead.
#pragma once

#include "granular/base/pose.h"
#include "granular/contact/material.h"
#include "granular/dynamics/integrator.h"
#include "granular/geometry/covering.h"
#include "granular/geometry/exact_surface.h"
#include "granular/geometry/mesh_field.h"
#include "granular/system/granular_system.h"
