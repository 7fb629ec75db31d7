// SPDX-License-Identifier: MIT
#include "demos/runner/energy_balance.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace granular_demo {
namespace {

/// Height that potential energy is reckoned from: the ground the file names, or the lowest point of any
/// particle.
double floorHeight(const BuiltScene& scene) {
  const SceneDef& def = scene.def();
  if (def.groundHeight) return *def.groundHeight;
  double lowest = std::numeric_limits<double>::infinity();
  std::vector<granular::ParticleView> particles;
  scene.grains().readParticles(particles);
  const Vector3 up = -def.gravity.normalized();
  for (const granular::ParticleView& p : particles) lowest = std::min(lowest, up.dot(p.position) - p.radius);
  return std::isfinite(lowest) ? lowest : 0.0;
}

double movingMass(const BuiltScene& scene) {
  double mass = 0.0;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(scene.grains().grainMotions().size()); ++i) {
    const granular::GrainId id = scene.grains().grainAt(i);
    if (id.index >= 0) mass += scene.grains().massOf(id);
  }
  for (const BuiltBody& body : scene.bodies()) {
    if (body.part->meetsGrains()) mass += body.mass;
  }
  return mass;
}

}  // namespace

void EnergyBalance::add(const granular::StepReport& report, const BuiltScene& scene) {
  const OutsideEnergy& outside = scene.outsideEnergy();
  const double g = scene.def().gravity.norm();
  if (!started_) {
    started_ = true;
    energyAtStart_ = report.energy.total();
    heatAtStart_ = report.dissipated;
    if (g > 0.0) {
      floorEnergy_ = g * floorHeight(scene);  // J/kg
      putIn_ = energyAtStart_ - movingMass(scene) * floorEnergy_;
    } else {
      putIn_ = energyAtStart_;
    }
    putInAtStart_ = putIn_;
    return;
  }
  const auto gain = [&](double now, double& last) {
    gained_ += std::max(0.0, now - last);
    last = now;
  };
  gain(report.workByMovedBodies, lastMoved_);
  gain(report.workByLoads, lastLoads_);
  gain(outside.byConstraints, lastJoints_);
  putIn_ = putInAtStart_ + outside.emitted - outside.emittedMass * floorEnergy_ + gained_;
  const double cameIn = outside.sum() + report.workByMovedBodies + report.workByLoads;
  error_ = report.energy.total() + report.dissipated - heatAtStart_ - energyAtStart_ - cameIn;
  if (fraction() > worst_) {
    worst_ = fraction();
    worstTime_ = report.time;
  }
}

double EnergyBalance::fraction() const {
  return putIn_ > 0.0 ? std::abs(error_) / putIn_ : 0.0;
}

}  // namespace granular_demo
