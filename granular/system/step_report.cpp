// SPDX-License-Identifier: MIT
#include "granular/system/step_report.h"

#include <utility>

namespace granular {

const char* stageName(Stage stage) {
  switch (stage) {
    case Stage::PlaceParticles:
      return "place particles";
    case Stage::UpdateCandidates:
      return "update candidates";
    case Stage::FindContacts:
      return "find contacts";
    case Stage::ComputeContactForces:
      return "compute contact forces";
    case Stage::SumWrenches:
      return "sum wrenches";
    case Stage::ComputeAccelerations:
      return "compute accelerations";
    case Stage::AdvanceState:
      return "advance state";
    case Stage::Measure:
      return "measure";
    case Stage::Count:
      break;
  }
  return "unknown";
}

std::string describe(StepFlag set) {
  static constexpr std::pair<StepFlag, const char*> kSentences[] = {
      {StepFlag::SmallestSubStepReached,
       "The smallest sub-step was reached: raise IntegratorDef.tolerance or lower "
       "MaterialDef.youngsModulus. "},
      {StepFlag::TrialLimitReached,
       "The trial limit was reached, the rest of the step ran without error control: raise "
       "IntegratorDef.trialLimit "
       "or IntegratorDef.tolerance. "},
      {StepFlag::DeepOverlap,
       "Two particles overlapped by more than the smaller radius: raise MaterialDef.youngsModulus. "},
      {StepFlag::GrainsQuarantined, "Grains whose state was no longer finite were taken out of the scene. "},
      {StepFlag::BodiesStopped,
       "A body's state was no longer finite: it was put back to where the step found it, at rest. "},
      {StepFlag::FixedSubStepTooLong,
       "A fixed sub-step was longer than a quarter of the shortest contact time, or than the shear law's "
       "damping bears: lower "
       "IntegratorDef.fixedSubStep. "},
      {StepFlag::BudgetExhausted,
       "The budget of work was used up and time was dropped: raise WorkBudget or ask for less. "},
      {StepFlag::BadStep, "dt was not finite or not > 0: nothing was done. "},
  };
  std::string text;
  for (const auto& [bit, sentence] : kSentences) {
    if (has(set, bit)) text += sentence;
  }
  if (!text.empty()) text.pop_back();
  return text;
}

}  // namespace granular
