// SPDX-License-Identifier: MIT
#include "granular/dynamics/kick_drift.h"

#include <algorithm>

namespace granular {
namespace {

constexpr std::int64_t kNumbersPerPiece = 8192;  // of the state, handed to a thread at a time

}  // namespace

void KickDrift::trial(Equations& equations, const std::vector<double>& y, double t, double h) {
  result_.resize(y.size());
  lastRate_.resize(rateSize(equations, y));
  equations.drift(
      {.time = h, .poseKick = table_.poseKick * h, .kick = table_.kick * h, .memory = table_.memory * h}, y,
      firstRate_, result_);
  if (const double p = weightOfBefore(h); p > 0.0) {
    equations.kick(y, (1.0 - p) * table_.kick * h, firstRate_, p * table_.kick * h, rateBefore_, result_);
  }
  equations.evaluate(
      {.time = t + h, .sinceTrial = h, .memoryStep = table_.memoryStep * h, .poseRates = needsPoseRates()},
      result_, lastRate_);
  equations.kick(y, table_.first * h, firstRate_, table_.second * h, lastRate_, result_);
  if (table_.errorOrder == 0) return;
  errors_.resize(equations.errorCount(y));
  estimateError(equations.executor(), h);
  error_ = errors_;
}

/// Part of the acceleration before in the prediction: the least that bears the damping to be expected.
double KickDrift::weightOfBefore(double h) const {
  constexpr double kMost = 0.25;  // more would bear less again
  const double damping = dampingRate_ * h;
  if (!(lengthBefore_ > 0.0) || !(damping > table_.dampingLimit)) return 0.0;
  return std::min(kMost, 0.5 * (1.0 - table_.dampingLimit / damping));
}

/// What the trapezoidal rule leaves out, h^3/12 of the second derivative of the rate, which is taken from the
/// rates at the last three states; from two of them where there is none before.
void KickDrift::estimateError(const Executor& executor, double h) {
  const bool known = lengthBefore_ > 0.0;
  const double scale = known ? h * h / (6.0 * (h + lengthBefore_)) : h / 12.0;
  const double ratio = known ? h / lengthBefore_ : 0.0;
  const double* before = known ? rateBefore_.data() : firstRate_.data();
  executor.forRanges(
      static_cast<std::int64_t>(errors_.size()), kNumbersPerPiece, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i) {
          errors_[i] = scale * (lastRate_[i] - firstRate_[i] - ratio * (firstRate_[i] - before[i]));
        }
      });
}

bool KickDrift::accept(double h) {
  if (table_.errorOrder > 0) {
    rateBefore_.swap(firstRate_);
    lengthBefore_ = h;
  }
  firstRate_.swap(lastRate_);
  return true;
}

}  // namespace granular
