// SPDX-License-Identifier: MIT
// What one GranularSystem::step() did and found.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "granular/base/pose.h"

namespace granular {

/// The stages of an evaluation, in their order, and the rest of a sub-step. Timings hang on these names.
enum class Stage : std::uint8_t {
  PlaceParticles,
  UpdateCandidates,
  FindContacts,
  ComputeContactForces,
  SumWrenches,
  ComputeAccelerations,
  AdvanceState,  ///< the stepper's own arithmetic, error norm, renormalising
  Measure,       ///< energies, overlaps and momentum at the end of the step
  Count
};
inline constexpr int kStageCount = static_cast<int>(Stage::Count);
using StageSeconds = std::array<double, kStageCount>;
const char* stageName(Stage stage);

/// Things to know about a step, as bits. Each says which setting to change.
enum class StepFlag : std::uint32_t {
  None = 0,
  SmallestSubStepReached = 1u << 0,  ///< raise IntegratorDef::tolerance, or soften the material
  TrialLimitReached = 1u << 1,       ///< raise IntegratorDef::trialLimit or tolerance
  DeepOverlap = 1u << 2,             ///< overlap beyond the smaller radius: raise MaterialDef::youngsModulus
  GrainsQuarantined = 1u << 3,       ///< a grain's state was not finite: it was taken out of the scene
  BodiesStopped = 1u << 4,  ///< a body's state was not finite: it stands where the step found it, at rest
  BadStep = 1u << 5,        ///< dt was not finite or not > 0: nothing was done
  /// A fixed sub-step was longer than a quarter of a contact time, 0.14 of it (leapfrog 0.047) where there
  /// are springs of friction (eqs. 17 and 19), near which packings begin to gain energy, or than the stepper
  /// bears of a viscosity or dashpot given in ShearLawDef: lower IntegratorDef::fixedSubStep
  FixedSubStepTooLong = 1u << 6,
  BudgetExhausted =
      1u << 7,  ///< StepReport::droppedTime was not simulated: raise WorkBudget, or ask for less
};
constexpr StepFlag operator|(StepFlag a, StepFlag b) {
  return static_cast<StepFlag>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr bool has(StepFlag set, StepFlag bit) {
  return (static_cast<std::uint32_t>(set) & static_cast<std::uint32_t>(bit)) != 0;
}
/// One sentence a set bit, with the setting to change; empty when nothing is set.
std::string describe(StepFlag set);

/// Mechanical energy of grains and dynamic bodies, J.
struct Energy {
  double kinetic = 0.0;
  double potential = 0.0;  ///< of gravity, zero at the world's origin
  double elastic = 0.0;    ///< stored in contacts

  double total() const { return kinetic + potential + elastic; }
};

struct StepReport {
  StepFlag flags = StepFlag::None;
  double time = 0.0;         ///< simulated time at the end of the step, s
  double droppedTime = 0.0;  ///< asked for and not simulated, as the budget was used up, s

  // Work of the integrator in this step.
  std::int64_t subSteps = 0;  ///< accepted
  std::int64_t rejectedTrials = 0;
  std::int64_t evaluations = 0;   ///< computations of all accelerations
  std::int64_t listRebuilds = 0;  ///< times the candidate list was made anew
  double shortestSubStep =
      0.0;  ///< s, the last one (cut to the step's end) left out unless it is the only one
  double longestSubStep = 0.0;  ///< s

  // The state at the end of the step.
  std::int64_t candidates = 0;      ///< pairs in the list
  std::int64_t contacts = 0;        ///< pairs that overlap, frozen ones too
  std::int64_t frozenContacts = 0;  ///< those between sleepers, or of a sleeper with something held
  std::int64_t awakeGrains = 0;
  std::int64_t awakeBodies = 0;  ///< dynamic ones
  double largestOverlap = 0.0;   ///< in smaller radii of the pair, worst over every sub-step of this step
  double meanOverlap = 0.0;      ///< in smaller radii of the pair, at the end of the step
  Energy energy;
  Vector3 momentum = Vector3::Zero();         ///< of grains and dynamic bodies, kg m/s
  Vector3 angularMomentum = Vector3::Zero();  ///< about the world's origin, kg m^2/s

  // Running totals since the system was made, J.
  double workByMovedBodies = 0.0;  ///< done by kinematic bodies on everything else
  double workByLoads = 0.0;        ///< done by the host's forces and torques on dynamic bodies
  double dissipated = 0.0;         ///< turned into heat by contact laws

  /// Momentum that sleepers have taken up without moving, since the system was made, N s: the time integral
  /// of the net force on them, and what was left of their own when they fell asleep.
  Vector3 heldImpulse = Vector3::Zero();

  std::int64_t fellAsleep = 0;   ///< grains and bodies, in this step
  std::int64_t woken = 0;        ///< the same
  std::int64_t quarantined = 0;  ///< grains taken out because their state was not finite, in this step

  StageSeconds stageSeconds{};  ///< wall time, s
};

}  // namespace granular
