// SPDX-License-Identifier: MIT
#include "granular/dynamics/rkf45.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "granular/dynamics/step_control.h"

namespace granular {
namespace {

const auto oscillator = [](double, const std::vector<double>& y, std::vector<double>& rate) {
  rate[0] = y[1];
  rate[1] = -y[0];
};

/// Error of one step of the oscillator from (1, 0), and of its estimate.
std::pair<double, double> oneStep(double h) {
  Rkf45 stepper;
  const std::vector<double> y{1.0, 0.0};
  const Executor one(1);
  stepper.start(y, 0.0, oscillator);
  stepper.trial(y, 0.0, h, one, oscillator);
  return {std::hypot(stepper.result()[0] - std::cos(h), stepper.result()[1] + std::sin(h)),
          std::hypot(stepper.error()[0], stepper.error()[1])};
}

TEST(Rkf45, TableSatisfiesTheConditionsOfAButcherTable) {
  using T = Rkf45Table;
  double sum5 = 0.0, sum4 = 0.0;
  for (int s = 0; s < T::kStages; ++s) {
    double row = 0.0;
    for (int j = 0; j < s; ++j) row += T::a[s][j];
    EXPECT_NEAR(row, T::c[s], 1e-15);
    sum5 += T::b5[s];
    sum4 += T::b4[s];
  }
  EXPECT_NEAR(sum5, 1.0, 1e-15);
  EXPECT_NEAR(sum4, 1.0, 1e-15);
}

TEST(Rkf45, ErrorEstimateFallsWithTheFifthPowerOfTheStep) {
  const double order = std::log2(oneStep(0.2).second / oneStep(0.1).second);
  EXPECT_NEAR(order, 5.0, 0.1);
}

TEST(Rkf45, LocalErrorFallsWithTheSixthPowerOfTheStep) {
  const double order = std::log2(oneStep(0.4).first / oneStep(0.2).first);
  EXPECT_NEAR(order, 6.0, 0.15);
}

TEST(Rkf45, GlobalErrorFallsWithTheFifthPowerOfTheStep) {
  const auto errorAfterOneTurn = [](int steps) {
    Rkf45 stepper;
    const Executor one(1);
    std::vector<double> y{1.0, 0.0};
    const double h = 2.0 * std::numbers::pi / steps;
    for (int i = 0; i < steps; ++i) {
      stepper.start(y, i * h, oscillator);
      stepper.trial(y, i * h, h, one, oscillator);
      y = stepper.result();
    }
    return std::hypot(y[0] - 1.0, y[1]);
  };
  EXPECT_NEAR(std::log2(errorAfterOneTurn(20) / errorAfterOneTurn(40)), 5.0, 0.2);
}

TEST(Rkf45, RejectedTrialLeavesTheStateUntouched) {
  Rkf45 stepper;
  const Executor one(1);
  const std::vector<double> y{1.0, 0.0};
  stepper.start(y, 0.0, oscillator);
  stepper.trial(y, 0.0, 3.0, one, oscillator);  // far too long
  stepper.trial(y, 0.0, 0.1, one, oscillator);
  Rkf45 fresh;
  fresh.start(y, 0.0, oscillator);
  fresh.trial(y, 0.0, 0.1, one, oscillator);
  EXPECT_EQ(y, (std::vector<double>{1.0, 0.0}));
  EXPECT_EQ(stepper.result(), fresh.result());
}

TEST(Rkf45, SeesTheTimeOfEachStage) {
  // y' = 5 t^4 is integrated exactly by a method of order five.
  const auto power = [](double t, const std::vector<double>&, std::vector<double>& rate) {
    rate[0] = 5.0 * std::pow(t, 4);
  };
  Rkf45 stepper;
  const Executor one(1);
  stepper.start({0.0}, 1.0, power);
  stepper.trial({0.0}, 1.0, 0.5, one, power);
  EXPECT_NEAR(stepper.result()[0], std::pow(1.5, 5) - 1.0, 1e-12);
}

TEST(StepControl, AcceptsWithinToleranceOnly) {
  StepControl control(5);
  EXPECT_TRUE(control.judge(0.1, 1.0));
  EXPECT_FALSE(control.judge(0.1, 1.0001));
  EXPECT_FALSE(control.judge(0.1, std::nan("")));
}

TEST(StepControl, AimsAtTheAllowedError) {
  StepControl control(5);
  control.judge(0.1, 32.0);  // five halvings of the error are one of the step
  EXPECT_NEAR(control.propose(1.0, 1.0), 0.9 * 0.05, 1e-12);
}

TEST(StepControl, LeavesNoTinyLastSubStep) {
  StepControl control(5);
  control.shorten(0.1);
  EXPECT_DOUBLE_EQ(control.propose(0.101, 1.0), 0.0505);
  EXPECT_DOUBLE_EQ(control.propose(0.1, 1.0), 0.1);
  EXPECT_DOUBLE_EQ(control.propose(0.5, 1.0), 0.1);
}

}  // namespace
}  // namespace granular
