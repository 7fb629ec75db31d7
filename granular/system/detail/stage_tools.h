// SPDX-License-Identifier: MIT
// Small things that the stages of an evaluation share.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <vector>

#include "granular/system/step_report.h"

namespace granular::detail {

/// Adds its own lifetime to a stage's wall time, s.
class StageTimer {
 public:
  explicit StageTimer(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~StageTimer() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  StageTimer(const StageTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

/// Shares the time that one piece of work takes out to the stages it goes through.
class PieceClock {
 public:
  explicit PieceClock(StageSeconds& seconds) : seconds_(seconds), last_(std::chrono::steady_clock::now()) {}
  /// What was done since the last call, or the beginning, belongs to this stage.
  void done(Stage stage) {
    const auto now = std::chrono::steady_clock::now();
    seconds_[static_cast<int>(stage)] += std::chrono::duration<double>(now - last_).count();
    last_ = now;
  }

 private:
  StageSeconds& seconds_;
  std::chrono::steady_clock::time_point last_;
};

/// Largest of the first `count` values, none < 0.
inline double maximum(const std::vector<double>& values, std::int32_t count) {
  double largest = 0.0;
  for (std::int32_t i = 0; i < count; ++i) largest = std::max(largest, values[i]);
  return largest;
}

}  // namespace granular::detail
