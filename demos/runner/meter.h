// SPDX-License-Identifier: MIT
// Meters: what a scene's file asks to be measured of its outcome, in numbers.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "demos/world/built_scene.h"

namespace granular_demo {

/// One meter of a running scene, made before its first tick.
class Meter {
 public:
  virtual ~Meter() = default;
  /// Numbers of each frame, by name.
  virtual std::vector<std::string> columns() const = 0;
  /// After every tick.
  virtual void tick() = 0;
  /// After every frame: as many numbers as there are columns.
  virtual std::vector<double> frame() = 0;
  /// What has come out so far.
  virtual std::vector<std::pair<std::string, double>> results() const = 0;
};

/// The scene must outlive the meter.
std::unique_ptr<Meter> makeMeter(const MeterPart& part, const BuiltScene& scene);

std::unique_ptr<Meter> makeFlowMeter(const FlowMeterDef& def, const BuiltScene& scene);
std::unique_ptr<Meter> makeRingMeter(const RingMeterDef& def, const BuiltScene& scene);
std::unique_ptr<Meter> makeDisplacementMeter(const DisplacementMeterDef& def, const BuiltScene& scene);
std::unique_ptr<Meter> makePushMeter(const PushMeterDef& def, const BuiltScene& scene);

/// The body of that name, or all its copies.
std::vector<const BuiltBody*> bodiesNamed(const BuiltScene& scene, const std::string& name);

}  // namespace granular_demo
