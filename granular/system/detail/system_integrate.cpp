// SPDX-License-Identifier: MIT
// Trials until the end of a step (Bell 2005, sec. 3.4): how long the next one may be, and whether the last
// one is accepted.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include "granular/dynamics/runge_kutta.h"
#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

namespace state = detail::state;
using Clock = std::chrono::steady_clock;

// No trial carries anything farther than this fraction of the smallest radius: larger, and fast grains could
// pass over each other's edges unseen; smaller, and free flight costs evaluations.
constexpr double kLargestMove = 0.25;

// A contact's urgency changes a little within a trial; only a trial longer than this many bounds is tried
// again.
constexpr double kStageSlack = 1.5;

// How a trial that holds an event is cut down to IntegratorDef::eventFraction: in steps, since a shorter one
// may not reach the event any more.
constexpr double kEventApproach = 0.2;

// In contact times. One undamped contact bears 2/w0 = 0.64 of them by leapfrog; of a grain held by six others
// all modes are below w^2 = 12 k/m (Gershgorin), and t_c = pi sqrt(m/2k): 0.26.
constexpr double kLongestFixed = 0.25;
// With springs of friction: of balls held by twelve others that all turn alike, w^2 = 2 sum over contacts
// [kt R^2 (1 - (N a)^2)/I] = 40 kt/m, and kt <= k after Mindlin: 0.14 for steppers that bear 2/w.
constexpr double kLongestFixedOnSprings = 0.14;

// Rate of damping in a dense packing, over the contact time: RKF45 bears 3 at the longest
// contactTimeFraction, 0.3.
constexpr double kDampingPerContact = 10.0;

// How old a rate of damping by sliding may be that bounds a trial, in sub-steps, and by how much the number
// of contacts may have grown since then: to find it takes a look at all contacts.
constexpr int kOldRate = 16;
constexpr double kMoreContacts = 1.1;

// Of its bound, the first trial of a stepper that estimates errors by what was before: it knows too little of
// its own. Of 4,096 spheres flowing leapfrog took 52 evaluations for a true error of 1e-3 radii without, 47
// with.
constexpr double kFreshShare = 0.5;

// Beyond IntegratorDef::trialLimit errors may be this much larger.
constexpr double kLooseTolerance = 1000.0;

// How far beyond the tolerance a single grain's error may be. In a flow some contact begins in every sub-step
// and its corner would dictate everybody's step: in a stirred flow of 512 spheres RKF45 at a true error of
// 1e-4 radii took 548 evaluations with the largest error as the measure, 343 with the mean one and this; in a
// gentle dam break 142 and 172.
constexpr double kWorstGrain = 100.0;

constexpr std::int32_t kOwnersPerPiece = 512;  // handed to a thread at a time

/// std::max would drop a NaN that comes second.
void raise(double& largest, double value) {
  if (!(value <= largest) && !std::isnan(largest)) largest = value;
}

}  // namespace

/// As Evaluation::shearRate, of now or not long ago. The evaluation that saw this is the last one.
double GranularSystem::Impl::shearRate(const detail::EvaluationSummary& seen) {
  const bool isOld = shearRateAge >= kOldRate || static_cast<double>(seen.contacts) >
                                                     kMoreContacts * static_cast<double>(shearRateContacts);
  if (!isOld) return lastShearRate;
  shearRateAge = 0;
  shearRateContacts = seen.contacts;
  return lastShearRate = evaluation.shearRate(y);
}

/// Longest trial that what was seen allows, s.
double GranularSystem::Impl::trialBound(const detail::EvaluationSummary& seen) {
  double bound = std::numeric_limits<double>::infinity();
  if (seen.urgency > 0.0) {
    bound = integrator.contactTimeFraction * contactTimeOfUrgency(seen.urgency) * stepper->dampingLimit() /
            kRkf45.dampingLimit;
  }
  if (const double rate = shearRate(seen); rate > 0.0)
    bound = std::min(bound, stepper->dampingLimit() / rate);
  if (seen.largestSpeed > 0.0) {
    bound = std::min(bound, kLargestMove * evaluation.layout().smallestRadius / seen.largestSpeed);
  }
  return std::max(bound, integrator.smallestSubStep);
}

/// Longest trial in which a contact may begin, let go or end, s; infinite where it does not matter.
double GranularSystem::Impl::eventBound() const {
  const detail::EvaluationSummary& seen = equations.seen();
  const std::int64_t contacts = seen.contacts + frozen.size();
  if (!equations.hasEvent() || contacts > integrator.eventContacts || !(seen.urgency > 0.0)) {
    return std::numeric_limits<double>::infinity();
  }
  return std::max(integrator.eventFraction * contactTimeOfUrgency(seen.urgency), integrator.smallestSubStep);
}

/// Whether all that the trial arrived at is finite: the momenta, which see first what poses will.
bool GranularSystem::Impl::isResultFinite() {
  const std::int64_t numbers = evaluation.layout().dynamicCount() * std::int64_t{state::kMomentaSize};
  constexpr std::int64_t kPerPiece = kOwnersPerPiece * state::kMomentaSize;
  const double* result = stepper->result().data() + evaluation.layout().firstMomentum();
  errorOfPiece.assign(Executor::pieceCount(numbers, kPerPiece), {});
  evaluation.executor().forRanges(numbers, kPerPiece, [&](std::int64_t begin, std::int64_t end) {
    // 0 times what is not finite is a NaN. Several sums, which need not wait for one another.
    std::array<double, 8> sums{};
    std::int64_t i = begin;
    for (; i + 8 <= end; i += 8) {
      for (std::int64_t k = 0; k < 8; ++k) sums[k] += 0.0 * result[i + k];
    }
    for (; i < end; ++i) sums[0] += 0.0 * result[i];
    errorOfPiece[begin / kPerPiece].largest = std::accumulate(sums.begin(), sums.end(), 0.0);
  });
  return std::all_of(errorOfPiece.begin(), errorOfPiece.end(),
                     [](const ErrorOfPiece& piece) { return piece.largest == 0.0; });
}

/// How far wrong the fastest-moving surface point of an owner is, m. Of poses there may be no error.
double GranularSystem::Impl::wayOfError(const detail::OwnerNumbers<const double>& error,
                                        std::int32_t place) const {
  const detail::Layout& layout = evaluation.layout();
  const double isotropic = layout.isotropicInverseInertia[place];
  const double inverseInertia =
      isotropic > 0.0 ? isotropic : layout.owners[layout.ownerOfPlace[place]].inverseInertia.maxCoeff();
  const double reach = evaluation.reachAt(place);
  double way = contactTimeAtReference *
               (error.velocity().norm() + error.angularMomentum().norm() * inverseInertia * reach);
  if (error.pose != nullptr) raise(way, error.position().norm() + 2.0 * error.orientation().norm() * reach);
  return way;
}

/// Error of the trial over what is allowed, in tolerance times the smallest radius: way of the fastest-moving
/// surface point of an owner; of grains the root mean square, but no single one off by more than kWorstGrain
/// times as much; of bodies the largest. 0 from a stepper that has no estimate. NaN if anything is not
/// finite.
double GranularSystem::Impl::scaledError() {
  const detail::Layout& layout = evaluation.layout();
  const std::span<const double> numbers = stepper->error();
  if (numbers.empty()) return isResultFinite() ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  const std::size_t withPoses = layout.dynamicCount() * std::size_t{state::kSize};
  const std::size_t lacking = withPoses - numbers.size();
  wayOfOwner.resize(layout.dynamicCount());
  evaluation.executor().forRanges(
      layout.dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
        const auto first = static_cast<std::int32_t>(begin), last = static_cast<std::int32_t>(end);
        std::array<double, kOwnersPerPiece> ways;
        if (lacking > 0 && layout.movesOnlySpheres) {
          evaluation.kernels().errorsOfSpheres(numbers.data(), layout.isotropicInverseInertia.data(),
                                               evaluation.spheres(), contactTimeAtReference, first, last,
                                               ways.data());
        } else {
          for (std::int32_t place = first; place < last; ++place) {
            ways[place - first] = wayOfError(layout.ratesAt(place, numbers.data(), lacking), place);
          }
        }
        for (std::int32_t place = first; place < last; ++place) {
          wayOfOwner[layout.ownerOfPlace[place]] = ways[place - first];
        }
      });
  // Summed in the order of owners, which no sorting changes.
  const std::int32_t pieces = Executor::pieceCount(layout.dynamicCount(), kOwnersPerPiece);
  errorOfPiece.assign(pieces, {});
  evaluation.executor().forPieces(pieces, [&](std::int32_t piece) {
    const std::int32_t end = std::min(layout.dynamicCount(), (piece + 1) * kOwnersPerPiece);
    ErrorOfPiece& error = errorOfPiece[piece];
    for (std::int32_t o = piece * kOwnersPerPiece; o < end; ++o) {
      const double way = wayOfOwner[o];
      const bool isGrain = o < layout.dynamicGrains;
      raise(error.largest, isGrain ? way / kWorstGrain : way);
      if (isGrain) error.sumOfSquares += way * way;
    }
  });
  double way = 0.0, sumOfSquares = 0.0;
  for (const ErrorOfPiece& error : errorOfPiece) {
    raise(way, error.largest);
    sumOfSquares += error.sumOfSquares;
  }
  if (layout.dynamicGrains > 0) raise(way, std::sqrt(sumOfSquares / layout.dynamicGrains));
  return way / (integrator.tolerance * layout.smallestRadius);
}

/// The rate of the present state, which is also the first of the next trial.
void GranularSystem::Impl::evaluateNow(double t) {
  evaluation.keepContacts(sleep.enabled);  // also those of the trials that follow
  if (startIsCurrent) return;
  stepper->start(equations, {.time = t, .sinceTrial = lastSubStep}, y);
  startIsEvaluated();
}

/// The last evaluation was that of the present state.
void GranularSystem::Impl::startIsEvaluated() {
  evaluation.settleMemory(y, stepper->firstRate());
  startSummary = evaluation.summary();
  startIsCurrent = true;
  lastSubStep = 0.0;
}

/// The next trial of a step of dt, of which `remaining` is left.
GranularSystem::Impl::Trial GranularSystem::Impl::planTrial(double dt, double remaining,
                                                            const StepReport& report) {
  Trial trial;
  if (integrator.fixedSubStep > 0.0) {  // as many equal ones as fit
    trial.length = remaining / std::max(1.0, std::ceil(remaining / integrator.fixedSubStep - 1e-6));
    trial.mustBeAccepted = true;
    return trial;
  }
  const std::int64_t trials = report.subSteps + report.rejectedTrials;
  const bool isOver = trials >= 2 * std::int64_t{integrator.trialLimit};
  double bound = trialBound(startSummary);
  if (stepper->isFresh()) bound *= kFreshShare;
  if (isOver) {
    bound = std::max(bound, dt / integrator.trialLimit);
    trial.length = std::min(remaining, bound);
  } else {
    trial.length = control.propose(remaining, bound);
  }
  trial.isLoose = trials >= integrator.trialLimit;
  trial.isSmallest = trial.length <= integrator.smallestSubStep;
  trial.mustBeAccepted = isOver || trial.isSmallest;
  return trial;
}

/// Whether the trial is accepted; if not, control proposes a shorter one. scaledError: as above.
bool GranularSystem::Impl::judge(const Trial& trial, double scaledError) {
  if (integrator.fixedSubStep > 0.0) return true;
  if (!trial.mustBeAccepted) {
    const double bound = trialBound(equations.seen());
    if (trial.length > kStageSlack * bound) {
      control.shorten(bound);  // RKF45's blind second stage may be the only one that saw it
      return false;
    }
    const double longestAtEvent = trial.isLoose ? trial.length : eventBound();
    if (trial.length > longestAtEvent) {
      control.shorten(std::max(kEventApproach * trial.length, longestAtEvent));
      return false;
    }
  }
  const bool accepted = control.judge(trial.length, scaledError);
  return accepted || trial.mustBeAccepted;
}

/// Whether a sub-step of fixed length, which nothing bounds, is long enough for energy to come from nowhere.
bool GranularSystem::Impl::isTooLong(const Trial& trial) {
  if (!(integrator.fixedSubStep > 0.0)) return false;
  const detail::EvaluationSummary& seen = equations.seen();
  const double longest =
      evaluation.hasSprings() ? 0.5 * stepper->springLimit() * kLongestFixedOnSprings : kLongestFixed;
  return (seen.urgency > 0.0 && trial.length > longest * contactTimeOfUrgency(seen.urgency)) ||
         trial.length * shearRate(seen) > stepper->dampingLimit();
}

void GranularSystem::Impl::acceptTrial(const Trial& trial, bool isLast, StepReport& report) {
  const double h = trial.length;
  y.swap(stepper->result());
  lastSubStep = h;
  ++shearRateAge;
  startIsCurrent = false;
  if (stepper->accept(h)) startIsEvaluated();
  ++report.subSteps;
  report.longestSubStep = std::max(report.longestSubStep, h);
  if (!isLast || report.subSteps == 1) {
    report.shortestSubStep = report.shortestSubStep > 0.0 ? std::min(report.shortestSubStep, h) : h;
  }
  if (isTooLong(trial)) report.flags = report.flags | StepFlag::FixedSubStepTooLong;
  if (trial.isLoose) report.flags = report.flags | StepFlag::TrialLimitReached;
  if (trial.isSmallest && !isLast) report.flags = report.flags | StepFlag::SmallestSubStepReached;
}

/// Trials from 0 until dt, or until the budget is spent, a state is accepted that is not finite or in which
/// somebody wakes or falls asleep. Returns the time reached.
double GranularSystem::Impl::integrate(double dt, StepReport& report) {
  double t = 0.0;
  shearRateAge = kOldRate;
  bool isNew = true;  // a rejected trial leaves contacts that never were
  while (t < dt) {
    if (isBudgetSpent(report)) return t;
    evaluateNow(t);
    if (isNew && sleepOrWake(partStart + t)) return t;
    report.largestOverlap = std::max(report.largestOverlap, startSummary.largestOverlap);
    const Trial trial = planTrial(dt, dt - t, report);
    if (evaluation.isSortDue()) sortState();  // what planTrial looks at is lost
    const double end = dt - t <= trial.length ? dt : t + trial.length;
    evaluation.measureContacts(end == dt);  // after the step that is asked for
    equations.beginTrial(startSummary);
    if (startSummary.urgency > 0.0) {
      stepper->expectDamping(kDampingPerContact / contactTimeOfUrgency(startSummary.urgency));
    }
    using Goal = StepMethod::Goal;
    stepper->trial(equations, y, t, trial.length,
                   integrator.fixedSubStep > 0.0 ? Goal::FixedStep : Goal::Accuracy);

    const auto stepStart = Clock::now();
    const double error = scaledError() / (trial.isLoose ? kLooseTolerance : 1.0);
    const bool accepted = judge(trial, error);
    if (accepted) {
      acceptTrial(trial, end == dt, report);
      t = end;
    } else {
      ++report.rejectedTrials;
    }
    isNew = accepted;
    evaluation.stageSeconds[static_cast<int>(Stage::AdvanceState)] +=
        std::chrono::duration<double>(Clock::now() - stepStart).count();
    if (accepted && !std::isfinite(error)) return t;
  }
  if (sleep.enabled) {
    evaluateNow(dt);
    sleepOrWake(partStart + dt);
  }
  return dt;
}

}  // namespace granular
