// SPDX-License-Identifier: MIT
// What the steps of a run add up to.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "granular/system/step_report.h"

namespace granular_demo {

struct RunTotals {
  granular::StepFlag flags = granular::StepFlag::None;
  std::int64_t ticks = 0;
  std::int64_t subSteps = 0;
  std::int64_t rejectedTrials = 0;
  std::int64_t evaluations = 0;
  std::int64_t listRebuilds = 0;
  std::int64_t quarantined = 0;
  std::int64_t largestContacts = 0;
  double shortestSubStep = 0.0;     ///< s
  double largestOverlap = 0.0;      ///< in smaller radii of the pair
  double largestOverlapTime = 0.0;  ///< s
  std::array<double, granular::kStageCount> stageSeconds{};

  void add(const granular::StepReport& report) {
    flags = flags | report.flags;
    if (ticks == 0 || report.shortestSubStep < shortestSubStep) shortestSubStep = report.shortestSubStep;
    ++ticks;
    subSteps += report.subSteps;
    rejectedTrials += report.rejectedTrials;
    evaluations += report.evaluations;
    listRebuilds += report.listRebuilds;
    quarantined += report.quarantined;
    largestContacts = std::max(largestContacts, report.contacts);
    if (report.largestOverlap > largestOverlap) {
      largestOverlap = report.largestOverlap;
      largestOverlapTime = report.time;
    }
    for (int i = 0; i < granular::kStageCount; ++i) stageSeconds[i] += report.stageSeconds[i];
  }
};

}  // namespace granular_demo
