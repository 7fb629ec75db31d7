// SPDX-License-Identifier: MIT
#include "granular/dynamics/kick_drift.h"

#include <algorithm>
#include <array>
#include <numeric>

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
  const Plan plan = this->plan(h, goal == Goal::Accuracy && !equations.hasMemory());
  if (const double p = plan.weightOfBefore; p != 0.0) {
    equations.kick(y,
                   std::array<RateTerm, 2>{
                       {{(1.0 - p) * table_.kick * h, &firstRate_}, {p * table_.kick * h, &rateBefore_}}},
                   result_);
  }
  equations.evaluate({.time = t + h,
                      .sinceTrial = h,
                      .memoryStep = table_.memoryStep * h,
                      .poseRates = needsPoseRates(),
                      .memoryRates = needsMemoryRates()},
                     result_, lastRate_);
  if (plan.takesErrorOff) {
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

KickDrift::Plan KickDrift::plan(double h, bool mayTakeErrorOff) const {
  constexpr double kMost = 0.25;           // of the acceleration before; more would bear less again
  constexpr double kCorrectedLimit = 1.1;  // as above, of trials whose error is taken off
  constexpr double kMargin = 1.1;          // dense packings may be damped more than expected
  if (!(lengthBefore_ > 0.0)) return {};
  const bool isCareful = carefulTrials_ > 0;
  const double damping = dampingRate_ * h * (isCareful ? 2.0 : 1.0);
  if (table_.errorOrder > 0 && mayTakeErrorOff && !isCareful && kMargin * damping < kCorrectedLimit) {
    const double extrapolation = std::min(0.5, (kCorrectedLimit / (kMargin * damping) - 1.0) / 2.2);
    return {.weightOfBefore = -extrapolation * h / lengthBefore_, .takesErrorOff = true};
  }
  if (!(damping > table_.dampingLimit)) return {};
  return {.weightOfBefore = std::min(kMost, 0.5 * (1.0 - table_.dampingLimit / damping))};
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
  swingsOfPiece_.assign(Executor::pieceCount(numbers, kNumbersPerPiece), {});
  executor.forRanges(numbers, kNumbersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    std::array<double, 8> back{}, forth{};  // several sums, which need not wait for one another
    const auto look = [&](std::int64_t i, std::size_t k) {
      const double now = lastRate_[i] - firstRate_[i], then = ratio * (firstRate_[i] - before[i]);
      errors_[i] = scale * (now - then);
      back[k] -= now * then;
      forth[k] += then * then;
    };
    std::int64_t i = begin;
    for (; i + 8 <= end; i += 8) {
      for (std::size_t k = 0; k < 8; ++k) look(i + static_cast<std::int64_t>(k), k);
    }
    for (; i < end; ++i) look(i, 0);
    swingsOfPiece_[begin / kNumbersPerPiece] = {.forth = std::accumulate(forth.begin(), forth.end(), 0.0),
                                                .back = std::accumulate(back.begin(), back.end(), 0.0)};
  });
}

/// Whether accelerations swing back and forth, from step to step by almost as much: the sign of a damping
/// that the steps do not bear.
bool KickDrift::swings() {
  // What moves smoothly goes on as it did: -0.9 or so in a flow. A bed at rest that trembles: 0.5 and more,
  // one in which little else moves.
  constexpr double kShare = -0.2;
  // Where the change of a rate itself changes its sign it does so once, and is small: some trials together
  // tell.
  constexpr double kStaysKnown = 0.75;
  swings_.back *= kStaysKnown, swings_.forth *= kStaysKnown;
  for (const Swings& piece : swingsOfPiece_) {
    swings_.back += piece.back;
    swings_.forth += piece.forth;
  }
  return swings_.back > kShare * swings_.forth;
}

bool KickDrift::accept(double h) {
  if (table_.errorOrder > 0) {
    constexpr int kCareful = 64;
    carefulTrials_ = swings() ? kCareful : std::max(0, carefulTrials_ - 1);
    rateBefore_.swap(firstRate_);
    lengthBefore_ = h;
  }
  firstRate_.swap(lastRate_);
  return true;
}

}  // namespace granular
