// SPDX-License-Identifier: MIT
// Counts rings threaded on poles, and says where the others lie: at the poles, at the walls, or between.
#include <algorithm>
#include <cmath>
#include <limits>

#include "demos/runner/meter.h"

namespace granular_demo {
namespace {

struct Pole {
  Vector3 foot, top;  // ends of its axis, m, world
};

class RingMeter final : public Meter {
 public:
  RingMeter(const RingMeterDef& def, const BuiltScene& scene)
      : def_(def), rings_(bodiesNamed(scene, def.rings)) {
    for (const BuiltBody* body : bodiesNamed(scene, def.poles)) {
      const auto* shape = std::get_if<CylinderShape>(&body->part->shape);
      if (!shape) continue;
      const Pose pose = body->drawnPose();
      const Vector3 half = {0.0, 0.5 * shape->height, 0.0};
      poles_.push_back({pose.toWorld(-half), pose.toWorld(half)});
    }
    const Vector3& gravity = scene.def().gravity;
    up_ = gravity.norm() > 0.0 ? Vector3(-gravity.normalized()) : Vector3(Vector3::UnitY());
  }

  std::vector<std::string> columns() const override { return {"onPoles"}; }
  void tick() override {}
  std::vector<double> frame() override { return {static_cast<double>(count().onPoles)}; }

  std::vector<std::pair<std::string, double>> results() const override {
    const Counts c = count();
    const auto share = [&](int n) { return c.others > 0 ? static_cast<double>(n) / c.others : 0.0; };
    return {{"rings", static_cast<double>(rings_.size())},
            {"poles", static_cast<double>(poles_.size())},
            {"onPoles", static_cast<double>(c.onPoles)},
            {"others", static_cast<double>(c.others)},
            {"othersAtPoles", static_cast<double>(c.atPoles)},
            {"othersAtWalls", static_cast<double>(c.atWalls)},
            {"shareAtPoles", share(c.atPoles)},
            {"shareAtWalls", share(c.atWalls)},
            {"meanDistanceToPole", c.distances / std::max(1, c.others)},
            {"meanDistanceFromMiddle", c.fromMiddle / std::max(1, c.others)}};
  }

 private:
  struct Counts {
    int onPoles = 0, others = 0, atPoles = 0, atWalls = 0;
    double distances = 0.0, fromMiddle = 0.0;  // horizontal, sums over others, m
  };

  /// Whether the pole's axis goes through the hole.
  bool isThreaded(const Pose& ring, const Pole& pole) const {
    const Vector3 normal = ring.orientation * Vector3::UnitZ();
    const Vector3 axis = pole.top - pole.foot;
    const double across = normal.dot(axis);
    if (std::abs(across) < 1e-9 * axis.norm()) return false;
    const double t = normal.dot(ring.position - pole.foot) / across;
    if (t < 0.0 || t > 1.0) return false;
    return (pole.foot + t * axis - ring.position).norm() < def_.holeRadius;
  }

  double levelDistance(const Vector3& a, const Vector3& b) const {
    const Vector3 d = a - b;
    return (d - up_.dot(d) * up_).norm();
  }

  bool isAtWall(const Vector3& p) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(up_[axis]) > 0.5) continue;
      if (std::min(p[axis] - def_.walls.lower[axis], def_.walls.upper[axis] - p[axis]) < def_.nearWall)
        return true;
    }
    return false;
  }

  Counts count() const {
    Counts counts;
    for (const BuiltBody* ring : rings_) {
      const Pose pose = ring->drawnPose();
      if (std::any_of(poles_.begin(), poles_.end(), [&](const Pole& p) { return isThreaded(pose, p); })) {
        ++counts.onPoles;
        continue;
      }
      ++counts.others;
      double nearest = std::numeric_limits<double>::infinity();
      for (const Pole& pole : poles_) nearest = std::min(nearest, levelDistance(pose.position, pole.foot));
      counts.distances += poles_.empty() ? 0.0 : nearest;
      counts.fromMiddle += levelDistance(pose.position, def_.walls.center());
      if (isAtWall(pose.position)) {
        ++counts.atWalls;
      } else if (nearest < def_.nearPole) {
        ++counts.atPoles;
      }
    }
    return counts;
  }

  RingMeterDef def_;
  std::vector<const BuiltBody*> rings_;
  std::vector<Pole> poles_;
  Vector3 up_;
};

}  // namespace

std::unique_ptr<Meter> makeRingMeter(const RingMeterDef& def, const BuiltScene& scene) {
  return std::make_unique<RingMeter>(def, scene);
}

}  // namespace granular_demo
