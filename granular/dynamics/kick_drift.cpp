// SPDX-License-Identifier: MIT
#include "granular/dynamics/kick_drift.h"

#include <algorithm>
#include <array>

namespace granular {
namespace {

constexpr std::int64_t kNumbersPerPiece = 8192;  // of the state, handed to a thread at a time

}  // namespace

void KickDrift::trial(Equations& equations, const std::vector<double>& y, double t, double h, Goal goal) {
  result_.resize(y.size());
  lastRate_.resize(rateSize(equations, y));
  equations.drift(
      {.time = h, .poseKick = table_.poseKick * h, .kick = table_.kick * h, .memory = table_.memory * h}, y,
      firstRate_, result_);
  keepsMomenta_ = table_.errorOrder > 0 && goal == Goal::Accuracy && !equations.hasMemory();
  const auto momentaOf = [&](const std::vector<double>& state, std::vector<double>& momenta) {
    momenta.assign(state.begin() + static_cast<std::ptrdiff_t>(equations.poseCount()), state.end());
  };
  if (keepsMomenta_ && isFresh()) {  // the first rate is that of y itself
    momentaOf(y, momenta_);
    predictions_ = 1;
  }
  const bool takesErrorOff = keepsMomenta_ && predictions_ == 2 && lengthBefore_ > 0.0;
  if (takesErrorOff) {
    equations.predict({.h = h,
                       .ratio = h / lengthBefore_,
                       .rate = &firstRate_,
                       .rateBefore = &rateBefore_,
                       .momenta = &momenta_,
                       .momentaBefore = &momentaBefore_},
                      y, result_);
  } else if (const double p = weightOfBefore(h); p != 0.0) {
    equations.kick(y,
                   std::array<RateTerm, 2>{
                       {{(1.0 - p) * table_.kick * h, &firstRate_}, {p * table_.kick * h, &rateBefore_}}},
                   result_);
  }
  if (keepsMomenta_) momentaOf(result_, lastMomenta_);
  equations.evaluate({.time = t + h,
                      .sinceTrial = h,
                      .memoryStep = table_.memoryStep * h,
                      .poseRates = needsPoseRates(),
                      .memoryRates = needsMemoryRates()},
                     result_, lastRate_);
  if (takesErrorOff) {
    takeErrorOff(equations, y, h);
  } else {
    equations.kick(
        y, std::array<RateTerm, 2>{{{table_.first * h, &firstRate_}, {table_.second * h, &lastRate_}}},
        result_);
  }
  error_ = {};
  if (table_.errorOrder == 0 || goal == Goal::FixedStep) return;
  errors_.resize(equations.errorCount(y) - lackingOf(lastRate_, y));
  estimateError(equations.executor(), h);
  error_ = errors_;
}

/// Of the acceleration before in leapfrog's own prediction: as much as damping asks for.
double KickDrift::weightOfBefore(double h) const {
  constexpr double kMost = 0.25;  // more would bear less again
  const double damping = dampingRate_ * h;
  if (!(lengthBefore_ > 0.0) || !(damping > table_.dampingLimit)) return 0.0;
  return std::min(kMost, 0.5 * (1.0 - table_.dampingLimit / damping));
}

/// The step by the parabola through the accelerations before, at the start and at the end.
void KickDrift::takeErrorOff(Equations& equations, const std::vector<double>& y, double h) {
  const double H = lengthBefore_, span = h * h / (h + H);
  // The parabola's curvature times h^2: lastRate / h - firstRate (1 / h + 1 / H) + rateBefore / H, times
  // span.
  const double last = span / h, first = -span * (1.0 / h + 1.0 / H), before = span / H;
  const auto terms = [&](double ofFirst, double ofLast, double ofCurvature) {
    return std::array<RateTerm, 3>{{{ofFirst + ofCurvature * first, &firstRate_},
                                    {ofLast + ofCurvature * last, &lastRate_},
                                    {ofCurvature * before, &rateBefore_}}};
  };
  equations.kick(y, terms(h / 2.0, h / 2.0, -h / 6.0), result_);
  equations.carry(terms(-h * h / 6.0, h * h / 6.0, -h * h / 12.0), result_);
}

/// What the trapezoidal rule leaves out, h^3/12 of the second derivative of the rate, which is taken from the
/// rates at the last three states; from two of them where there is none before.
void KickDrift::estimateError(const Executor& executor, double h) {
  const bool known = lengthBefore_ > 0.0;
  const double scale = known ? h * h / (6.0 * (h + lengthBefore_)) : h / 12.0;
  const double ratio = known ? h / lengthBefore_ : 0.0;
  const double* before = known ? rateBefore_.data() : firstRate_.data();
  const auto numbers = static_cast<std::int64_t>(errors_.size());
  executor.forRanges(numbers, kNumbersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      errors_[i] = scale * ((lastRate_[i] - firstRate_[i]) - ratio * (firstRate_[i] - before[i]));
    }
  });
}

bool KickDrift::accept(double h) {
  if (table_.errorOrder > 0) {
    rateBefore_.swap(firstRate_);
    lengthBefore_ = h;
    momentaBefore_.swap(momenta_);
    momenta_.swap(lastMomenta_);
    predictions_ = keepsMomenta_ ? std::min(2, predictions_ + 1) : 0;
  }
  firstRate_.swap(lastRate_);
  return true;
}

}  // namespace granular
