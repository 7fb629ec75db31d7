// SPDX-License-Identifier: MIT
// What a moved body has pushed along, and the force that took.
#include <algorithm>

#include "demos/runner/meter.h"

namespace granular_demo {
namespace {

class PushMeter final : public Meter {
 public:
  PushMeter(const PushMeterDef& def, const BuiltScene& scene)
      : def_(def), scene_(scene), blade_(scene.body(def.body)), frameTime_(scene.time()) {
    for (const granular::RigidMotion& motion : scene.grains().grainMotions())
      grainStarts_.push_back(motion.pose.position);
    for (const BuiltBody& body : scene.bodies()) bodyStarts_.push_back(body.pose().position);
  }

  std::vector<std::string> columns() const override {
    return {"force", "pushedVolume", "pushedMass", "pushedGrains", "pushedBodies"};
  }

  void tick() override {
    const granular::BodyId id = scene_.world().bodyIdOf(*blade_.body);
    impulse_ -= scene_.grains().contactImpulse(id).force.dot(def_.direction);
  }

  std::vector<double> frame() override {
    const double time = scene_.time() - frameTime_;
    const double force = time > 0.0 ? impulse_ / time : 0.0;
    totalImpulse_ += impulse_;
    totalTime_ += time;
    largestForce_ = std::max(largestForce_, force);
    impulse_ = 0.0;
    frameTime_ = scene_.time();
    const Pushed p = pushed();
    return {force, p.volume, p.mass, static_cast<double>(p.grains), static_cast<double>(p.bodies)};
  }

  std::vector<std::pair<std::string, double>> results() const override {
    const Pushed p = pushed();
    return {{"meanForce", totalTime_ > 0.0 ? totalImpulse_ / totalTime_ : 0.0},
            {"largestForce", largestForce_},
            {"pushedVolume", p.volume},
            {"pushedMass", p.mass},
            {"pushedGrains", static_cast<double>(p.grains)},
            {"pushedBodies", static_cast<double>(p.bodies)}};
  }

 private:
  struct Pushed {
    double volume = 0.0, mass = 0.0;  // of the solids, m^3, kg
    int grains = 0, bodies = 0;
  };

  bool isPushed(const Vector3& now, const Vector3& start) const {
    return (now - start).dot(def_.direction) > def_.distance;
  }

  Pushed pushed() const {
    Pushed sum;
    const granular::GranularSystem& grains = scene_.grains();
    for (std::size_t i = 0; i < grainStarts_.size(); ++i) {
      const granular::GrainId id = grains.grainAt(static_cast<std::int32_t>(i));
      if (id.index < 0 || !isPushed(grains.grainMotions()[i].pose.position, grainStarts_[i])) continue;
      ++sum.grains;
      sum.mass += grains.massOf(id);
      sum.volume += grains.massOf(id) / grains.material(grains.materialOf(id)).density;
    }
    for (std::size_t i = 0; i < bodyStarts_.size(); ++i) {
      const BuiltBody& body = scene_.bodies()[i];
      if (body.part->motion != BodyKind::dynamic || !isPushed(body.pose().position, bodyStarts_[i])) continue;
      ++sum.bodies;
      sum.mass += body.mass;
      sum.volume += body.solid->volume;
    }
    return sum;
  }

  PushMeterDef def_;
  const BuiltScene& scene_;
  const BuiltBody& blade_;
  std::vector<Vector3> grainStarts_, bodyStarts_;  // m
  double impulse_ = 0.0;                           // of the frame so far, against the push, N s
  double frameTime_;                               // when the frame began, s
  double totalImpulse_ = 0.0, totalTime_ = 0.0, largestForce_ = 0.0;
};

}  // namespace

std::unique_ptr<Meter> makePushMeter(const PushMeterDef& def, const BuiltScene& scene) {
  return std::make_unique<PushMeter>(def, scene);
}

}  // namespace granular_demo
