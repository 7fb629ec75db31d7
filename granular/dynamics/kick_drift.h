// SPDX-License-Identifier: MIT
// Steppers of one evaluation a sub-step, for equations of second order: poses drift with the momenta, momenta
// are kicked by the forces found there. Which one is four weights.
//
//   leapfrog     the force at the end of the drift is evaluated at a predicted velocity of that same moment,
//                so that damping and friction keep the second order (a velocity half a step old makes it
//                one). Under error control what the estimate says is taken off again: third order
//   Verlet       velocity Verlet as DEM codes step: the force sees the velocity of half a step ago
//   semi-implicit Euler   kick, then drift with the new momenta
//
// Without forces that depend on velocity the first two are the same, symplectic, and energy has no trend.
//
// Taking the error off. Through the accelerations of the last three states goes a parabola; velocities and
// positions get what it says beyond the trapezoidal rule and beyond the drift (Adams and Moulton's rule, and
// the same integrated twice). On an undamped spring amplitudes then shrink by w (w h)^3 / 16 a second;
// without the part of positions they would grow. The velocity predicted is of that order too: half of the
// rate at the end is in it, with damping as far as it is known for each owner implicit and the rest carried
// on from the last two states (Equations::predict). By the roots of the scheme that bears products of damping
// and step up to 4, if no mode is damped by more than is taken for it; where it is damped by less the
// prediction is off by up to h^2 of the change of acceleration, at most twice as much as v + h a. Where
// contacts remember, the step is leapfrog's as it stands: how memories move, below, fits that one, and with
// the other a stiff bed under law 19 trembles. Tests: KickDrift.*, Stress.* "bed at rest"; measured:
// granular_bench work-precision.
//
// Leapfrog's own prediction v + h a bears damping of rates up to 1/h; Verlet's v + h a / 2 up to 2/h. What
// lies between is won by predicting with a mean of the last two accelerations, v + h ((1 - p) a + p
// a_before): also of second order, it bears 1/((1 - 2 p) h), at p = 1/4 as much as Verlet at every damping of
// a spring. Its error is up to 1.7 times as large, so p is no larger than the damping to be expected asks
// for.
#pragma once

#include "granular/dynamics/step_method.h"

namespace granular {

/// In steps: `Drift` of a trial, what the memory of contacts gets on top (Moment::memoryStep), and how much
/// of the rates at both ends momenta are kicked with.
struct KickDriftTable {
  double poseKick, kick, memory, memoryStep, first, second;
  int errorOrder;       ///< 0: no error estimate
  double dampingLimit;  ///< as StepMethod::dampingLimit
  double springLimit;   ///< as StepMethod::springLimit
};

// Memories of contacts move with predicted velocities, half of them those of the start. These lag the true
// ones by h (a' h) / 2, which on an undamped spring makes w (w h)^3 / 8 of growth in amplitude a second: beds
// under law 19 trembled for ever and made 2 % of their energy from nowhere in two seconds. A tenth more
// weight on the end of the step takes w (w h) / 20 away, more than that for w h < 0.67. Tests: Stress.*, "bed
// at rest" and "springs of friction".
inline constexpr KickDriftTable kLeapfrog{.poseKick = 0.5,
                                          .kick = 1.0,
                                          .memory = 0.4,
                                          .memoryStep = 0.6,
                                          .first = 0.5,
                                          .second = 0.5,
                                          .errorOrder = 3,
                                          .dampingLimit = 1.0,
                                          .springLimit = 0.67};
// D moves with the velocity of half a step ago, as positions do.
inline constexpr KickDriftTable kVerlet{.poseKick = 0.5,
                                        .kick = 0.5,
                                        .memory = 0.0,
                                        .memoryStep = 1.0,
                                        .first = 0.5,
                                        .second = 0.5,
                                        .errorOrder = 0,
                                        .dampingLimit = 2.0,
                                        .springLimit = 2.0};
inline constexpr KickDriftTable kSemiImplicitEuler{.poseKick = 1.0,
                                                   .kick = 1.0,
                                                   .memory = 0.0,
                                                   .memoryStep = 1.0,
                                                   .first = 1.0,
                                                   .second = 0.0,
                                                   .errorOrder = 0,
                                                   .dampingLimit = 2.0,
                                                   .springLimit = 2.0};

class KickDrift final : public StepMethod {
 public:
  explicit KickDrift(const KickDriftTable& table) : table_(table) {}

  void trial(Equations& equations, const std::vector<double>& y, double t, double h, Goal goal) override;
  bool accept(double h) override;
  void expectDamping(double rate) override { dampingRate_ = rate; }
  int errorOrder() const override { return table_.errorOrder; }
  double dampingLimit() const override { return table_.dampingLimit; }
  double springLimit() const override { return table_.springLimit; }
  bool needsPoseRates() const override { return false; }
  bool needsMemoryRates() const override { return table_.memory != 0.0; }
  bool isFresh() const override { return table_.errorOrder > 0 && !(lengthBefore_ > 0.0); }
  std::vector<std::vector<double>*> kept() override {
    return {&firstRate_, &rateBefore_, &momenta_, &momentaBefore_};
  }

 private:
  void forget() override {
    lengthBefore_ = 0.0;
    predictions_ = 0;
  }
  double weightOfBefore(double h) const;
  void estimateError(const Executor& executor, double h);
  void takeErrorOff(Equations& equations, const std::vector<double>& y, double h);

  const KickDriftTable& table_;
  std::vector<double> errors_;
  std::vector<double> lastRate_,
      rateBefore_;             // at the end of the trial; at the start of the one accepted before
  double lengthBefore_ = 0.0;  // of that one, s; 0: none
  /// Momenta that rates were evaluated at: at the end of the trial, at its start, and at the state before.
  std::vector<double> lastMomenta_, momenta_, momentaBefore_;
  int predictions_ = 0;        // of the last two that are there
  bool keepsMomenta_ = false;  // of the present trial
  double dampingRate_ = 0.0;   // to be expected, 1/s
};

}  // namespace granular
