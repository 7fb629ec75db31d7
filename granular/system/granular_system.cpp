// SPDX-License-Identifier: MIT
// GranularSystem: what the host added, the state it is in, and the loop of trials that advances it.
#include "granular/system/granular_system.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "granular/base/require.h"
#include "granular/contact/pair_law.h"
#include "granular/dynamics/rkf45.h"
#include "granular/dynamics/step_control.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/layout.h"

namespace granular {
namespace {

namespace state = detail::state;
using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// No trial carries anything farther than this fraction of the smallest radius: larger, and fast grains could
// pass over each other's edges unseen; smaller, and free flight costs evaluations.
constexpr double kLargestMove = 0.25;

// A contact's urgency changes a little within a trial; only a trial longer than this many bounds is tried
// again.
constexpr double kStageSlack = 1.5;

struct GrainRecord {
  GrainShapeId shape;
  MaterialId material;
  double scale = 1.0;
  double mass = 0.0;
  Vector3 inertia = Vector3::Zero();
  ContactFilter filter;
  std::uint32_t generation = 0;
  bool alive = false;
};

struct BodyRecord {
  BodyMotion motionType = BodyMotion::Static;
  Covering covering;
  std::optional<ExactSurface> exact;
  std::vector<ShapeParticle> particles;
  double reach = 0.0;
  MaterialId material;
  double mass = 0.0;
  Vector3 inertia = Vector3::Zero();
  Vector3 linearFactor = Vector3::Ones(), angularFactor = Vector3::Ones();
  ContactFilter filter;
  std::optional<Vector3> gravity;
  Wrench load;
  Wrench impulse;  // of contacts during the last step
  RigidMotion motion;
  std::uint32_t generation = 0;
  bool alive = false;
};

double shorterSubStep(const StepReport& report, double h) {
  return report.shortestSubStep > 0.0 ? std::min(report.shortestSubStep, h) : h;
}

bool isFinite(const RigidMotion& m) {
  return m.pose.position.allFinite() && m.pose.orientation.coeffs().allFinite() && m.velocity.allFinite() &&
         m.angularVelocity.allFinite();
}

void checkMotion(const RigidMotion& m, const std::string& what) {
  requireFinite(m.pose.position, what + ".pose.position", "m");
  requireRotation(m.pose.orientation, what + ".pose.orientation");
  requireFinite(m.velocity, what + ".velocity", "m/s");
  requireFinite(m.angularVelocity, what + ".angularVelocity", "rad/s");
}

void checkIntegrator(const IntegratorDef& def) {
  requirePositive(def.tolerance, "IntegratorDef.tolerance", "radii");
  require(def.contactTimeFraction > 0.0 && def.contactTimeFraction <= 0.3,
          "IntegratorDef.contactTimeFraction", def.contactTimeFraction, "", "in (0, 0.3]");
  requirePositive(def.smallestSubStep, "IntegratorDef.smallestSubStep", "s");
  require(def.trialLimit > 0, "IntegratorDef.trialLimit", def.trialLimit, "trials", "> 0");
}

void checkBody(const BodyDef& def) {
  const std::size_t count = def.covering.positions.size();
  require(count > 0 || def.exact, "BodyDef.covering.positions", 0, "particles",
          "at least one, or BodyDef.exact given");
  require(def.covering.radii.size() == count, "BodyDef.covering.radii", def.covering.radii.size(), "entries",
          "as many as positions");
  require(def.covering.areas.empty() || def.covering.areas.size() == count, "BodyDef.covering.areas",
          def.covering.areas.size(), "entries", "none, or as many as positions");
  for (const Vector3& p : def.covering.positions) requireFinite(p, "BodyDef.covering.positions", "m");
  for (const double r : def.covering.radii) requirePositive(r, "BodyDef.covering.radii", "m");
  for (const Matrix3& a : def.covering.areas) {
    require(a.allFinite() && a.trace() > 0.0, "BodyDef.covering.areas", a.trace(), "m^2 (trace)",
            "finite and > 0");
  }
  if (def.exact) {
    if (const auto* ball = std::get_if<ExactSphere>(&*def.exact))
      requirePositive(ball->radius, "BodyDef.exact.radius", "m");
    require(!std::holds_alternative<HalfSpace>(*def.exact) || def.motion != BodyMotion::Dynamic,
            "BodyDef.motion", "Dynamic", "", "Static or Kinematic for a half-space");
  }
  checkMotion({def.pose, def.velocity, def.angularVelocity}, "BodyDef");
}

void checkBodyMass(double mass, const Vector3& inertia) {
  requirePositive(mass, "BodyDef.mass", "kg");
  require(inertia.allFinite() && inertia.minCoeff() > 0.0, "BodyDef.principalInertia", inertia.transpose(),
          "kg m^2", "finite and > 0 for a dynamic body");
}

}  // namespace

class GranularSystem::Impl {
 public:
  explicit Impl(const SystemDef& def)
      : gravity(def.gravity), integrator(def.integrator), evaluation(def.threads) {}

  // ---- what the host added
  Vector3 gravity;
  IntegratorDef integrator;
  std::vector<MaterialDef> materials;
  std::map<std::pair<std::int32_t, std::int32_t>, MaterialPairDef> pairDefs;
  std::vector<GrainShape> shapes;
  std::vector<GrainRecord> grains;
  std::vector<RigidMotion> grainMotions;  // principal frame, as published
  std::vector<BodyRecord> bodies;
  std::vector<std::int32_t> freeGrains, freeBodies;
  std::vector<std::uint64_t> excludedPairs;  // of body indices
  std::int32_t aliveGrains = 0, aliveBodies = 0;

  // ---- the state
  detail::Evaluation evaluation;
  std::vector<std::int32_t> ownerOfGrain, ownerOfBody;  // in the layout; -1 when not there
  std::vector<double> y;
  Rkf45 stepper;
  StepControl control{Rkf45Table::kErrorOrder};
  double contactTimeAtReference = 0.0;  // turns an error of velocity into one of position, s
  double time = 0.0;
  double heat = 0.0, workByMoved = 0.0, workByLoads = 0.0;
  bool layoutIsOld = true;
  double lastSubStep = 0.0;                // just accepted, s; 0 once its end has been evaluated
  bool startIsCurrent = false;             // the stepper's first stage is that of the present state,
  detail::EvaluationSummary startSummary;  // and this is what it saw

  // ---- look-ups that check
  const GrainRecord& grain(GrainId id) const;
  BodyRecord& body(BodyId id);
  const BodyRecord& body(BodyId id) const;
  void checkMaterialId(MaterialId id, std::string_view field) const;

  // ---- stages of a step
  void prepare();
  void makeLayout();
  std::vector<MaterialPair> combineAllMaterials() const;
  void loadSurroundings();
  void loadState();
  StepReport step(double dt);
  double integrate(double dt, StepReport& report);
  double trialBound(const detail::EvaluationSummary& seen) const;
  double scaledError() const;
  void acceptTrial();
  void storeState(double dt);
  void quarantineNonFinite(StepReport& report);
  void removeGrain(std::int32_t index);
  void measure(StepReport& report);

  void evaluateNow(double t);
  void surroundingsChanged();
  void writeOwner(std::int32_t o, const RigidMotion& motion);
  RigidMotion readOwner(std::int32_t o) const;
};

// ------------------------------------------------------------------------------------------------ look-ups

const GrainRecord& GranularSystem::Impl::grain(GrainId id) const {
  const bool known = id.index >= 0 && id.index < static_cast<std::int32_t>(grains.size()) &&
                     grains[id.index].alive && grains[id.index].generation == id.generation;
  require(known, "GrainId", id.index, "", "the id of a grain that is in the system");
  return grains[id.index];
}

const BodyRecord& GranularSystem::Impl::body(BodyId id) const {
  const bool known = id.index >= 0 && id.index < static_cast<std::int32_t>(bodies.size()) &&
                     bodies[id.index].alive && bodies[id.index].generation == id.generation;
  require(known, "BodyId", id.index, "", "the id of a body that is in the system");
  return bodies[id.index];
}

BodyRecord& GranularSystem::Impl::body(BodyId id) {
  return const_cast<BodyRecord&>(std::as_const(*this).body(id));
}

void GranularSystem::Impl::checkMaterialId(MaterialId id, std::string_view field) const {
  require(id.index >= 0 && id.index < static_cast<std::int32_t>(materials.size()), field, id.index, "",
          "an id that addMaterial returned");
}

// ------------------------------------------------------------------------------------------------ layout and
// state

void GranularSystem::Impl::prepare() {
  if (!layoutIsOld) return;
  const std::vector<detail::RememberedContact> memory = evaluation.exportMemory(y);
  makeLayout();
  loadSurroundings();
  evaluation.reset(combineAllMaterials(), materials);
  contactTimeAtReference = evaluation.referenceContactTime();
  loadState();
  evaluation.importMemory(memory, y);
  layoutIsOld = false;
  startIsCurrent = false;
}

void GranularSystem::Impl::surroundingsChanged() {
  if (layoutIsOld) return;
  loadSurroundings();
  startIsCurrent = false;
}

void GranularSystem::Impl::makeLayout() {
  detail::Layout& layout = evaluation.layout();
  layout = {};
  ownerOfGrain.assign(grains.size(), -1);
  ownerOfBody.assign(bodies.size(), -1);
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(grains.size()); ++g) {
    const GrainRecord& record = grains[g];
    if (!record.alive) continue;
    const GrainShape& shape = shapes[record.shape.index];
    detail::Owner owner;
    owner.kind = OwnerKind::Grain;
    owner.index = g;
    owner.particles = shape.particles;
    owner.scale = record.scale;
    owner.inverseMass = 1.0 / record.mass;
    owner.inertia = record.inertia;
    owner.inverseInertia = record.inertia.cwiseInverse();
    owner.isotropic = shape.isotropic;
    owner.reach = record.scale * shape.boundingRadius;
    owner.material = record.material.index;
    owner.filter = record.filter;
    ownerOfGrain[g] = static_cast<std::int32_t>(layout.owners.size());
    layout.owners.push_back(owner);
  }
  layout.dynamicGrains = static_cast<std::int32_t>(layout.owners.size());
  for (const BodyMotion type : {BodyMotion::Dynamic, BodyMotion::Kinematic, BodyMotion::Static}) {
    for (std::int32_t b = 0; b < static_cast<std::int32_t>(bodies.size()); ++b) {
      const BodyRecord& record = bodies[b];
      if (!record.alive || record.motionType != type) continue;
      detail::Owner owner;
      owner.kind = OwnerKind::Body;
      owner.index = b;
      owner.particles = record.particles;
      owner.areas = record.covering.areas;
      if (record.exact) owner.exact = &*record.exact;
      owner.reach = record.reach;
      owner.material = record.material.index;
      owner.filter = record.filter;
      if (type == BodyMotion::Dynamic) {
        owner.inverseMass = 1.0 / record.mass;
        owner.inertia = record.inertia;
        owner.inverseInertia = record.inertia.cwiseInverse();
        owner.isotropic = record.inertia.minCoeff() == record.inertia.maxCoeff();
        owner.linearFactor = record.linearFactor;
        owner.angularFactor = record.angularFactor;
        owner.freeAxes = (record.angularFactor.array() != 0.0).cast<double>();
        owner.isLocked = owner.freeAxes != Vector3::Ones();
        ++layout.dynamicBodies;
      } else if (type == BodyMotion::Kinematic) {
        ++layout.kinematicBodies;
      }
      ownerOfBody[b] = static_cast<std::int32_t>(layout.owners.size());
      layout.owners.push_back(owner);
    }
  }
  std::vector<std::uint64_t> excludedOwners;
  for (const std::uint64_t pair : excludedPairs) {
    const std::int32_t a = ownerOfBody[pair >> 32], b = ownerOfBody[pair & 0xffffffffu];
    if (a >= 0 && b >= 0) excludedOwners.push_back(MeetingRules::pairKey(a, b));
  }
  layout.finish(excludedOwners);
}

std::vector<MaterialPair> GranularSystem::Impl::combineAllMaterials() const {
  const auto count = static_cast<std::int32_t>(materials.size());
  std::vector<MaterialPair> pairs(materials.size() * materials.size());
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a; b < count; ++b) {
      const auto found = pairDefs.find({a, b});
      const MaterialPairDef def = found == pairDefs.end() ? MaterialPairDef{} : found->second;
      pairs[a * count + b] = pairs[b * count + a] = combineMaterials(materials[a], materials[b], def);
    }
  }
  return pairs;
}

void GranularSystem::Impl::loadSurroundings() {
  detail::Surroundings& s = evaluation.surroundings();
  const detail::Layout& layout = evaluation.layout();
  s.gravity = gravity;
  s.bodyGravity.clear();
  s.bodyLoad.clear();
  s.kinematic.clear();
  s.fixed.clear();
  for (std::int32_t o = layout.dynamicGrains; o < static_cast<std::int32_t>(layout.owners.size()); ++o) {
    const BodyRecord& record = bodies[layout.owners[o].index];
    if (record.motionType == BodyMotion::Dynamic) {
      s.bodyGravity.push_back(record.gravity.value_or(gravity));
      s.bodyLoad.push_back(record.load);
    } else {
      (record.motionType == BodyMotion::Kinematic ? s.kinematic : s.fixed).push_back(record.motion);
    }
  }
}

void GranularSystem::Impl::writeOwner(std::int32_t o, const RigidMotion& motion) {
  double* own = y.data() + o * state::kSize;
  const detail::Owner& owner = evaluation.layout().owners[o];
  const Quaternion& q = motion.pose.orientation;
  Eigen::Map<Vector3>(own + state::kPosition) = motion.pose.position;
  own[state::kOrientation] = q.w();
  own[state::kOrientation + 1] = q.x();
  own[state::kOrientation + 2] = q.y();
  own[state::kOrientation + 3] = q.z();
  Eigen::Map<Vector3>(own + state::kVelocity) = motion.velocity;
  const Vector3 momentum = q * owner.inertia.cwiseProduct(q.conjugate() * motion.angularVelocity);
  Eigen::Map<Vector3>(own + state::kAngularMomentum) = momentum;
}

RigidMotion GranularSystem::Impl::readOwner(std::int32_t o) const {
  const double* own = y.data() + o * state::kSize;
  const detail::Owner& owner = evaluation.layout().owners[o];
  const double* q = own + state::kOrientation;
  RigidMotion motion;
  motion.pose = {Eigen::Map<const Vector3>(own + state::kPosition), Quaternion(q[0], q[1], q[2], q[3])};
  motion.velocity = Eigen::Map<const Vector3>(own + state::kVelocity);
  const Vector3 angularMomentum = Eigen::Map<const Vector3>(own + state::kAngularMomentum);
  motion.angularVelocity =
      motion.pose.orientation *
      owner.inverseInertia.cwiseProduct(motion.pose.orientation.conjugate() * angularMomentum);
  if (owner.isLocked) motion.angularVelocity = owner.freeAxes.cwiseProduct(motion.angularVelocity);
  return motion;
}

void GranularSystem::Impl::loadState() {
  const detail::Layout& layout = evaluation.layout();
  y.assign(evaluation.stateSize(), 0.0);
  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) {
    const detail::Owner& owner = layout.owners[o];
    writeOwner(o, owner.kind == OwnerKind::Grain ? grainMotions[owner.index] : bodies[owner.index].motion);
  }
}

// ------------------------------------------------------------------------------------------------
// integration

/// Longest trial that what was seen allows, s.
double GranularSystem::Impl::trialBound(const detail::EvaluationSummary& seen) const {
  double bound = std::numeric_limits<double>::infinity();
  if (seen.urgency > 0.0) bound = integrator.contactTimeFraction * contactTimeOfUrgency(seen.urgency);
  if (seen.largestSpeed > 0.0) {
    bound = std::min(bound, kLargestMove * evaluation.layout().smallestRadius / seen.largestSpeed);
  }
  return std::max(bound, integrator.smallestSubStep);
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

    const bool forced = report.subSteps + report.rejectedTrials >= integrator.trialLimit;
    const double bound =
        forced ? std::max(trialBound(startSummary), dt / integrator.trialLimit) : trialBound(startSummary);
    const double h = forced ? std::min(dt - t, bound) : control.propose(dt - t, bound);
    detail::EvaluationSummary seen = startSummary;
    stepper.trial(y, t, h, evaluation.executor(),
                  [&](double at, const std::vector<double>& s, std::vector<double>& rate) {
                    evaluation.evaluate(at, s, rate, at - t);
                    seen.urgency = std::max(seen.urgency, evaluation.summary().urgency);
                  });

    const auto stepStart = Clock::now();
    const bool smallest = h <= integrator.smallestSubStep;
    const double error = scaledError();
    bool accept = forced || smallest;
    if (h > kStageSlack * trialBound(seen) && !accept) {
      control.shorten(trialBound(seen));  // RKF45's blind second stage may be the only one that saw it
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
      if (forced) report.flags = report.flags | StepFlag::TrialLimitReached;
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

// ------------------------------------------------------------------------------------------------ the step

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

// ------------------------------------------------------------------------------------------------ the public
// face

GranularSystem::GranularSystem(const SystemDef& def) {
  requireFinite(def.gravity, "SystemDef.gravity", "m/s^2");
  require(def.threads > 0, "SystemDef.threads", def.threads, "threads", "> 0");
  checkIntegrator(def.integrator);
  impl_ = std::make_unique<Impl>(def);
}
GranularSystem::~GranularSystem() = default;
GranularSystem::GranularSystem(GranularSystem&&) noexcept = default;
GranularSystem& GranularSystem::operator=(GranularSystem&&) noexcept = default;

MaterialId GranularSystem::addMaterial(const MaterialDef& def) {
  checkMaterial(def);
  impl_->materials.push_back(def);
  impl_->layoutIsOld = true;
  return {static_cast<std::int32_t>(impl_->materials.size()) - 1};
}

void GranularSystem::setMaterialPair(MaterialId a, MaterialId b, const MaterialPairDef& def) {
  impl_->checkMaterialId(a, "MaterialId");
  impl_->checkMaterialId(b, "MaterialId");
  checkMaterialPair(def);
  impl_->pairDefs[std::minmax(a.index, b.index)] = def;
  impl_->layoutIsOld = true;
}

GrainShapeId GranularSystem::addGrainShape(const GrainShapeDef& def) {
  impl_->shapes.push_back(makeGrainShape(def));
  impl_->layoutIsOld = true;  // the layout points into the shapes
  return {static_cast<std::int32_t>(impl_->shapes.size()) - 1};
}

GrainId GranularSystem::addGrain(const GrainDef& def) {
  Impl& s = *impl_;
  require(def.shape.index >= 0 && def.shape.index < static_cast<std::int32_t>(s.shapes.size()),
          "GrainDef.shape", def.shape.index, "", "an id that addGrainShape returned");
  s.checkMaterialId(def.material, "GrainDef.material");
  requirePositive(def.scale, "GrainDef.scale", "");
  checkMotion({def.pose, def.velocity, def.angularVelocity}, "GrainDef");

  const GrainShape& shape = s.shapes[def.shape.index];
  std::int32_t index = static_cast<std::int32_t>(s.grains.size());
  if (s.freeGrains.empty()) {
    s.grains.emplace_back();
    s.grainMotions.emplace_back();
  } else {
    index = s.freeGrains.back();
    s.freeGrains.pop_back();
  }
  const double density = s.materials[def.material.index].density;
  GrainRecord& record = s.grains[index];
  record = {.shape = def.shape,
            .material = def.material,
            .scale = def.scale,
            .mass = density * shape.volume * std::pow(def.scale, 3),
            .inertia = density * std::pow(def.scale, 5) * shape.unitInertia,
            .filter = def.filter,
            .generation = record.generation,
            .alive = true};
  const Quaternion orientation = def.pose.orientation.normalized();
  s.grainMotions[index] = {
      .pose = {def.pose.position + orientation * (def.scale * shape.principalFrame.position),
               (orientation * shape.principalFrame.orientation).normalized()},
      .velocity = def.velocity,
      .angularVelocity = def.angularVelocity};
  ++s.aliveGrains;
  s.layoutIsOld = true;
  return {index, record.generation};
}

void GranularSystem::removeGrain(GrainId id) {
  impl_->grain(id);
  impl_->removeGrain(id.index);
}

BodyId GranularSystem::addBody(const BodyDef& def) {
  Impl& s = *impl_;
  checkBody(def);
  s.checkMaterialId(def.material, "BodyDef.material");
  if (def.motion == BodyMotion::Dynamic) checkBodyMass(def.mass, def.principalInertia);
  std::int32_t index = static_cast<std::int32_t>(s.bodies.size());
  if (s.freeBodies.empty()) {
    s.bodies.emplace_back();
  } else {
    index = s.freeBodies.back();
    s.freeBodies.pop_back();
  }
  BodyRecord record;
  record.motionType = def.motion;
  record.covering = def.covering;
  record.exact = def.exact;
  for (std::size_t i = 0; i < def.covering.positions.size(); ++i) {
    const ShapeParticle particle{def.covering.positions[i], def.covering.radii[i]};
    record.particles.push_back(particle);
    record.reach = std::max(record.reach, particle.position.norm() + particle.radius);
  }
  if (def.exact) {
    if (const auto* ball = std::get_if<ExactSphere>(&*def.exact))
      record.reach = std::max(record.reach, ball->radius);
  }
  record.material = def.material;
  record.mass = def.mass;
  record.inertia = def.principalInertia;
  record.linearFactor = def.linearFactor;
  record.angularFactor = def.angularFactor;
  record.filter = def.filter;
  record.motion.pose = {def.pose.position, def.pose.orientation.normalized()};
  if (def.motion != BodyMotion::Static) {
    record.motion.velocity = def.velocity;
    record.motion.angularVelocity = def.angularVelocity;
  }
  record.generation = s.bodies[index].generation;
  record.alive = true;
  s.bodies[index] = std::move(record);
  ++s.aliveBodies;
  s.layoutIsOld = true;
  return {index, s.bodies[index].generation};
}

void GranularSystem::removeBody(BodyId id) {
  Impl& s = *impl_;
  BodyRecord& record = s.body(id);
  record.alive = false;
  ++record.generation;
  s.freeBodies.push_back(id.index);
  std::erase_if(s.excludedPairs, [&](std::uint64_t pair) {
    return static_cast<std::int32_t>(pair >> 32) == id.index ||
           static_cast<std::int32_t>(pair & 0xffffffffu) == id.index;
  });
  --s.aliveBodies;
  s.layoutIsOld = true;
}

void GranularSystem::setBodyPairContact(BodyId a, BodyId b, bool enabled) {
  Impl& s = *impl_;
  s.body(a);
  s.body(b);
  const std::uint64_t key = MeetingRules::pairKey(a.index, b.index);
  const auto found = std::find(s.excludedPairs.begin(), s.excludedPairs.end(), key);
  if (enabled == (found == s.excludedPairs.end())) return;
  if (enabled) {
    s.excludedPairs.erase(found);
  } else {
    s.excludedPairs.push_back(key);
  }
  s.layoutIsOld = true;
}

void GranularSystem::setGravity(const Vector3& gravity) {
  requireFinite(gravity, "gravity", "m/s^2");
  if (gravity == impl_->gravity) return;
  impl_->gravity = gravity;
  impl_->surroundingsChanged();
}
const Vector3& GranularSystem::gravity() const {
  return impl_->gravity;
}

void GranularSystem::setIntegrator(const IntegratorDef& def) {
  checkIntegrator(def);
  impl_->integrator = def;
}
const IntegratorDef& GranularSystem::integrator() const {
  return impl_->integrator;
}
int GranularSystem::threads() const {
  return impl_->evaluation.executor().threads();
}

StepReport GranularSystem::step(double dt) {
  return impl_->step(dt);
}
double GranularSystem::time() const {
  return impl_->time;
}

void GranularSystem::setBodyMotion(BodyId id, const RigidMotion& motion) {
  Impl& s = *impl_;
  BodyRecord& record = s.body(id);
  checkMotion(motion, "RigidMotion");
  record.motion = motion;
  record.motion.pose.orientation.normalize();
  if (s.layoutIsOld) return;
  s.surroundingsChanged();
  if (record.motionType == BodyMotion::Dynamic) s.writeOwner(s.ownerOfBody[id.index], record.motion);
  if (record.motionType == BodyMotion::Static) s.evaluation.placeFixed();
}

RigidMotion GranularSystem::bodyMotion(BodyId id) const {
  return impl_->body(id).motion;
}

void GranularSystem::setBodyLoad(BodyId id, const Wrench& load) {
  BodyRecord& record = impl_->body(id);
  requireFinite(load.force, "load.force", "N");
  requireFinite(load.torque, "load.torque", "N m");
  if (load.force == record.load.force && load.torque == record.load.torque) return;
  record.load = load;
  impl_->surroundingsChanged();
}

void GranularSystem::setBodyGravity(BodyId id, const Vector3& gravity) {
  BodyRecord& record = impl_->body(id);
  requireFinite(gravity, "gravity", "m/s^2");
  if (record.gravity == gravity) return;
  record.gravity = gravity;
  impl_->surroundingsChanged();
}

void GranularSystem::setBodyMass(BodyId id, double mass, const Vector3& principalInertia) {
  BodyRecord& record = impl_->body(id);
  checkBodyMass(mass, principalInertia);
  if (mass == record.mass && principalInertia == record.inertia) return;
  record.mass = mass;
  record.inertia = principalInertia;
  impl_->layoutIsOld = true;
}

void GranularSystem::setBodyFactors(BodyId id, const Vector3& linearFactor, const Vector3& angularFactor) {
  BodyRecord& record = impl_->body(id);
  requireFinite(linearFactor, "linearFactor", "");
  requireFinite(angularFactor, "angularFactor", "");
  if (linearFactor == record.linearFactor && angularFactor == record.angularFactor) return;
  record.linearFactor = linearFactor;
  record.angularFactor = angularFactor;
  impl_->layoutIsOld = true;
}

Wrench GranularSystem::contactImpulse(BodyId id) const {
  return impl_->body(id).impulse;
}

Wrench GranularSystem::contactWrench(BodyId id) {
  Impl& s = *impl_;
  s.body(id);
  s.prepare();
  s.evaluateNow(0.0);
  const detail::Layout& layout = s.evaluation.layout();
  const std::int32_t owner = s.ownerOfBody[id.index];
  const Vector3 center = s.bodies[id.index].motion.pose.position;
  Wrench sum;
  s.evaluation.forEachContact(
      [&](const detail::Contact& contact, const detail::ContactForce& f, const PairLaw&) {
        const bool first = layout.ownerOfSlot[contact.slot1] == owner;
        if (!first && layout.ownerOfSlot[contact.slot2] != owner) return;
        const Vector3 force = first ? f.force : Vector3(-f.force);
        sum.force += force;
        sum.torque += (f.point - center).cross(force);
      });
  return sum;
}

BodyMotion GranularSystem::bodyMotionType(BodyId id) const {
  return impl_->body(id).motionType;
}

std::int32_t GranularSystem::grainCount() const {
  return impl_->aliveGrains;
}
std::int32_t GranularSystem::bodyCount() const {
  return impl_->aliveBodies;
}

std::int64_t GranularSystem::particleCount() const {
  std::int64_t count = 0;
  for (const GrainRecord& record : impl_->grains) {
    if (record.alive) count += static_cast<std::int64_t>(impl_->shapes[record.shape.index].particles.size());
  }
  for (const BodyRecord& record : impl_->bodies) {
    if (record.alive) count += static_cast<std::int64_t>(record.particles.size());
  }
  return count;
}

std::span<const RigidMotion> GranularSystem::grainMotions() const {
  return impl_->grainMotions;
}

bool GranularSystem::isAlive(GrainId id) const {
  return id.index >= 0 && id.index < static_cast<std::int32_t>(impl_->grains.size()) &&
         impl_->grains[id.index].alive && impl_->grains[id.index].generation == id.generation;
}

GrainId GranularSystem::grainAt(std::int32_t index) const {
  const auto count = static_cast<std::int32_t>(impl_->grains.size());
  if (index < 0 || index >= count || !impl_->grains[index].alive) return {};
  return {index, impl_->grains[index].generation};
}

void GranularSystem::setGrainMotion(GrainId id, const RigidMotion& motion) {
  Impl& s = *impl_;
  s.grain(id);
  checkMotion(motion, "RigidMotion");
  RigidMotion& own = s.grainMotions[id.index];
  own = motion;
  own.pose.orientation.normalize();
  if (s.layoutIsOld) return;
  s.writeOwner(s.ownerOfGrain[id.index], own);
  s.startIsCurrent = false;
}

const GrainShape& GranularSystem::grainShape(GrainShapeId id) const {
  require(id.index >= 0 && id.index < static_cast<std::int32_t>(impl_->shapes.size()), "GrainShapeId",
          id.index, "", "an id that addGrainShape returned");
  return impl_->shapes[id.index];
}
GrainShapeId GranularSystem::shapeOf(GrainId id) const {
  return impl_->grain(id).shape;
}
MaterialId GranularSystem::materialOf(GrainId id) const {
  return impl_->grain(id).material;
}
double GranularSystem::scaleOf(GrainId id) const {
  return impl_->grain(id).scale;
}
double GranularSystem::massOf(GrainId id) const {
  return impl_->grain(id).mass;
}
const MaterialDef& GranularSystem::material(MaterialId id) const {
  impl_->checkMaterialId(id, "MaterialId");
  return impl_->materials[id.index];
}
const Covering& GranularSystem::covering(BodyId id) const {
  return impl_->body(id).covering;
}

void GranularSystem::readParticles(std::vector<ParticleView>& particles) const {
  particles.clear();
  const auto append = [&](std::span<const ShapeParticle> own, double scale, const Pose& pose, OwnerKind kind,
                          std::int32_t index) {
    for (const ShapeParticle& p : own) {
      particles.push_back({pose.toWorld(scale * p.position), scale * p.radius, kind, index});
    }
  };
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(impl_->grains.size()); ++g) {
    const GrainRecord& record = impl_->grains[g];
    if (!record.alive) continue;
    append(impl_->shapes[record.shape.index].particles, record.scale, impl_->grainMotions[g].pose,
           OwnerKind::Grain, g);
  }
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(impl_->bodies.size()); ++b) {
    const BodyRecord& record = impl_->bodies[b];
    if (record.alive) append(record.particles, 1.0, record.motion.pose, OwnerKind::Body, b);
  }
}

void GranularSystem::readContacts(std::vector<ContactView>& contacts) {
  contacts.clear();
  impl_->prepare();
  impl_->evaluateNow(0.0);
  const detail::Layout& layout = impl_->evaluation.layout();
  impl_->evaluation.forEachContact(
      [&](const detail::Contact& contact, const detail::ContactForce& f, const PairLaw&) {
        ContactView view;
        const std::int32_t slots[2] = {contact.slot1, contact.slot2};
        for (int side = 0; side < 2; ++side) {
          const detail::Owner& owner = layout.owners[layout.ownerOfSlot[slots[side]]];
          view.ownerKind[side] = owner.kind;
          view.ownerIndex[side] = owner.index;
          view.particle[side] =
              slots[side] < layout.particleCount ? layout.rankOfSlot[slots[side]] - owner.firstRank : -1;
        }
        view.point = f.point;
        view.force = f.force;
        view.overlap = f.overlap;
        contacts.push_back(view);
      });
}

StepReport GranularSystem::measure() {
  StepReport report;
  impl_->measure(report);
  return report;
}

double GranularSystem::creepSpeed(MaterialId a, MaterialId b, double mass, double particleRadius) const {
  const Impl& s = *impl_;
  s.checkMaterialId(a, "MaterialId");
  s.checkMaterialId(b, "MaterialId");
  const auto found = s.pairDefs.find(std::minmax(a.index, b.index));
  const MaterialPair pair = combineMaterials(s.materials[a.index], s.materials[b.index],
                                             found == s.pairDefs.end() ? MaterialPairDef{} : found->second);
  const auto side = [&](MaterialId m) {
    const MaterialDef& material = s.materials[m.index];
    return PairSide{
        .contact = {1.0 / mass, 1.0 / particleRadius, material.youngsModulus, material.poissonRatio}};
  };
  return mass * s.gravity.norm() / makePairLaw(pair, side(a), side(b)).shear.viscosity;
}

}  // namespace granular
