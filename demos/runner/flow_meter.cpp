// SPDX-License-Identifier: MIT
// Mass of grains beyond a plane against time, and how constant the rate is between two fractions of all mass.
#include <algorithm>
#include <cmath>

#include "demos/runner/meter.h"

namespace granular_demo {
namespace {

// Stretches of equal time whose rates are compared with the mean rate.
constexpr int kStretches = 5;

class FlowMeter final : public Meter {
 public:
  FlowMeter(const FlowMeterDef& def, const BuiltScene& scene) : def_(def), scene_(scene) { tick(); }

  std::vector<std::string> columns() const override { return {"passedMass", "rate"}; }

  void tick() override {
    double passed = 0.0, all = 0.0;
    const auto motions = scene_.grains().grainMotions();
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(motions.size()); ++i) {
      const granular::GrainId id = scene_.grains().grainAt(i);
      if (id.index < 0) continue;  // removed
      const double mass = scene_.grains().massOf(id);
      all += mass;
      if ((motions[i].pose.position - def_.point).dot(def_.direction) > 0.0) passed += mass;
    }
    all_ = all;
    times_.push_back(scene_.time());
    passed_.push_back(passed);
  }

  std::vector<double> frame() override {
    const double time = times_.back() - times_[atFrame_];
    const double rate = time > 0.0 ? (passed_.back() - passed_[atFrame_]) / time : 0.0;
    atFrame_ = times_.size() - 1;
    return {passed_.back(), rate};
  }

  std::vector<std::pair<std::string, double>> results() const override {
    const double fraction = all_ > 0.0 ? passed_.back() / all_ : 0.0;
    std::vector<std::pair<std::string, double>> all = {{"passedMass", passed_.back()},
                                                       {"passedFraction", fraction}};
    const std::size_t a = firstBeyond(def_.from * all_), b = firstBeyond(def_.to * all_);
    if (b >= times_.size() || b <= a + kStretches) return all;
    const double rate = rateBetween(a, b);
    double deviation = 0.0;
    for (std::size_t k = 0; k < kStretches; ++k) {
      const std::size_t from = a + (b - a) * k / kStretches, to = a + (b - a) * (k + 1) / kStretches;
      deviation = std::max(deviation, std::abs(rateBetween(from, to) / rate - 1.0));
    }
    all.insert(all.end(),
               {{"rate", rate}, {"rateDeviation", deviation}, {"from", times_[a]}, {"to", times_[b]}});
    return all;
  }

 private:
  std::size_t firstBeyond(double mass) const {
    return static_cast<std::size_t>(
        std::find_if(passed_.begin(), passed_.end(), [&](double m) { return m >= mass; }) - passed_.begin());
  }
  double rateBetween(std::size_t a, std::size_t b) const {
    return (passed_[b] - passed_[a]) / (times_[b] - times_[a]);
  }

  FlowMeterDef def_;
  const BuiltScene& scene_;
  std::vector<double> times_, passed_;  // a tick: s, kg
  double all_ = 0.0;                    // kg
  std::size_t atFrame_ = 0;             // tick at which the last frame ended
};

}  // namespace

std::unique_ptr<Meter> makeFlowMeter(const FlowMeterDef& def, const BuiltScene& scene) {
  return std::make_unique<FlowMeter>(def, scene);
}

}  // namespace granular_demo
