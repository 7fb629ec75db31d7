// SPDX-License-Identifier: MIT
// A stepper: from a state to a state one trial later, and how wrong that may be. It accepts nothing (that is
// StepControl's part) and knows nothing of grains (those are the Equations). As in odeint, equations, stepper
// and controller are three things.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "granular/dynamics/equations.h"
#include "granular/dynamics/integrator.h"

namespace granular {

class StepMethod {
 public:
  virtual ~StepMethod() = default;

  /// First rate of every trial that starts from y at this moment; forgets what was known before.
  void start(Equations& equations, const Moment& at, const std::vector<double>& y);

  /// What a trial is for.
  enum class Goal {
    Accuracy,  ///< error() is asked for, where there is an estimate
    /// It is accepted whatever its error: none is worked out, and steppers that keep energies do.
    FixedStep,
  };

  /// Tries the step from (y, t) to t + h. Needs firstRate() there. Changes nothing but result() and error().
  virtual void trial(Equations& equations, const std::vector<double>& y, double t, double h, Goal goal) = 0;

  /// The last trial, of length h, is the state from now on. Returns whether firstRate() is that of the new
  /// state already, else start() has to be called before the next trial.
  virtual bool accept(double h) = 0;

  /// The error estimate falls with this power of the step; 0: there is none, and error() is empty.
  virtual int errorOrder() const = 0;

  /// Largest product of a rate of damping and the step that it bears.
  virtual double dampingLimit() const = 0;

  /// Largest product of a frequency of springs of friction, whose displacements are memories, and the step
  /// that it bears without damping.
  virtual double springLimit() const { return 2.0; }

  /// Largest rate of damping to be expected in the next trial, 1/s: some bear more of it at a cost in error.
  virtual void expectDamping(double) {}

  /// Whether its trials read the rates of poses; else its rates lack them.
  virtual bool needsPoseRates() const { return true; }
  /// Whether they read those of memories.
  virtual bool needsMemoryRates() const { return true; }
  /// Whether it estimates errors by what was before the trial and knows nothing of that yet.
  virtual bool isFresh() const { return false; }
  /// Rates that it keeps from one trial to the next: for whoever puts the state into another order.
  virtual std::vector<std::vector<double>*> kept() { return {&firstRate_}; }

  std::vector<double>& firstRate() { return firstRate_; }
  std::vector<double>& result() { return result_; }  ///< state at t + h
  /// Of its leading numbers, same units, less those of poses if the rates lack them. Empty after a trial that
  /// estimates none.
  std::span<const double> error() const { return error_; }

 protected:
  virtual void forget() {}
  /// Numbers of a rate, as Equations::evaluate fills them for this.
  std::size_t rateSize(const Equations& equations, const std::vector<double>& y) const {
    return y.size() - (needsPoseRates() ? 0 : equations.poseCount());
  }

  std::vector<double> firstRate_, result_;
  std::span<const double> error_;  // wherever the stepper has room for it
};

std::unique_ptr<StepMethod> makeStepMethod(Stepper stepper);

}  // namespace granular
