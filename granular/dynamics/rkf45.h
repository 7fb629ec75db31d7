// SPDX-License-Identifier: MIT
// One trial of Runge-Kutta-Fehlberg 4(5) (Fehlberg 1969; Bell 2005, sec. 3.4) on a plain vector of doubles.
// Knows nothing of grains and accepts nothing: the controller does. The fifth-order answer is carried on
// (local extrapolation), its difference from the fourth-order one is the error.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "granular/base/parallel.h"

namespace granular {

/// Butcher table of RKF45. The second stage has weight zero in both answers: see StepControl on what follows.
struct Rkf45Table {
  static constexpr int kStages = 6;
  static constexpr int kErrorOrder = 5;  ///< the error estimate falls with this power of the step
  static constexpr double c[6] = {0.0, 1.0 / 4, 3.0 / 8, 12.0 / 13, 1.0, 1.0 / 2};
  static constexpr double a[6][5] = {{},
                                     {1.0 / 4},
                                     {3.0 / 32, 9.0 / 32},
                                     {1932.0 / 2197, -7200.0 / 2197, 7296.0 / 2197},
                                     {439.0 / 216, -8.0, 3680.0 / 513, -845.0 / 4104},
                                     {-8.0 / 27, 2.0, -3544.0 / 2565, 1859.0 / 4104, -11.0 / 40}};
  static constexpr double b5[6] = {16.0 / 135, 0.0, 6656.0 / 12825, 28561.0 / 56430, -9.0 / 50, 2.0 / 55};
  static constexpr double b4[6] = {25.0 / 216, 0.0, 1408.0 / 2565, 2197.0 / 4104, -1.0 / 5, 0.0};
};

class Rkf45 {
 public:
  /// First stage of a trial from y at time t, kept for every trial that starts there.
  /// rate(stage time, state, rate of state) fills its last argument.
  template <class Rate>
  void start(const std::vector<double>& y, double t, Rate&& rate) {
    rates_[0].resize(y.size());
    rate(t, y, rates_[0]);
  }

  /// Tries the step from (y, t), where start() was called, to t + h. Changes nothing but result() and
  /// error().
  template <class Rate>
  void trial(const std::vector<double>& y, double t, double h, const Executor& executor, Rate&& rate) {
    using T = Rkf45Table;
    resize(y.size());
    for (int s = 1; s < T::kStages; ++s) {
      combine(executor, y, h, T::a[s], s, stage_);
      rate(t + T::c[s] * h, stage_, rates_[s]);
    }
    combine(executor, y, h, T::b5, T::kStages, result_);
    estimateError(executor, h);
  }

  std::vector<double>& firstRate() { return rates_[0]; }       ///< as start() left it
  std::vector<double>& result() { return result_; }            ///< state at t + h
  const std::vector<double>& error() const { return error_; }  ///< fifth minus fourth order, same units

 private:
  static constexpr std::int64_t kGrain = 8192;  // doubles a piece of work

  void resize(std::size_t size) {
    if (result_.size() == size) return;
    for (auto& rate : rates_) rate.resize(size);
    stage_.resize(size);
    result_.resize(size);
    error_.resize(size);
  }

  void combine(const Executor& executor, const std::vector<double>& y, double h, const double* weights,
               int stages, std::vector<double>& out) const;
  void estimateError(const Executor& executor, double h);

  std::array<std::vector<double>, Rkf45Table::kStages> rates_;
  std::vector<double> stage_, result_, error_;
};

}  // namespace granular
