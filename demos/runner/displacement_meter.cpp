// SPDX-License-Identifier: MIT
// How many of some bodies have moved away from where they stood when the run began, and when that began.
#include <algorithm>

#include "demos/runner/meter.h"

namespace granular_demo {
namespace {

class DisplacementMeter final : public Meter {
 public:
  DisplacementMeter(const DisplacementMeterDef& def, const BuiltScene& scene) : def_(def), scene_(scene) {
    for (const std::string& name : def.bodies) {
      for (const BuiltBody* body : bodiesNamed(scene, name)) {
        bodies_.push_back(body);
        starts_.push_back(body->pose().position);
      }
    }
  }

  std::vector<std::string> columns() const override { return {"displaced", "largestWay", "brokenJoints"}; }

  void tick() override {
    const int displaced = count();
    if (displaced > 0 && firstTime_ < 0.0) firstTime_ = scene_.time();
    if (scene_.joints().broken() > 0 && firstBreak_ < 0.0) firstBreak_ = scene_.time();
  }

  std::vector<double> frame() override {
    return {static_cast<double>(count()), largestWay(), static_cast<double>(scene_.joints().broken())};
  }

  std::vector<std::pair<std::string, double>> results() const override {
    std::vector<std::pair<std::string, double>> all = {
        {"bodies", static_cast<double>(bodies_.size())},
        {"displaced", static_cast<double>(count())},
        {"displacedFraction",
         bodies_.empty() ? 0.0 : static_cast<double>(count()) / static_cast<double>(bodies_.size())},
        {"largestWay", largestWay()},
        {"joints", static_cast<double>(scene_.joints().count())},
        {"brokenJoints", static_cast<double>(scene_.joints().broken())}};
    if (firstTime_ >= 0.0) all.emplace_back("firstDisplacedAt", firstTime_);
    if (firstBreak_ >= 0.0) all.emplace_back("firstJointBrokenAt", firstBreak_);
    return all;
  }

 private:
  double way(std::size_t i) const { return (bodies_[i]->pose().position - starts_[i]).norm(); }
  int count() const {
    int displaced = 0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) displaced += way(i) > def_.distance;
    return displaced;
  }
  double largestWay() const {
    double largest = 0.0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) largest = std::max(largest, way(i));
    return largest;
  }

  DisplacementMeterDef def_;
  const BuiltScene& scene_;
  std::vector<const BuiltBody*> bodies_;
  std::vector<Vector3> starts_;                  // m
  double firstTime_ = -1.0, firstBreak_ = -1.0;  // s; < 0: not yet
};

}  // namespace

std::unique_ptr<Meter> makeDisplacementMeter(const DisplacementMeterDef& def, const BuiltScene& scene) {
  return std::make_unique<DisplacementMeter>(def, scene);
}

}  // namespace granular_demo
