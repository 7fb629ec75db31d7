// SPDX-License-Identifier: MIT
// Is everything where it may be? Counted after every frame, over all particles of grains.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "demos/world/built_scene.h"
#include "granular/geometry/mesh_distance.h"

namespace granular_demo {

struct PlaceCounts {
  std::int64_t insideBodies =
      0;  ///< particles whose centre is deeper inside a covered body than their radius
  std::int64_t belowGround =
      0;  ///< particles with their centre below SceneDef::groundHeight, under the container's floor
  std::int64_t outside = 0;    ///< grains whose centre is outside the container
  std::int64_t notFinite = 0;  ///< grains with a state that is not a number
};

class PlaceChecks {
 public:
  explicit PlaceChecks(const BuiltScene& scene);
  PlaceCounts count() const;

 private:
  /// A closed body: spheres and boxes by formula, others by the exact distance to their triangles.
  struct Solid {
    const BuiltBody* body = nullptr;
    double boundingRadius = 0.0;
    std::vector<std::unique_ptr<granular::MeshDistance>> parts;
  };

  static bool isInside(const Solid& solid, const Vector3& own, double depth);
  Vector3 up() const;
  bool isBelowGround(const Vector3& p) const;

  const BuiltScene& scene_;
  std::vector<Solid> solids_;
};

}  // namespace granular_demo
