// SPDX-License-Identifier: MIT
// All grains as one static body that only queries meet. One collision object for all of them: a compound
// whose children are the particles, which Bullet walks through by its own tree of boxes.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "bullet_bridge/precision.h"
#include "granular/system/granular_system.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

class GrainQueries {
 public:
  GrainQueries(btDiscreteDynamicsWorld& world, int group, int mask);
  GrainQueries(const GrainQueries&) = delete;
  GrainQueries& operator=(const GrainQueries&) = delete;
  ~GrainQueries();

  /// Puts the children where the particles of grains are.
  void update(const granular::GranularSystem& system);
  std::optional<granular::GrainId> grainOf(const btCollisionObject* object, int childIndex,
                                           const granular::GranularSystem& system) const;

 private:
  /// Collides with nothing, whatever the filters say.
  class QueryBody : public btRigidBody {
   public:
    explicit QueryBody(btCollisionShape* shape) : btRigidBody(0, nullptr, shape) { m_checkCollideWith = 1; }
    bool checkCollideWithOverride(const btCollisionObject*) const override { return false; }
  };

  btSphereShape* sphere(double radius);

  btDiscreteDynamicsWorld& world_;
  std::map<double, std::unique_ptr<btSphereShape>> spheres_;  // by radius
  btCompoundShape compound_{true};
  QueryBody body_{&compound_};
  int group_;
  int mask_;
  bool inWorld_ = false;             // an empty compound has no box: it joins with the first grain
  std::vector<std::int32_t> owner_;  // GrainId::index of child i
};

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
