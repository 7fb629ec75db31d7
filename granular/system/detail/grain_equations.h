// SPDX-License-Identifier: MIT
// Grains and bodies as a stepper sees them: evaluations, drifts and kicks of the state vector of layout.h.
// Also collects what step control wants to know of the evaluations of one trial.
#pragma once

#include "granular/dynamics/equations.h"
#include "granular/system/detail/evaluation.h"

namespace granular::detail {

class GrainEquations final : public Equations {
 public:
  explicit GrainEquations(Evaluation& evaluation) : evaluation_(evaluation) {}

  void evaluate(const Moment& at, const std::vector<double>& y, std::vector<double>& rate) override;
  void drift(const Drift& drift, const std::vector<double>& y, const std::vector<double>& rate,
             std::vector<double>& to) override;
  void kick(const std::vector<double>& y, std::span<const RateTerm> terms, std::vector<double>& to) override;
  void predict(const Prediction& prediction, const std::vector<double>& y, std::vector<double>& to) override;
  void carry(std::span<const RateTerm> terms, std::vector<double>& to) override;
  void finish(const std::vector<double>& y, double h, std::vector<double>& to) override;
  const Executor& executor() const override { return evaluation_.executor(); }
  bool hasMemory() const override { return evaluation_.hasSprings(); }
  std::size_t poseCount() const override { return evaluation_.layout().firstMomentum(); }
  std::size_t errorCount(const std::vector<double>&) const override {
    return evaluation_.layout().dynamicCount() * state::kSize;
  }

  /// As IntegratorDef::turnSpheres.
  void turnSpheres(bool turn) { turnsSpheres_ = turn; }

  /// A trial starts from a state in which an evaluation saw this.
  void beginTrial(const EvaluationSummary& start);
  /// The most urgent and the most contacts of its start and of its evaluations since.
  const EvaluationSummary& seen() const { return seen_; }
  /// Whether in any of them a contact had begun, let go or ended.
  bool hasEvent() const { return hasEvent_; }

 private:
  Evaluation& evaluation_;
  EvaluationSummary seen_;
  std::int64_t pushingAtStart_ = 0;
  bool hasEvent_ = false;
  bool turnsSpheres_ = true;
};

}  // namespace granular::detail
