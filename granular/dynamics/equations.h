// SPDX-License-Identifier: MIT
// What a stepper may ask of equations of motion. The state is a plain vector of doubles; only the equations
// know which of them are poses, which are momenta, and which merely add up. So steppers are tested on an
// oscillator and grains are stepped by any of them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "granular/base/parallel.h"

namespace granular {

/// The moment an evaluation is made for.
struct Moment {
  double time = 0.0;        ///< since the step began, s
  double sinceTrial = 0.0;  ///< since the trial began, s: what touches now and did not then began within it
  /// How much longer contacts have slid than the state says, at the rate that this evaluation finds, s.
  /// Runge-Kutta: 0. Splitting methods move the memory of contacts (Bell 2005, eq. 19) with the velocities
  /// that the evaluation sees, as they move poses.
  double memoryStep = 0.0;
  /// Whether the rates of poses are asked for; else the rate has no room for them.
  bool poseRates = true;
  /// Whether the rates of memories are asked for; else they stay as they are.
  bool memoryRates = true;
};

/// Leading numbers of the state that its rate lacks: poses, where nobody asks for theirs.
inline std::size_t lackingOf(const std::vector<double>& rate, const std::vector<double>& y) {
  return y.size() - rate.size();
}

/// One move of poses, and where momenta and memories of contacts stand for the evaluation that follows. All
/// in seconds of the rate at the start of the trial.
struct Drift {
  double time = 0.0;      ///< length of the move
  double poseKick = 0.0;  ///< momenta that carry the poses along = those of the state + poseKick * rate
  double kick = 0.0;      ///< momenta for the evaluation = those of the state + kick * rate
  double memory = 0.0;    ///< the same for memories of contacts
};

/// So many seconds of a rate.
struct RateTerm {
  double weight;
  const std::vector<double>* rate;
};

/// What a prediction of momenta, h after the state, follows from: rates at the last two states, h / ratio
/// apart, and the momenta predicted there, which they were evaluated at; all without poses.
struct Prediction {
  double h, ratio;
  const std::vector<double>*rate, *rateBefore;
  const std::vector<double>*momenta, *momentaBefore;
};

class Equations {
 public:
  virtual ~Equations() = default;

  /// One evaluation: rate = dy/dt. Fills rate, which has the size of y; less poseCount() unless
  /// Moment::poseRates.
  virtual void evaluate(const Moment& at, const std::vector<double>& y, std::vector<double>& rate) = 0;

  /// Leading numbers of a state that are poses.
  virtual std::size_t poseCount() const { return 0; }

  /// Poses move on by themselves, exactly where nothing pushes. Leaves in `to`, which has the size of y, a
  /// state to evaluate; what merely adds up is not set.
  virtual void drift(const Drift& drift, const std::vector<double>& y, const std::vector<double>& rate,
                     std::vector<double>& to) = 0;

  /// Momenta and what adds up of `to` = those of y + the sum of two or three terms; poses of `to` stay.
  virtual void kick(const std::vector<double>& y, std::span<const RateTerm> terms,
                    std::vector<double>& to) = 0;

  /// Momenta of `to` h after y: v + h/2 (a + n - c v'), with v' the result, c how fast the momentum is damped
  /// as the last evaluation found it, and n = a + c v, of the momenta predicted before, carried on from the
  /// last two states. So of c as much is implicit as is known; what c does not tell is extrapolated.
  virtual void predict(const Prediction& prediction, const std::vector<double>& y,
                       std::vector<double>& to) = 0;

  /// Poses of `to` move on by a little: as momenta would carry them in a second that are the sum of three
  /// terms.
  virtual void carry(std::span<const RateTerm> terms, std::vector<double>& to) = 0;

  /// `to` was summed up number by number from y, h seconds before. Brings it back to what it may be: unit
  /// quaternions, and exact turns of what nothing turned.
  virtual void finish(const std::vector<double>& y, double h, std::vector<double>& to) = 0;

  /// Whether the state holds memories of contacts.
  virtual bool hasMemory() const { return false; }

  /// Threads that a stepper's own sums may run on.
  virtual const Executor& executor() const = 0;

  /// Leading numbers of a state whose error is asked for.
  virtual std::size_t errorCount(const std::vector<double>& y) const = 0;
};

}  // namespace granular
