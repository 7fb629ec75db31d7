// SPDX-License-Identifier: MIT
// Embedded explicit Runge-Kutta pairs on a plain vector of doubles. Which one is a table:
// Runge-Kutta-Fehlberg 4(5) (Fehlberg 1969; Bell 2005, sec. 3.4) or Bogacki & Shampine 1989, 3(2). The answer
// of higher order is carried on (local extrapolation), its difference from the other one is the error.
#pragma once

#include <array>
#include <span>

#include "granular/dynamics/step_method.h"

namespace granular {

/// Butcher table of an embedded pair of at most six stages.
struct RungeKuttaTable {
  static constexpr int kMostStages = 6;
  int stages;
  int errorOrder;         ///< the error estimate falls with this power of the step
  bool lastIsFirst;       ///< the last stage is the rate of the answer: the first of the next trial
  double dampingLimit;    ///< as StepMethod::dampingLimit: where its stability polynomial leaves [-1, 1]
  double c[kMostStages];  ///< when, in steps
  double a[kMostStages][kMostStages - 1];
  double b[kMostStages];      ///< the answer
  double other[kMostStages];  ///< the one it is compared with
};

/// The second stage has weight zero in both answers: see StepControl on what follows.
inline constexpr RungeKuttaTable kRkf45{
    .stages = 6,
    .errorOrder = 5,
    .lastIsFirst = false,
    .dampingLimit = 3.0,
    .c = {0.0, 1.0 / 4, 3.0 / 8, 12.0 / 13, 1.0, 1.0 / 2},
    .a = {{},
          {1.0 / 4},
          {3.0 / 32, 9.0 / 32},
          {1932.0 / 2197, -7200.0 / 2197, 7296.0 / 2197},
          {439.0 / 216, -8.0, 3680.0 / 513, -845.0 / 4104},
          {-8.0 / 27, 2.0, -3544.0 / 2565, 1859.0 / 4104, -11.0 / 40}},
    .b = {16.0 / 135, 0.0, 6656.0 / 12825, 28561.0 / 56430, -9.0 / 50, 2.0 / 55},
    .other = {25.0 / 216, 0.0, 1408.0 / 2565, 2197.0 / 4104, -1.0 / 5, 0.0}};

inline constexpr RungeKuttaTable kBogackiShampine{
    .stages = 4,
    .errorOrder = 3,
    .lastIsFirst = true,
    .dampingLimit = 2.5,
    .c = {0.0, 1.0 / 2, 3.0 / 4, 1.0},
    .a = {{}, {1.0 / 2}, {0.0, 3.0 / 4}, {2.0 / 9, 1.0 / 3, 4.0 / 9}},
    .b = {2.0 / 9, 1.0 / 3, 4.0 / 9, 0.0},
    .other = {7.0 / 24, 1.0 / 4, 1.0 / 3, 1.0 / 8}};

class RungeKutta final : public StepMethod {
 public:
  explicit RungeKutta(const RungeKuttaTable& table) : table_(table) {}

  void trial(Equations& equations, const std::vector<double>& y, double t, double h, Goal goal) override;
  bool accept(double h) override;
  int errorOrder() const override { return table_.errorOrder; }
  double dampingLimit() const override { return table_.dampingLimit; }

 private:
  /// out = start + h sum_s weights[s] rate_s over the first out.size() numbers; start may be null, out one of
  /// the rates.
  void combine(const Executor& executor, const double* start, double h, const double* weights,
               std::span<double> out) const;
  const double* rate(int stage) const {
    return stage == 0 ? firstRate_.data() : laterRates_[stage - 1].data();
  }

  const RungeKuttaTable& table_;
  std::array<std::vector<double>, RungeKuttaTable::kMostStages - 1> laterRates_;
};

}  // namespace granular
