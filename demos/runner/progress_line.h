// SPDX-License-Identifier: MIT
// How far a run is, on standard error: a bar that moves on a terminal, a plain line about once a second
// elsewhere.
#pragma once

#include <chrono>
#include <string>

#include "demos/runner/run_scene.h"

namespace granular_demo {

class ProgressLine {
 public:
  ProgressLine();
  void update(const RunProgress& progress);
  void finish();  ///< ends the bar's line

 private:
  using Clock = std::chrono::steady_clock;

  bool isTerminal_;
  Clock::time_point start_;
  Clock::time_point lastLine_;
  bool hasBar_ = false;
};

/// "1:05" or "2:01:05"
std::string clockText(double seconds);

}  // namespace granular_demo
