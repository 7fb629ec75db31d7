// SPDX-License-Identifier: MIT
// Everything a Bullet program needs to have sand:
//
//   bullet_bridge::GranularDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//   ... rigid bodies as ever ...
//   world.addPile({.region = {{-0.2, 0.05, -0.2}, {0.2, 0.15, 0.2}}, .particleRadius = 0.01});
//   world.coverBody(slab);
//   world.coverBody(ball);
//   world.stepSimulation(1 / 60.0);
#pragma once

#include "bullet_bridge/granular_dynamics_world.h"
#include "bullet_bridge/granular_layer.h"
#include "bullet_bridge/shape_covering.h"
#include "bullet_bridge/shape_mass.h"
#include "bullet_bridge/shape_surface.h"
#include "bullet_bridge/task_executor.h"
#include "granular/granular.h"
