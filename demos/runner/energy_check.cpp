// SPDX-License-Identifier: MIT
#include "demos/runner/energy_check.h"

#include <algorithm>

namespace granular_demo {

void EnergyCheck::add(const granular::StepReport& report, double cameIn) {
  last_ = report.energy.total() - report.workByMovedBodies - report.workByLoads - cameIn;
  largestKinetic_ = std::max(largestKinetic_, report.energy.kinetic);
  if (!started_) {
    started_ = true;
    first_ = lowest_ = last_;
    return;
  }
  lowest_ = std::min(lowest_, last_);
  const double rise = last_ - lowest_;
  worstRise_ = std::max(worstRise_, rise);
  const double fallen = std::max(first_ - lowest_, 1e-3 * largestKinetic_);
  const double fraction = rise > 0.0 ? rise / fallen : 0.0;
  if (fraction > worstFraction_) {
    worstFraction_ = fraction;
    worstTime_ = report.time;
  }
}

}  // namespace granular_demo
