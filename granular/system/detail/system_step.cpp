// SPDX-License-Identifier: MIT
// The step: sub-steps until its end (system_integrate.cpp), then the report.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

namespace state = detail::state;
using Clock = std::chrono::steady_clock;
using detail::BodyRecord;

constexpr std::int32_t kMeasuredPerPiece = 1024;  // owners or particles, handed to a thread at a time

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

bool isFinite(const RigidMotion& m) {
  return m.pose.position.allFinite() && m.pose.orientation.coeffs().allFinite() && m.velocity.allFinite() &&
         m.angularVelocity.allFinite();
}

}  // namespace

/// Takes out what is no longer finite, so that it cannot poison the rest.
void GranularSystem::Impl::quarantineNonFinite(StepReport& report) {
  const detail::Layout& layout = evaluation.layout();
  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) {
    const auto own = layout.numbersOf(o, y.data());
    if (own.position().allFinite() && own.orientation().coeffs().allFinite() && own.velocity().allFinite() &&
        own.angularMomentum().allFinite()) {
      continue;
    }
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
    for (std::int64_t place = begin; place < end; ++place) {
      const std::int32_t o = layout.ownerOfPlace[place];
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
  storeSleepers(dt);
  heat += y[evaluation.heatAt()];
  y[evaluation.heatAt()] = 0.0;
  loadSurroundings();
}

bool GranularSystem::Impl::isBudgetSpent(const StepReport& report) const {
  if (report.subSteps == 0) return false;
  return evaluation.evaluations - evaluationsBefore >= budget.evaluations ||
         (std::isfinite(budget.seconds) && secondsSince(stepBegan) >= budget.seconds);
}

StepReport GranularSystem::Impl::step(double dt, const WorkBudget& allowed) {
  StepReport report;
  if (!(std::isfinite(dt) && dt > 0.0)) {
    report.flags = StepFlag::BadStep;
    report.time = time;
    return report;
  }
  evaluation.stageSeconds.fill(0.0);
  const std::int64_t rebuildsBefore = evaluation.listRebuilds;
  evaluationsBefore = evaluation.evaluations;
  budget = allowed;
  stepBegan = Clock::now();
  for (BodyRecord& record : bodies) record.impulse = {};
  fellAsleep = woken = 0;

  double done = 0.0;
  evaluation.executor().gather([&] {
    while (done < dt && !isBudgetSpent(report)) {
      prepare();  // only when something was added, removed or moved by hand, woke or fell asleep
      partStart = time + done;
      const double part = integrate(dt - done, report);  // sub-steps                 sec. 3.4
      storeState(part);
      quarantineNonFinite(report);  // one bad grain must not poison the pile
      done = part >= dt - done ? dt : done + part;
    }
  });
  time += done;
  if (done < dt) {
    report.flags = report.flags | StepFlag::BudgetExhausted;
    report.droppedTime = dt - done;
  }
  measure(report);
  report.evaluations = evaluation.evaluations - evaluationsBefore;
  report.listRebuilds = evaluation.listRebuilds - rebuildsBefore;
  report.stageSeconds = evaluation.stageSeconds;
  return report;
}

/// Sums over owners and contacts, piece by piece, so that they are the same for any number of threads.
GranularSystem::Impl::Totals GranularSystem::Impl::sumUp() {
  const detail::Layout& layout = evaluation.layout();
  const std::span<const detail::ContactTotals> contacts = evaluation.contactTotals(y);
  const std::int32_t ownerPieces = Executor::pieceCount(layout.dynamicCount(), kMeasuredPerPiece);
  const std::int32_t contactPieces = Executor::pieceCount(layout.dynamicParticles, kMeasuredPerPiece);
  totalsOfPiece.assign(ownerPieces + contactPieces, {});
  evaluation.executor().forPieces(ownerPieces + contactPieces, [&](std::int32_t piece) {
    Totals& sum = totalsOfPiece[piece];
    if (piece < ownerPieces) {
      const std::int32_t begin = piece * kMeasuredPerPiece;
      const std::int32_t end = std::min(layout.dynamicCount(), begin + kMeasuredPerPiece);
      for (std::int32_t o = begin; o < end; ++o) addOwner(o, sum);
    } else {
      const std::int32_t begin = (piece - ownerPieces) * kMeasuredPerPiece;
      const std::int32_t end = std::min(layout.dynamicParticles, begin + kMeasuredPerPiece);
      for (const detail::ContactTotals& row : contacts.subspan(begin, end - begin)) {
        sum.elastic += row.elastic;
        sum.overlap += row.overlap;
      }
    }
  });
  Totals all;
  for (const Totals& sum : totalsOfPiece) {
    all.kinetic += sum.kinetic;
    all.potential += sum.potential;
    all.elastic += sum.elastic;
    all.overlap += sum.overlap;
    all.momentum += sum.momentum;
    all.angularMomentum += sum.angularMomentum;
  }
  return all;
}

void GranularSystem::Impl::addOwner(std::int32_t o, Totals& sum) const {
  const detail::Layout& layout = evaluation.layout();
  const detail::Owner& owner = layout.owners[o];
  const auto own = layout.numbersOf(o, y.data());
  const auto position = own.position(), velocity = own.velocity(), angularMomentum = own.angularMomentum();
  const bool isGrain = owner.kind == OwnerKind::Grain;
  const RigidMotion& motion = isGrain ? grainMotions[owner.index] : bodies[owner.index].motion;
  const double mass = isGrain ? grains[owner.index].mass : bodies[owner.index].mass;
  const Vector3& pull = isGrain ? gravity : evaluation.surroundings().bodyGravity[o - layout.dynamicGrains];
  sum.kinetic += 0.5 * mass * velocity.squaredNorm() + 0.5 * motion.angularVelocity.dot(angularMomentum);
  sum.potential -= mass * owner.body->linearFactor.cwiseProduct(pull).dot(position);
  sum.momentum += mass * velocity;
  sum.angularMomentum += mass * position.cross(velocity) + angularMomentum;
}

void GranularSystem::Impl::measure(StepReport& report) {
  prepare();
  evaluation.measureContacts(true);
  evaluateNow(0.0);
  const auto start = Clock::now();
  const detail::Layout& layout = evaluation.layout();
  const detail::EvaluationSummary& seen = startSummary;
  report.time = time;
  report.candidates = evaluation.candidateCount();
  report.frozenContacts = frozen.size();
  report.contacts = seen.contacts + report.frozenContacts;
  report.largestOverlap = std::max({report.largestOverlap, seen.largestOverlap, frozen.largestOverlap()});
  report.awakeGrains = layout.dynamicGrains;
  report.awakeBodies = layout.dynamicBodies;
  report.fellAsleep = fellAsleep;
  report.woken = woken;
  report.heldImpulse = heldImpulse;
  if (report.largestOverlap > 1.0) report.flags = report.flags | StepFlag::DeepOverlap;

  const Totals sum = sumUp();
  report.energy.kinetic += sum.kinetic;
  report.energy.potential += sum.potential;
  report.energy.elastic += sum.elastic;
  report.momentum += sum.momentum;
  report.angularMomentum += sum.angularMomentum;
  const double overlapSum = frozen.overlapSum() + sum.overlap;
  report.energy.elastic += evaluation.memoryEnergy() + frozen.elastic();
  report.energy.potential += sleepers.potential();
  if (report.contacts > 0) report.meanOverlap = overlapSum / static_cast<double>(report.contacts);
  report.workByMovedBodies = workByMoved;
  report.workByLoads = workByLoads;
  report.dissipated = heat + y[evaluation.heatAt()];
  evaluation.stageSeconds[static_cast<int>(Stage::Measure)] += secondsSince(start);
}

void GranularSystem::Impl::removeGrain(std::int32_t index) {
  removeSleeper({OwnerKind::Grain, index});
  grains[index].alive = grains[index].asleep = false;
  ++grains[index].generation;
  freeGrains.push_back(index);
  --aliveGrains;
  everythingChanged();
}

}  // namespace granular
