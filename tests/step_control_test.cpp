// SPDX-License-Identifier: MIT
#include "granular/dynamics/step_control.h"

#include <gtest/gtest.h>

#include <cmath>

namespace granular {
namespace {

TEST(StepControl, AcceptsWithinToleranceOnly) {
  StepControl control(5);
  EXPECT_TRUE(control.judge(0.1, 1.0));
  EXPECT_FALSE(control.judge(0.1, 1.0001));
  EXPECT_FALSE(control.judge(0.1, std::nan("")));
}

TEST(StepControl, AimsAtAQuarterOfTheAllowedErrorByOrderFive) {
  StepControl control(5);
  control.judge(0.1, 32.0);  // five halvings of the error are one of the step
  EXPECT_NEAR(32.0 * std::pow(control.propose(1.0, 1.0) / 0.1, 5), 0.25, 0.01);
}

TEST(StepControl, AimsBelowTheAllowedErrorByAnyOrder) {
  for (const int order : {2, 3, 5}) {
    StepControl control(order);
    control.judge(0.1, 2.0);
    const double next = control.propose(1.0, 1.0);
    EXPECT_LT(2.0 * std::pow(next / 0.1, order), 1.0) << order;
  }
}

TEST(StepControl, LeavesNoTinyLastSubStep) {
  StepControl control(5);
  control.shorten(0.1);
  EXPECT_DOUBLE_EQ(control.propose(0.101, 1.0), 0.0505);
  EXPECT_DOUBLE_EQ(control.propose(0.1, 1.0), 0.1);
  EXPECT_DOUBLE_EQ(control.propose(0.5, 1.0), 0.1);
}

TEST(StepControl, GoesToTheBoundWhereThereIsNoErrorEstimate) {
  StepControl control(0);
  EXPECT_DOUBLE_EQ(control.propose(1.0, 0.1), 0.1);
  EXPECT_TRUE(control.judge(0.1, 0.0));
  EXPECT_DOUBLE_EQ(control.propose(1.0, 0.2), 0.2);
}

}  // namespace
}  // namespace granular
