// SPDX-License-Identifier: MIT
// Is everything where it may be? Counted after every frame, over all particles of grains and of dynamic
// bodies.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "demos/world/built_scene.h"
#include "granular/geometry/mesh_distance.h"

namespace granular_demo {

struct PlaceCounts {
  std::int64_t insideBodies =
      0;  ///< particles whose centre is deeper inside a covered body than their radius
  std::int64_t belowGround =
      0;  ///< particles with their centre below SceneDef::groundHeight, under the container's floor
  std::int64_t outside = 0;    ///< grains and dynamic bodies whose centre is outside the container
  std::int64_t notFinite = 0;  ///< grains and dynamic bodies with a state that is not a number
  std::string inside;          ///< a body that holds such a particle; empty: none does
};

class PlaceChecks {
 public:
  explicit PlaceChecks(const BuiltScene& scene);
  PlaceCounts count() const;

 private:
  /// A closed body: spheres and boxes by formula, others by the exact distance to their triangles.
  using Parts = std::vector<granular::MeshDistance>;
  struct Solid {
    const BuiltBody* body = nullptr;
    double boundingRadius = 0.0;
    std::shared_ptr<const Parts> parts;  ///< copies of one body share them
  };

  static bool isInside(const Solid& solid, const Vector3& own, double depth);
  void countGrains(PlaceCounts& counts) const;
  void countBodies(PlaceCounts& counts) const;
  void countInside(const Vector3& p, double radius, const Solid& solid, const Pose& pose,
                   PlaceCounts& counts) const;
  void countPlace(const Vector3& p, bool isFinite, PlaceCounts& counts) const;
  Vector3 up() const;
  bool isBelowGround(const Vector3& p) const;

  const BuiltScene& scene_;
  std::vector<Solid> solids_;
};

}  // namespace granular_demo
