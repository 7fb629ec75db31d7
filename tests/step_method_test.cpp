// SPDX-License-Identifier: MIT
#include "granular/dynamics/step_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "granular/dynamics/runge_kutta.h"

namespace granular {
namespace {

/// A mass on a spring and a damper: y = (x, v), x' = v, v' = -k x - c v.
class Oscillator : public Equations {
 public:
  /// known: how much of the damping predictions know of.
  explicit Oscillator(double damping = 0.0, double stiffness = 1.0, double known = 1.0)
      : damping_(damping), stiffness_(stiffness), knownDamping_(known * damping) {}

  void evaluate(const Moment&, const std::vector<double>& y, std::vector<double>& rate) override {
    ++evaluations;
    const std::size_t lacking = lackingOf(rate, y);
    if (lacking == 0) rate[0] = y[1];
    rate[1 - lacking] = -stiffness_ * y[0] - damping_ * y[1];
  }
  void drift(const Drift& drift, const std::vector<double>& y, const std::vector<double>& rate,
             std::vector<double>& to) override {
    to[0] = y[0] + drift.time * (y[1] + drift.poseKick * rate.back());
    to[1] = y[1] + drift.kick * rate.back();
  }
  void kick(const std::vector<double>& y, std::span<const RateTerm> terms, std::vector<double>& to) override {
    to[1] = y[1];
    for (const RateTerm& term : terms) to[1] += term.weight * term.rate->back();
  }
  void predict(const Prediction& p, const std::vector<double>& y, std::vector<double>& to) override {
    const auto ofBefore = [&](double rate, double momentum) { return rate + knownDamping_ * momentum; };
    const double now = ofBefore(p.rate->back(), p.momenta->back()),
                 before = ofBefore(p.rateBefore->back(), p.momentaBefore->back());
    to[1] = (y[1] + 0.5 * p.h * (p.rate->back() + now + p.ratio * (now - before))) /
            (1.0 + 0.5 * p.h * knownDamping_);
  }
  void carry(std::span<const RateTerm> terms, std::vector<double>& to) override {
    for (const RateTerm& term : terms) to[0] += term.weight * term.rate->back();
  }
  void finish(const std::vector<double>&, double, std::vector<double>&) override {}
  const Executor& executor() const override { return executor_; }
  std::size_t errorCount(const std::vector<double>& y) const override { return y.size(); }
  std::size_t poseCount() const override { return 1; }

  /// The motion from (1, 0) after t, k = 1.
  std::vector<double> exact(double t) const {
    const double decay = 0.5 * damping_, w = std::sqrt(1.0 - decay * decay), e = std::exp(-decay * t);
    return {e * (std::cos(w * t) + decay / w * std::sin(w * t)), -e / w * std::sin(w * t)};
  }

  int evaluations = 0;

 private:
  double damping_, stiffness_, knownDamping_;
  Executor executor_{1};
};

using Goal = StepMethod::Goal;

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1]);
}

/// State after `steps` equal steps until `time`, from (1, 0).
std::vector<double> run(StepMethod& method, Oscillator& oscillator, double time, int steps,
                        Goal goal = Goal::Accuracy) {
  std::vector<double> y{1.0, 0.0};
  const double h = time / steps;
  bool isCurrent = false;
  for (int i = 0; i < steps; ++i) {
    if (!isCurrent) method.start(oscillator, {.time = i * h}, y);
    method.trial(oscillator, y, i * h, h, goal);
    y.swap(method.result());
    isCurrent = method.accept(h);
  }
  return y;
}

/// How fast the error falls when steps are halved.
double measuredOrder(Stepper stepper, double damping, int steps, Goal goal = Goal::Accuracy) {
  const double time = 5.0;  // no whole turn: there Euler, conjugate to leapfrog, is of second order
  const auto errorOf = [&](int count) {
    Oscillator oscillator(damping);
    return distance(run(*makeStepMethod(stepper), oscillator, time, count, goal), oscillator.exact(time));
  };
  return std::log2(errorOf(steps) / errorOf(2 * steps));
}

TEST(RungeKutta, TablesSatisfyTheConditionsOfAButcherTable) {
  for (const RungeKuttaTable& table : {kRkf45, kBogackiShampine}) {
    double sum = 0.0, sumOfOther = 0.0;
    for (int s = 0; s < table.stages; ++s) {
      double row = 0.0;
      for (int j = 0; j < s; ++j) row += table.a[s][j];
      EXPECT_NEAR(row, table.c[s], 1e-15);
      sum += table.b[s];
      sumOfOther += table.other[s];
    }
    EXPECT_NEAR(sum, 1.0, 1e-15);
    EXPECT_NEAR(sumOfOther, 1.0, 1e-15);
  }
}

TEST(RungeKutta, SeesTheTimeOfEachStage) {
  class Power : public Oscillator {  // y' = 5 t^4 is integrated exactly by a method of order five
    void evaluate(const Moment& at, const std::vector<double>&, std::vector<double>& rate) override {
      rate[0] = 5.0 * std::pow(at.time, 4);
    }
  } power;
  RungeKutta method(kRkf45);
  method.start(power, {.time = 1.0}, {0.0});
  method.trial(power, {0.0}, 1.0, 0.5, Goal::Accuracy);
  EXPECT_NEAR(method.result()[0], std::pow(1.5, 5) - 1.0, 1e-12);
}

struct StepperFacts {
  Stepper stepper;
  const char* name;
  int order, orderDamped;
  int errorOrder;   ///< of the estimate; 0: none
  int evaluations;  ///< a step
};

class EveryStepper : public testing::TestWithParam<StepperFacts> {};

TEST_P(EveryStepper, HasItsOrderOnAnOscillator) {
  EXPECT_NEAR(measuredOrder(GetParam().stepper, 0.0, 80), GetParam().order, 0.2);
}

TEST_P(EveryStepper, HasItsOrderWithDamping) {
  EXPECT_NEAR(measuredOrder(GetParam().stepper, 0.4, 80), GetParam().orderDamped, 0.2);
}

TEST_P(EveryStepper, EvaluatesAsOftenAsItSays) {
  Oscillator oscillator;
  run(*makeStepMethod(GetParam().stepper), oscillator, 1.0, 100);
  EXPECT_NEAR(oscillator.evaluations / 100.0, GetParam().evaluations, 0.011);  // and one to start with
}

TEST_P(EveryStepper, EstimatesAnErrorThatFallsWithItsPowerOfTheStep) {
  const auto method = makeStepMethod(GetParam().stepper);
  ASSERT_EQ(method->errorOrder(), GetParam().errorOrder);
  const auto estimate = [&](int steps) {
    Oscillator oscillator;
    run(*method, oscillator, 1.0, steps);
    double squares = 0.0;
    for (const double error : method->error()) squares += error * error;
    return std::sqrt(squares);
  };
  if (GetParam().errorOrder == 0) {
    EXPECT_EQ(estimate(20), 0.0);
  } else {
    EXPECT_NEAR(std::log2(estimate(20) / estimate(40)), GetParam().errorOrder, 0.15);
  }
}

TEST_P(EveryStepper, LeavesNoTraceOfARejectedTrial) {
  Oscillator oscillator;
  const auto method = makeStepMethod(GetParam().stepper), fresh = makeStepMethod(GetParam().stepper);
  const std::vector<double> y{1.0, 0.0};
  method->start(oscillator, {}, y);
  method->trial(oscillator, y, 0.0, 3.0, Goal::Accuracy);  // far too long
  method->trial(oscillator, y, 0.0, 0.1, Goal::Accuracy);
  fresh->start(oscillator, {}, y);
  fresh->trial(oscillator, y, 0.0, 0.1, Goal::Accuracy);
  EXPECT_EQ(y, (std::vector<double>{1.0, 0.0}));
  EXPECT_EQ(method->result(), fresh->result());
  EXPECT_TRUE(std::ranges::equal(method->error(), fresh->error()));
}

INSTANTIATE_TEST_SUITE_P(
    StepMethod, EveryStepper,
    testing::Values(StepperFacts{Stepper::Rkf45, "Rkf45", 5, 5, 5, 6},
                    StepperFacts{Stepper::Leapfrog, "Leapfrog", 3, 3, 3, 1},
                    StepperFacts{Stepper::Verlet, "Verlet", 2, 1, 0, 1},
                    StepperFacts{Stepper::SemiImplicitEuler, "SemiImplicitEuler", 1, 1, 0, 1},
                    StepperFacts{Stepper::BogackiShampine, "BogackiShampine", 3, 3, 3, 3}),
    [](const auto& facts) { return facts.param.name; });

TEST_P(EveryStepper, EstimatesNoErrorOfFixedSteps) {
  Oscillator oscillator;
  const auto method = makeStepMethod(GetParam().stepper);
  run(*method, oscillator, 1.0, 10, Goal::FixedStep);
  EXPECT_TRUE(method->error().empty());
}

TEST(KickDrift, LeapfrogIsOfSecondOrderWithFixedSteps) {
  EXPECT_NEAR(measuredOrder(Stepper::Leapfrog, 0.0, 80, Goal::FixedStep), 2.0, 0.2);
  EXPECT_NEAR(measuredOrder(Stepper::Leapfrog, 0.4, 80, Goal::FixedStep), 2.0, 0.2);
}

TEST(KickDrift, LeapfrogWithItsErrorTakenOffLosesAsMuchOfAnUndampedAmplitudeAsItSays) {
  Oscillator oscillator;
  const double h = 0.05, time = 4000.0;
  const std::vector<double> y = run(*makeStepMethod(Stepper::Leapfrog), oscillator, time, 80000);
  const double rate = -std::log(std::hypot(y[0], y[1])) / time;
  EXPECT_NEAR(rate, h * h * h / 16.0, 0.05 * h * h * h / 16.0);
}

TEST(KickDrift, LeapfrogBearsTheDampingThatIsKnownWhileItTakesErrorsOff) {
  for (const double known : {0.1, 0.3, 1.0, 2.0, 4.0}) {  // times the step
    for (const double share : {0.02, 0.1, 0.3, 0.7, 1.0}) {
      Oscillator oscillator(share * known, 0.05, 1.0 / share);
      const std::vector<double> y = run(*makeStepMethod(Stepper::Leapfrog), oscillator, 4000.0, 4000);
      EXPECT_LT(std::hypot(y[0], y[1]), 1.0) << known << " known, " << share << " of it there";
    }
  }
}

TEST(KickDrift, LeapfrogIsOfThirdOrderWhateverIsKnownOfTheDamping) {
  const auto errorOf = [](double known, int steps) {
    Oscillator oscillator(0.4, 1.0, known);
    return distance(run(*makeStepMethod(Stepper::Leapfrog), oscillator, 5.0, steps), oscillator.exact(5.0));
  };
  for (const double known : {0.0, 0.5, 1.0, 2.0}) {
    EXPECT_NEAR(std::log2(errorOf(known, 320) / errorOf(known, 640)), 3.0, 0.2) << known;
  }
}

// At critical damping leapfrog bears w0 h = 0.47 without being told, as Verlet 0.83 with.
TEST(KickDrift, LeapfrogBearsDampingThatItExpects) {
  constexpr double kStep = 0.7, kCritical = 2.0;
  constexpr int kSteps = 200;
  double reached[2];
  for (const bool expects : {false, true}) {
    Oscillator oscillator(kCritical);
    const auto leapfrog = makeStepMethod(Stepper::Leapfrog);
    if (expects) leapfrog->expectDamping(2.0 / kStep);
    const std::vector<double> y = run(*leapfrog, oscillator, kSteps * kStep, kSteps, Goal::FixedStep);
    reached[expects] = std::hypot(y[0], y[1]);
  }
  EXPECT_GT(reached[0], 1e3);
  EXPECT_LT(reached[1], 1e-3);
}

TEST(KickDrift, LeapfrogIsOfSecondOrderWhileItExpectsDamping) {
  constexpr double kTime = 5.0;
  const auto errorOf = [](int steps) {
    Oscillator oscillator(0.5);
    const auto leapfrog = makeStepMethod(Stepper::Leapfrog);
    leapfrog->expectDamping(2.0 * steps / kTime);
    return distance(run(*leapfrog, oscillator, kTime, steps, Goal::FixedStep), oscillator.exact(kTime));
  };
  EXPECT_NEAR(std::log2(errorOf(200) / errorOf(400)), 2.0, 0.1);
}

TEST(KickDrift, KeepsTheEnergyOfAnOscillatorOverManyTurns) {
  // Symplectic: the energy swings by h^2/4 of itself and has no trend.
  for (const Stepper stepper : {Stepper::Leapfrog, Stepper::Verlet}) {
    Oscillator oscillator;
    const double h = 0.1;
    const std::vector<double> y = run(*makeStepMethod(stepper), oscillator, 1e4, 100000, Goal::FixedStep);
    EXPECT_NEAR(y[0] * y[0] + y[1] * y[1], 1.0, 0.25 * h * h * 1.01);
  }
}

}  // namespace
}  // namespace granular
