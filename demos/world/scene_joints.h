// SPDX-License-Identifier: MIT
// Bullet's constraints between bodies of a scene, breakable ones among them.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "demos/scene/scene_def.h"

namespace granular_demo {

class SceneJoints {
 public:
  /// A body as constraints see it.
  struct End {
    btRigidBody* body = nullptr;
    Pose pose;  ///< of its frame, world
  };

  /// Adds a part's constraints to the world. `find` gives the body of a name; `bodies` are all parts, copies
  /// expanded.
  /// Throws std::invalid_argument if neither of two joined bodies moves.
  void add(const JointPart& part, const std::vector<BodyPart>& bodies,
           const std::function<End(const std::string&)>& find, btDynamicsWorld& world, double tickDuration);
  /// Takes joints that broke out of the world, so that what they held apart can touch. Call after each tick.
  void releaseBroken(btDynamicsWorld& world);
  void removeFrom(btDynamicsWorld& world);

  std::size_t count() const { return joints_.size(); }
  std::size_t broken() const;
  std::vector<std::string> brokenNames() const;
  /// Names that are not there are an error (std::invalid_argument).
  void breakByName(const std::string& name);

 private:
  struct Joint {
    std::string name;
    std::unique_ptr<btTypedConstraint> constraint;
    bool isReleased = false;
  };
  void addOne(const std::string& name, const JointPart& part, const End& a, const End& b, const Vector3& at,
              btDynamicsWorld& world, double tickDuration);

  std::vector<Joint> joints_;
};

}  // namespace granular_demo
