// SPDX-License-Identifier: MIT
#include "granular/dynamics/runge_kutta.h"

#include <algorithm>

namespace granular {
namespace {

constexpr std::int64_t kNumbersPerPiece = 8192;  // of the state, handed to a thread at a time
constexpr std::int64_t kNumbersAtOnce = 1024;    // that stay in the nearest cache from term to term

}  // namespace

void RungeKutta::combine(const Executor& executor, const double* start, double h, const double* weights,
                         std::span<double> out) const {
  const auto size = static_cast<std::int64_t>(out.size());
  executor.forRanges(size, kNumbersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    double sums[kNumbersAtOnce];
    for (std::int64_t from = begin; from < end; from += kNumbersAtOnce) {
      const std::int64_t count = std::min(kNumbersAtOnce, end - from);
      std::fill_n(sums, count, 0.0);
      for (int s = 0; s < table_.stages; ++s) {
        if (weights[s] == 0.0) continue;
        const double w = weights[s];
        const double* k = rate(s) + from;
        for (std::int64_t i = 0; i < count; ++i) sums[i] += w * k[i];
      }
      double* to = out.data() + from;
      for (std::int64_t i = 0; i < count; ++i) to[i] = start ? start[from + i] + h * sums[i] : h * sums[i];
    }
  });
}

void RungeKutta::trial(Equations& equations, const std::vector<double>& y, double t, double h, Goal goal) {
  const Executor& executor = equations.executor();
  result_.resize(y.size());
  for (int s = 1; s < table_.stages; ++s) {
    double weights[RungeKuttaTable::kMostStages] = {};
    std::copy_n(table_.a[s], s, weights);
    combine(executor, y.data(), h, weights, result_);
    laterRates_[s - 1].resize(y.size());
    const double since = table_.c[s] * h;
    equations.evaluate({.time = t + since, .sinceTrial = since}, result_, laterRates_[s - 1]);
  }
  combine(executor, y.data(), h, table_.b, result_);
  equations.finish(y, h, result_);
  error_ = {};
  if (goal == Goal::FixedStep) return;
  double difference[RungeKuttaTable::kMostStages];
  for (int s = 0; s < RungeKuttaTable::kMostStages; ++s) difference[s] = table_.b[s] - table_.other[s];
  // In place of the second rate, which nobody wants any more.
  const std::span<double> error = std::span(laterRates_[0]).first(equations.errorCount(y));
  combine(executor, nullptr, h, difference, error);
  error_ = error;
}

bool RungeKutta::accept(double) {
  if (table_.lastIsFirst) firstRate_.swap(laterRates_[table_.stages - 2]);
  return table_.lastIsFirst;
}

}  // namespace granular
