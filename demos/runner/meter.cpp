// SPDX-License-Identifier: MIT
#include "demos/runner/meter.h"

namespace granular_demo {

std::unique_ptr<Meter> makeMeter(const MeterPart& part, const BuiltScene& scene) {
  if (const auto* def = std::get_if<FlowMeterDef>(&part.def)) return makeFlowMeter(*def, scene);
  if (const auto* def = std::get_if<RingMeterDef>(&part.def)) return makeRingMeter(*def, scene);
  if (const auto* def = std::get_if<DisplacementMeterDef>(&part.def))
    return makeDisplacementMeter(*def, scene);
  return makePushMeter(std::get<PushMeterDef>(part.def), scene);
}

std::vector<const BuiltBody*> bodiesNamed(const BuiltScene& scene, const std::string& name) {
  std::vector<const BuiltBody*> found;
  for (const BuiltBody& body : scene.bodies()) {
    if (body.part->name == name || body.part->group == name) found.push_back(&body);
  }
  return found;
}

}  // namespace granular_demo
