// SPDX-License-Identifier: MIT
#include "demos/world/motion_script.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace granular_demo {
namespace {

Vector3 pathOffset(const std::vector<ScriptPoint>& path, double time) {
  if (path.empty()) return Vector3::Zero();
  const auto after =
      std::find_if(path.begin(), path.end(), [&](const auto& point) { return point.time > time; });
  if (after == path.begin()) return path.front().offset;
  if (after == path.end()) return path.back().offset;
  const auto before = after - 1;
  const double t = (time - before->time) / (after->time - before->time);
  return (1.0 - t) * before->offset + t * after->offset;
}

/// Zero before `from`; stays where it is at `to`.
Vector3 shakeOffset(const ScriptShake& shake, double time) {
  if (time < shake.from) return Vector3::Zero();
  const double since = std::min(time, shake.to) - shake.from;
  const double angle = 2.0 * std::numbers::pi * shake.frequency * since + shake.phase;
  return (std::sin(angle) - std::sin(shake.phase)) * shake.amplitude;
}

Quaternion turned(const ScriptTurn& turn, double time) {
  const double since = std::clamp(time, turn.from, turn.to) - turn.from;
  return Quaternion(Eigen::AngleAxisd(turn.rate * since, turn.axis));
}

}  // namespace

Pose poseAt(const ScriptDef& script, const Pose& start, double time) {
  Pose pose = start;
  pose.position += pathOffset(script.path, time);
  if (script.shake) pose.position += shakeOffset(*script.shake, time);
  if (script.turn) pose.orientation = turned(*script.turn, time) * start.orientation;
  return pose;
}

}  // namespace granular_demo
