// SPDX-License-Identifier: MIT
// Sand for a world that exists already: any btDiscreteDynamicsWorld, also the multi-body, soft-rigid and
// multi-threaded ones. The same sand and the same coupling as GranularDynamicsWorld's:
//
//   bullet_bridge::GranularLayer sand(world);
//   sand.coverBody(ground);
//   sand.addPile({.region = {{-0.2, 0.05, -0.2}, {0.2, 0.15, 0.2}}, .particleRadius = 0.01});
//   ... world.stepSimulation(1 / 60.0) as ever ...
//
// It stands before the world's constraint solver and is one of its actions; no tick callback, user pointer,
// collision filter or global is taken.
#pragma once

#include <memory>

#include "bullet_bridge/layer_door.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

namespace detail {
class Attachment;
}

class GranularLayer : public LayerDoor {
 public:
  /// From the next tick on. The world must outlive the layer. Throws std::invalid_argument if the world has a
  /// layer already, or is a GranularDynamicsWorld.
  explicit GranularLayer(btDiscreteDynamicsWorld& world, const LayerDef& def = {});
  /// The world is as it was before: its solver (or the one that the program put there since), its actions,
  /// its bodies as they move now.
  ~GranularLayer();

  /// How often the program put another solver into the world since. The layer stood before the new one again
  /// after that tick, in which everything was Bullet's and the grains stood still.
  int solverChanges() const;

 private:
  std::unique_ptr<detail::Attachment> attachment_;
};

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
