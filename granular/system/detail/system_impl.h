// SPDX-License-Identifier: MIT
// What a GranularSystem holds: what the host added, the state it is in, and the stages of its step.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "granular/contact/pair_law.h"
#include "granular/dynamics/step_control.h"
#include "granular/dynamics/step_method.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/frozen_contacts.h"
#include "granular/system/detail/grain_equations.h"
#include "granular/system/detail/layout.h"
#include "granular/system/detail/sleeper_grid.h"
#include "granular/system/detail/sleepers.h"
#include "granular/system/granular_system.h"

namespace granular {

namespace detail {

struct GrainRecord {
  GrainShapeId shape;
  MaterialId material;
  double scale = 1.0;
  double mass = 0.0;  // kg
  ContactFilter filter;
  std::uint32_t generation = 0;
  bool alive = false;
  bool maySleep = true, asleep = false;
};

struct BodyRecord {
  BodyMotion motionType = BodyMotion::Static;
  Covering covering;
  std::optional<ExactSurface> exact;
  Pose exactPose;
  ExactUse exactUse = ExactUse::Everything;
  std::vector<ShapeParticle> particles;
  std::vector<std::int32_t> firstPiece;  // of covering.pieces, by particle; one entry more
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
  bool maySleep = true, asleep = false;
};

}  // namespace detail

class GranularSystem::Impl {
 public:
  explicit Impl(const SystemDef& def)
      : gravity(def.gravity),
        integrator(def.integrator),
        evaluation(def.threads, def.executor),
        sleep(def.sleep) {
    evaluation.usePrecision(def.integrator.precision);
    equations.turnSpheres(def.integrator.turnSpheres);
    setStepper();
  }

  struct ErrorOfPiece {
    double largest = 0.0, sumOfSquares = 0.0;  // m, m^2
  };
  /// Sums over owners, their motion, and over contacts.
  struct Totals {
    double kinetic = 0.0, potential = 0.0, elastic = 0.0;  // J
    double overlap = 0.0;                                  // in smaller radii of the pairs
    Vector3 momentum = Vector3::Zero(), angularMomentum = Vector3::Zero();
  };
  struct Trial {
    double length = 0.0;          // s
    bool isLoose = false;         // beyond IntegratorDef::trialLimit
    bool isSmallest = false;      // at IntegratorDef::smallestSubStep
    bool mustBeAccepted = false;  // whatever its error
  };
  /// Where an owner was when it was found out which sleepers are near, and within how far they are.
  struct Watch {
    Vector3 center;    // m
    double way = 0.0;  // m; negative: nothing was looked for
  };

  // ---- what the host added
  Vector3 gravity;
  IntegratorDef integrator;
  std::vector<MaterialDef> materials;
  std::map<std::pair<std::int32_t, std::int32_t>, MaterialPairDef> pairDefs;
  std::vector<MaterialPair> combined;  // of any two materials; none where one has changed since
  std::vector<GrainShape> shapes;
  std::vector<detail::GrainRecord> grains;
  std::vector<RigidMotion> grainMotions;  // principal frame, as published
  std::vector<detail::BodyRecord> bodies;
  std::vector<std::int32_t> freeGrains, freeBodies;
  std::vector<std::uint64_t> excludedPairs;  // of body indices
  std::int32_t aliveGrains = 0, aliveBodies = 0;

  // ---- the state
  detail::Evaluation evaluation;
  detail::GrainEquations equations{evaluation};
  std::vector<std::int32_t> ownerOfGrain, ownerOfBody;  // in the layout; -1 when not there
  std::vector<double> y;
  std::unique_ptr<StepMethod> stepper;
  StepControl control;
  std::vector<ErrorOfPiece> errorOfPiece;
  std::vector<Totals> totalsOfPiece;
  std::vector<double> wayOfOwner;                             // error of the last trial, m
  std::optional<std::vector<RememberedContact>> givenMemory;  // comes in place of what the layout had
  double lastShearRate = 0.0;                                 // 1/s, as Impl::shearRate,
  int shearRateAge = 0;                                       // of so many sub-steps ago,
  std::int64_t shearRateContacts = 0;                         // when there were so many contacts
  double contactTimeAtReference = 0.0;  // turns an error of velocity into one of position, s
  double time = 0.0;
  double heat = 0.0, workByMoved = 0.0, workByLoads = 0.0;
  bool layoutIsOld = true;
  WorkBudget budget;                                  // of the present step,
  std::int64_t evaluationsBefore = 0;                 // which began at this count
  std::chrono::steady_clock::time_point stepBegan{};  // and moment
  double lastSubStep = 0.0;                           // just accepted, s; 0 once its end has been evaluated
  bool startIsCurrent = false;             // the stepper's first stage is that of the present state,
  detail::EvaluationSummary startSummary;  // and this is what it saw

  // ---- sleep
  SleepDef sleep;
  detail::FrozenContacts frozen;
  std::vector<RememberedContact> thawed;  // of contacts frozen no longer, for the next layout
  detail::Sleepers sleepers{[this](detail::OwnerKey owner) { return traitsOf(owner); }};
  std::vector<std::int32_t> awakeGrains;  // in order
  detail::SleeperGrid sleepingGrains;
  bool layoutHasAll = true;    // or only those sleepers that are near who is
  std::vector<Watch> watched;  // by owner that does not sleep; nothing where the layout has all
  double smallestRadius = 0.0, largestRadius = 0.0;  // as in Layout, of all that is there, m
  std::vector<Wrench> frozenOnKinematic;             // since the layout was made
  bool everythingIsOld = true;  // something was added or removed, so that scales are measured anew
  std::vector<detail::Rest> restOfGrain, restOfBody;  // by index
  std::vector<std::optional<Pose>> guardedFrom;       // by BodyId::index: as in wakeNearMoving
  std::vector<std::int32_t> placedBodies;             // by hand since the last sub-step, not dynamic ones
  double partStart = 0.0;                             // simulated time when the present integrate() began, s
  double clock = 0.0;                                 // simulated time when sleepers were last looked at, s
  double nextInspection = 0.0;                        // s
  double nextWaking = 0.0;                            // s; before, only who cannot wait wakes
  Vector3 heldImpulse = Vector3::Zero();              // N s
  std::int64_t fellAsleep = 0, woken = 0;             // since the step began

  // ---- look-ups that check
  const detail::GrainRecord& grain(GrainId id) const;
  detail::BodyRecord& body(BodyId id);
  const detail::BodyRecord& body(BodyId id) const;
  void checkMaterialId(MaterialId id, std::string_view field) const;

  // ---- stages of a step
  void prepare();
  void makeLayout();
  void noteFilters();
  std::int32_t addGrains(const std::vector<std::int32_t>& indices);
  void measureScales();
  void everythingChanged();
  std::int32_t addBodies(BodyMotion type, bool asleep);
  const std::vector<MaterialPair>& materialPairs();
  void loadSurroundings();
  void loadState();
  void sortState();
  StepReport step(double dt, const WorkBudget& allowed);
  bool isBudgetSpent(const StepReport& report) const;
  double integrate(double dt, StepReport& report);
  double shearRate(const detail::EvaluationSummary& seen);
  double trialBound(const detail::EvaluationSummary& seen);
  double eventBound() const;
  Trial planTrial(double dt, double remaining, const StepReport& report);
  bool isResultFinite();
  double scaledError();
  double wayOfError(const detail::OwnerNumbers<const double>& error, std::int32_t place) const;
  bool isTooLong(const Trial& trial);
  bool judge(const Trial& trial, double scaledError);
  void acceptTrial(const Trial& trial, bool isLast, StepReport& report);
  void storeState(double dt);
  void quarantineNonFinite(StepReport& report);
  void removeGrain(std::int32_t index);
  void measure(StepReport& report);
  Totals sumUp();
  void addOwner(std::int32_t o, Totals& sum) const;

  // ---- sleep (system_sleep.cpp, system_near.cpp, system_frozen.cpp)
  bool isAwake(OwnerKind kind, std::int32_t index) const;
  void wake(OwnerKind kind, std::int32_t index);
  void wakeAll();
  void wakeTouching(std::int32_t body);
  void notePlaced(std::int32_t body);
  bool exists(OwnerKind kind, std::int32_t index) const;
  bool exists(const RememberedContact& c) const;
  std::vector<RememberedContact> memoryOfAwake();
  std::vector<RememberedContact> amongAwake(std::vector<RememberedContact> memory) const;
  bool isAsleep(detail::OwnerKey owner) const;
  void thaw(detail::OwnerKey owner);
  void removeSleeper(detail::OwnerKey owner);
  detail::SleeperTraits traitsOf(detail::OwnerKey owner) const;
  void loadSleepers();
  void updateAwakeGrains();
  std::vector<std::int32_t> findNearSleepers();
  Watch watchOf(std::int32_t o, bool isPlaced) const;
  bool leavesNear() const;
  bool sleepOrWake(double now);
  bool wakeUnbalanced(double now, double passed);
  bool wakeNearMoving();
  bool movesUnfelt(std::int32_t o) const;
  bool fallAsleep();
  std::vector<char> findQuiet();
  void keepAwakeNearMoving(std::vector<char>& quiet) const;
  void markNear(std::int32_t body, std::int32_t first, std::int32_t last, std::vector<char>& near) const;
  void freeze(const std::vector<char>& quiet);
  void noteFrozenOnKinematic();
  void storeSleepers(double dt);
  void addFrozen(std::vector<ContactView>& contacts) const;
  void putToSleep(const SleepState& kept);

  void setStepper();
  void evaluateNow(double t);
  void startIsEvaluated();
  void surroundingsChanged();
  Vector3 inertiaOf(const detail::GrainRecord& record) const;
  const RigidMotion& motionOf(const detail::Owner& owner) const;
  void writeOwner(std::int32_t o, const RigidMotion& motion);
  RigidMotion readOwner(std::int32_t o) const;
};

}  // namespace granular
