// SPDX-License-Identifier: MIT
// The energy of sand only ever falls. What the integrator adds by error shows as a rise above the lowest
// value so far.
#pragma once

#include "granular/system/step_report.h"

namespace granular_demo {

/// E = kinetic + gravitational + elastic energy of grains and dynamic bodies, less the work of moved bodies
/// and of the host's loads and what came in otherwise (emitters, joints). Its rise above its running minimum
/// is told as a fraction of the energy fallen so far: energy at the start less running minimum. Until
/// something has fallen, a thousandth of the largest kinetic energy seen takes the place of the fall, so that
/// rounding in free flight is not divided by nothing.
class EnergyCheck {
 public:
  /// Call once with the state at the start and then after every tick.
  /// `cameIn`: energy that came in by ways the core does not count, J, since the start.
  void add(const granular::StepReport& report, double cameIn = 0.0);

  double first() const { return first_; }             ///< E at the start, J
  double last() const { return last_; }               ///< E now, J
  double fallen() const { return first_ - lowest_; }  ///< J
  double worstRise() const { return worstRise_; }     ///< J, above the running minimum
  double worstFraction() const { return worstFraction_; }
  double worstTime() const { return worstTime_; }  ///< s, of the worst fraction

 private:
  bool started_ = false;
  double first_ = 0.0, last_ = 0.0, lowest_ = 0.0;
  double largestKinetic_ = 0.0;
  double worstRise_ = 0.0, worstFraction_ = 0.0, worstTime_ = 0.0;
};

}  // namespace granular_demo
