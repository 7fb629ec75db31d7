// SPDX-License-Identifier: MIT
// The step: trials until its end, then the report.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

namespace state = detail::state;
using Clock = std::chrono::steady_clock;
using detail::BodyRecord;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// No trial carries anything farther than this fraction of the smallest radius: larger, and fast grains could
// pass over each other's edges unseen; smaller, and free flight costs evaluations.
constexpr double kLargestMove = 0.25;

// A contact's urgency changes a little within a trial; only a trial longer than this many bounds is tried
// again.
constexpr double kStageSlack = 1.5;

// How a trial that holds an event is cut down to IntegratorDef::eventFraction: in steps, since a shorter one
// may not reach the event any more.
constexpr double kEventApproach = 0.2;

// Beyond IntegratorDef::trialLimit errors may be this much larger.
constexpr double kLooseTolerance = 1000.0;

double shorterSubStep(const StepReport& report, double h) {
  return report.shortestSubStep > 0.0 ? std::min(report.shortestSubStep, h) : h;
}

bool isFinite(const RigidMotion& m) {
  return m.pose.position.allFinite() && m.pose.orientation.coeffs().allFinite() && m.velocity.allFinite() &&
         m.angularVelocity.allFinite();
}

}  // namespace

/// Longest trial that what was seen allows, s.
double GranularSystem::Impl::trialBound(const detail::EvaluationSummary& seen) const {
  double bound = std::numeric_limits<double>::infinity();
  if (seen.urgency > 0.0) bound = integrator.contactTimeFraction * contactTimeOfUrgency(seen.urgency);
  if (seen.largestSpeed > 0.0) {
    bound = std::min(bound, kLargestMove * evaluation.layout().smallestRadius / seen.largestSpeed);
  }
  return std::max(bound, integrator.smallestSubStep);
}

/// Longest trial in which a contact may begin, let go or end, s; infinite where it does not matter.
double GranularSystem::Impl::eventBound(const detail::EvaluationSummary& seen, bool hasEvent) const {
  if (!hasEvent || seen.contacts > integrator.eventContacts || !(seen.urgency > 0.0)) {
    return std::numeric_limits<double>::infinity();
  }
  return std::max(integrator.eventFraction * contactTimeOfUrgency(seen.urgency), integrator.smallestSubStep);
}

/// Largest error of the trial over what is allowed: way of the fastest-moving surface point, in tolerance
/// times the smallest radius. NaN if anything is not finite.
double GranularSystem::Impl::scaledError() const {
  constexpr std::int32_t kOwnersPerPiece = 512;
  const detail::Layout& layout = evaluation.layout();
  const std::int32_t pieces = Executor::pieceCount(layout.dynamicCount(), kOwnersPerPiece);
  std::vector<double> worst(pieces, 0.0);
  const double velocityTime = contactTimeAtReference;
  // std::max would drop a NaN that comes second.
  const auto raise = [](double& largest, double value) {
    if (!(value <= largest) && !std::isnan(largest)) largest = value;
  };
  evaluation.executor().forPieces(pieces, [&](std::int32_t piece) {
    const std::int32_t end = std::min(layout.dynamicCount(), (piece + 1) * kOwnersPerPiece);
    for (std::int32_t o = piece * kOwnersPerPiece; o < end; ++o) {
      const detail::Owner& owner = layout.owners[o];
      const double* error = stepper.error().data() + o * state::kSize;
      const auto size3 = [&](int place) { return Eigen::Map<const Vector3>(error + place).norm(); };
      const double turn = 2.0 * Eigen::Map<const Eigen::Vector4d>(error + state::kOrientation).norm();
      const double spin = size3(state::kAngularMomentum) * owner.inverseInertia.maxCoeff();
      raise(worst[piece], size3(state::kPosition) + turn * owner.reach);
      raise(worst[piece], velocityTime * (size3(state::kVelocity) + spin * owner.reach));
    }
  });
  double way = 0.0;
  for (const double w : worst) raise(way, w);
  return way / (integrator.tolerance * layout.smallestRadius);
}

void GranularSystem::Impl::acceptTrial() {
  y.swap(stepper.result());
  evaluation.executor().forRanges(
      evaluation.layout().dynamicCount(), 4096, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t o = begin; o < end; ++o) {
          Eigen::Map<Eigen::Vector4d>(y.data() + o * state::kSize + state::kOrientation).normalize();
        }
      });
}

/// One evaluation of the present state, which is also the first stage of the next trial.
void GranularSystem::Impl::evaluateNow(double t) {
  if (startIsCurrent) return;
  stepper.start(y, t, [&](double at, const std::vector<double>& s, std::vector<double>& rate) {
    evaluation.evaluate(at, s, rate, lastSubStep);
  });
  evaluation.settleMemory(y, stepper.firstRate());
  startSummary = evaluation.summary();
  startIsCurrent = true;
  lastSubStep = 0.0;
}

/// Trials from 0 until dt, or until a state is accepted that is not finite. Returns the time reached.
double GranularSystem::Impl::integrate(double dt, StepReport& report) {
  double t = 0.0;
  while (t < dt) {
    evaluateNow(t);
    report.largestOverlap = std::max(report.largestOverlap, startSummary.largestOverlap);

    const std::int64_t trials = report.subSteps + report.rejectedTrials;
    const bool loose = trials >= integrator.trialLimit,
               forced = trials >= 2 * std::int64_t{integrator.trialLimit};
    const double bound =
        forced ? std::max(trialBound(startSummary), dt / integrator.trialLimit) : trialBound(startSummary);
    const double h = forced ? std::min(dt - t, bound) : control.propose(dt - t, bound);
    detail::EvaluationSummary seen = startSummary;
    bool hasEvent = false;
    stepper.trial(y, t, h, evaluation.executor(),
                  [&](double at, const std::vector<double>& s, std::vector<double>& rate) {
                    evaluation.evaluate(at, s, rate, at - t);
                    seen.urgency = std::max(seen.urgency, evaluation.summary().urgency);
                    seen.contacts = std::max(seen.contacts, evaluation.summary().contacts);
                    hasEvent |= evaluation.summary().pushing != startSummary.pushing;
                  });

    const auto stepStart = Clock::now();
    const bool smallest = h <= integrator.smallestSubStep;
    const double error = loose ? scaledError() / kLooseTolerance : scaledError();
    bool accept = forced || smallest;
    const double longest = kStageSlack * trialBound(seen);
    const double longestAtEvent = loose ? longest : eventBound(seen, hasEvent);
    if (h > longest && !accept) {
      control.shorten(trialBound(seen));  // RKF45's blind second stage may be the only one that saw it
    } else if (h > longestAtEvent && !accept) {
      control.shorten(std::max(kEventApproach * h, longestAtEvent));
    } else {
      accept |= control.judge(h, error);
    }
    if (accept) {
      acceptTrial();
      startIsCurrent = false;
      lastSubStep = h;
      t = dt - t <= h ? dt : t + h;
      ++report.subSteps;
      report.longestSubStep = std::max(report.longestSubStep, h);
      if (t < dt || report.subSteps == 1) report.shortestSubStep = shorterSubStep(report, h);
      if (loose) report.flags = report.flags | StepFlag::TrialLimitReached;
      if (smallest && t < dt) report.flags = report.flags | StepFlag::SmallestSubStepReached;
    } else {
      ++report.rejectedTrials;
    }
    evaluation.stageSeconds[static_cast<int>(Stage::AdvanceState)] += secondsSince(stepStart);
    if (accept && !std::isfinite(error)) return t;
  }
  return dt;
}

/// Takes out what is no longer finite, so that it cannot poison the rest.
void GranularSystem::Impl::quarantineNonFinite(StepReport& report) {
  const detail::Layout& layout = evaluation.layout();
  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) {
    const Eigen::Map<const Eigen::Matrix<double, state::kSize, 1>> own(y.data() + o * state::kSize);
    if (own.allFinite()) continue;
    const std::int32_t index = layout.owners[o].index;
    if (layout.owners[o].kind == OwnerKind::Grain) {
      removeGrain(index);
      ++report.quarantined;
      report.flags = report.flags | StepFlag::GrainsQuarantined;
    } else {
      bodies[index].motion.velocity.setZero();
      bodies[index].motion.angularVelocity.setZero();
      report.flags = report.flags | StepFlag::BodiesStopped;
    }
    layoutIsOld = true;
  }
}

void GranularSystem::Impl::storeState(double dt) {
  const detail::Layout& layout = evaluation.layout();
  evaluation.executor().forRanges(layout.dynamicCount(), 1024, [&](std::int64_t begin, std::int64_t end) {
    for (auto o = static_cast<std::int32_t>(begin); o < end; ++o) {
      const RigidMotion motion = readOwner(o);
      if (!isFinite(motion)) continue;  // keeps the last finite one
      const detail::Owner& owner = layout.owners[o];
      (owner.kind == OwnerKind::Grain ? grainMotions[owner.index] : bodies[owner.index].motion) = motion;
    }
  });
  for (std::int32_t b = 0; b < layout.movingBodies(); ++b) {
    BodyRecord& record = bodies[layout.owners[layout.dynamicGrains + b].index];
    double* tally = y.data() + evaluation.tallyAt(b);
    record.impulse.force += Eigen::Map<Vector3>(tally + state::kImpulse);
    record.impulse.torque += Eigen::Map<Vector3>(tally + state::kAngularImpulse);
    (record.motionType == BodyMotion::Kinematic ? workByMoved : workByLoads) += tally[state::kWork];
    std::fill_n(tally, state::kTallySize, 0.0);
    if (record.motionType == BodyMotion::Kinematic) record.motion = advanced(record.motion, dt);
  }
  heat += y[evaluation.heatAt()];
  y[evaluation.heatAt()] = 0.0;
  loadSurroundings();
}

StepReport GranularSystem::Impl::step(double dt) {
  StepReport report;
  if (!(std::isfinite(dt) && dt > 0.0)) {
    report.flags = StepFlag::BadStep;
    report.time = time;
    return report;
  }
  evaluation.stageSeconds.fill(0.0);
  const std::int64_t evaluationsBefore = evaluation.evaluations, rebuildsBefore = evaluation.listRebuilds;
  for (BodyRecord& record : bodies) record.impulse = {};

  for (double done = 0.0; done < dt;) {
    prepare();  // only when something was added, removed or moved by hand
    const double part = integrate(dt - done, report);  // sub-steps, six evaluations a trial sec. 3.4
    storeState(part);
    quarantineNonFinite(report);  // one bad grain must not poison the pile
    done = part >= dt - done ? dt : done + part;
  }
  time += dt;
  measure(report);
  report.evaluations = evaluation.evaluations - evaluationsBefore;
  report.listRebuilds = evaluation.listRebuilds - rebuildsBefore;
  report.stageSeconds = evaluation.stageSeconds;
  return report;
}

void GranularSystem::Impl::measure(StepReport& report) {
  prepare();
  evaluateNow(0.0);
  const auto start = Clock::now();
  const detail::Layout& layout = evaluation.layout();
  const detail::EvaluationSummary& seen = startSummary;
  report.time = time;
  report.candidates = evaluation.candidateCount();
  report.contacts = seen.contacts;
  report.largestOverlap = std::max(report.largestOverlap, seen.largestOverlap);
  if (report.largestOverlap > 1.0) report.flags = report.flags | StepFlag::DeepOverlap;

  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) {
    const detail::Owner& owner = layout.owners[o];
    const double* own = y.data() + o * state::kSize;
    const Eigen::Map<const Vector3> position(own + state::kPosition), velocity(own + state::kVelocity),
        angularMomentum(own + state::kAngularMomentum);
    const bool isGrain = owner.kind == OwnerKind::Grain;
    const RigidMotion& motion = isGrain ? grainMotions[owner.index] : bodies[owner.index].motion;
    const double mass = isGrain ? grains[owner.index].mass : bodies[owner.index].mass;
    const Vector3& pull = isGrain ? gravity : evaluation.surroundings().bodyGravity[o - layout.dynamicGrains];
    report.energy.kinetic +=
        0.5 * mass * velocity.squaredNorm() + 0.5 * motion.angularVelocity.dot(angularMomentum);
    report.energy.potential -= mass * owner.linearFactor.cwiseProduct(pull).dot(position);
    report.momentum += mass * velocity;
    report.angularMomentum += mass * position.cross(velocity) + angularMomentum;
  }
  double overlapSum = 0.0;
  evaluation.forEachContact(
      [&](const detail::Contact& contact, const detail::ContactForce& force, const PairLaw&) {
        report.energy.elastic += evaluation.elasticEnergy(contact, force);
        overlapSum += evaluation.relativeOverlap(contact, force.overlap);
      });
  report.energy.elastic += evaluation.memoryEnergy();
  if (seen.contacts > 0) report.meanOverlap = overlapSum / static_cast<double>(seen.contacts);
  report.workByMovedBodies = workByMoved;
  report.workByLoads = workByLoads;
  report.dissipated = heat + y[evaluation.heatAt()];
  evaluation.stageSeconds[static_cast<int>(Stage::Measure)] += secondsSince(start);
}

void GranularSystem::Impl::removeGrain(std::int32_t index) {
  grains[index].alive = false;
  ++grains[index].generation;
  freeGrains.push_back(index);
  --aliveGrains;
  layoutIsOld = true;
}

}  // namespace granular
