// SPDX-License-Identifier: MIT
#include "demos/world/scene_joints.h"

#include <algorithm>
#include <stdexcept>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/pose_algebra.h"

namespace granular_demo {
namespace {

using bullet_bridge::composed;
using bullet_bridge::inverse;
using bullet_bridge::toBullet;

std::unique_ptr<btTypedConstraint> makeConstraint(const JointPart& part, const SceneJoints::End& a,
                                                  const SceneJoints::End& b, const Vector3& at) {
  const btVector3 pivotA = toBullet(a.pose.toOwn(at)), pivotB = toBullet(b.pose.toOwn(at));
  if (part.kind == JointKind::point)
    return std::make_unique<btPoint2PointConstraint>(*a.body, *b.body, pivotA, pivotB);
  if (part.kind == JointKind::hinge) {
    const btVector3 axisA = toBullet(Vector3(a.pose.orientation.conjugate() * part.axis));
    const btVector3 axisB = toBullet(Vector3(b.pose.orientation.conjugate() * part.axis));
    return std::make_unique<btHingeConstraint>(*a.body, *b.body, pivotA, pivotB, axisA, axisB);
  }
  const Pose joint = {at, Quaternion::Identity()};
  return std::make_unique<btFixedConstraint>(*a.body, *b.body, toBullet(composed(inverse(a.pose), joint)),
                                             toBullet(composed(inverse(b.pose), joint)));
}

}  // namespace

void SceneJoints::add(const JointPart& part, const std::vector<BodyPart>& bodies,
                      const std::function<End(const std::string&)>& find, btDynamicsWorld& world,
                      double tickDuration) {
  if (part.copiesOf.empty()) {
    const End a = find(part.bodies[0]), b = find(part.bodies[1]);
    const Vector3 halfway = 0.5 * (a.pose.position + b.pose.position);
    addOne(part.name, part, a, b, part.at.value_or(halfway), world, tickDuration);
    return;
  }
  std::vector<const BodyPart*> copies;
  for (const BodyPart& body : bodies) {
    if (body.group == part.copiesOf) copies.push_back(&body);
  }
  int number = 0;
  for (const BodyPart* from : copies) {
    std::array<int, 3> place = from->place;
    ++place[part.along];
    const auto next = std::find_if(copies.begin(), copies.end(),
                                   [&](const BodyPart* body) { return body->place == place; });
    if (next == copies.end()) continue;
    const End a = find(from->name), b = find((*next)->name);
    addOne(part.name + "[" + std::to_string(number++) + "]", part, a, b,
           0.5 * (a.pose.position + b.pose.position), world, tickDuration);
  }
}

void SceneJoints::addOne(const std::string& name, const JointPart& part, const End& a, const End& b,
                         const Vector3& at, btDynamicsWorld& world, double tickDuration) {
  if (a.body->getInvMass() == 0.0 && b.body->getInvMass() == 0.0)
    throw std::invalid_argument("neither of the two bodies is dynamic");
  Joint joint = {name, makeConstraint(part, a, b, at)};
  if (part.breakingForce)
    joint.constraint->setBreakingImpulseThreshold(static_cast<btScalar>(*part.breakingForce * tickDuration));
  world.addConstraint(joint.constraint.get(), !part.touching);
  joints_.push_back(std::move(joint));
}

void SceneJoints::releaseBroken(btDynamicsWorld& world) {
  for (Joint& joint : joints_) {
    if (joint.constraint->isEnabled() || joint.isReleased) continue;
    world.removeConstraint(joint.constraint.get());
    joint.isReleased = true;
  }
}

void SceneJoints::removeFrom(btDynamicsWorld& world) {
  for (Joint& joint : joints_) world.removeConstraint(joint.constraint.get());
  joints_.clear();
}

std::size_t SceneJoints::broken() const {
  return static_cast<std::size_t>(std::count_if(
      joints_.begin(), joints_.end(), [](const Joint& joint) { return !joint.constraint->isEnabled(); }));
}

std::vector<std::string> SceneJoints::brokenNames() const {
  std::vector<std::string> names;
  for (const Joint& joint : joints_) {
    if (!joint.constraint->isEnabled()) names.push_back(joint.name);
  }
  return names;
}

void SceneJoints::breakByName(const std::string& name) {
  const auto found =
      std::find_if(joints_.begin(), joints_.end(), [&](const Joint& joint) { return joint.name == name; });
  if (found == joints_.end()) throw std::invalid_argument("there is no joint \"" + name + "\"");
  found->constraint->setEnabled(false);
}

}  // namespace granular_demo
