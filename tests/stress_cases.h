// SPDX-License-Identifier: MIT
// Scenes that drive a granular system to its limits: extreme stiffnesses, masses, sizes, speeds, steps and
// starting states. Each says what must hold, from closed forms or from what may never happen.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "granular/system/step_report.h"

namespace granular::stress {

/// What one scene did. Largest or worst over all its steps.
struct Outcome {
  double measured = 0.0;        ///< what the case is about, against `lowest` and `highest` of the case
  double largestOverlap = 0.0;  ///< in smaller radii of the pair
  double energyRatio = 0.0;    ///< highest mechanical energy over that of the start, after work was taken off
  double momentumDrift = 0.0;  ///< change without outside forces over sum m v, at the end; 0 with such forces
  double shortestSubStep = 0.0;  ///< s
  std::int64_t notFinite = 0;    ///< motions in the state at the end
  std::int64_t escaped = 0;      ///< grains where none may be
  StepFlag flags = StepFlag::None;
};

struct Case {
  std::string name;
  std::string setUp;        ///< one line
  std::string expectation;  ///< one line, what `measured` is and why it lies in [lowest, highest]
  double lowest = 0.0, highest = 0.0;
  double highestEnergyRatio = 0.0;        ///< 0: not asked
  StepFlag wantedFlags = StepFlag::None;  ///< these and no others
  bool isQuick = false;                   ///< below a second: also run by ctest
  std::function<Outcome()> run;
};

/// Empty if the outcome is what the case expects; else one line per thing that is not, with the setting to
/// change where a step reported one.
std::vector<std::string> complaints(const Case& stressCase, const Outcome& outcome);

std::vector<Case> allCases();

}  // namespace granular::stress
