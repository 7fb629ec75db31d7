// SPDX-License-Identifier: MIT
// The system: grains and covered bodies in, step(), report out. Knows nothing of Bullet.
//
//   granular::GranularSystem sand({.gravity = {0, -9.81, 0}});
//   auto stone = sand.addMaterial({.name = "stone"});
//   auto tetra = sand.addGrainShape(granular::tetrahedronShape(0.005));
//   sand.addGrain({.shape = tetra, .material = stone, .pose = {.position = {0, 0.1, 0}}});
//   granular::StepReport report = sand.step(1.0 / 60.0);
//
// Set-up calls throw std::invalid_argument naming field, value, range and unit. step() never throws.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/base/pose.h"
#include "granular/contact/material.h"
#include "granular/dynamics/integrator.h"
#include "granular/dynamics/rigid_motion.h"
#include "granular/geometry/covering.h"
#include "granular/geometry/exact_surface.h"
#include "granular/system/grain_shape.h"
#include "granular/system/sleep.h"
#include "granular/system/step_report.h"

namespace granular {

/// Names a grain. The generation tells a removed grain from one that took its place.
struct GrainId {
  std::int32_t index = -1;
  std::uint32_t generation = 0;
  friend bool operator==(GrainId, GrainId) = default;
};

/// Names a covered body.
struct BodyId {
  std::int32_t index = -1;
  std::uint32_t generation = 0;
  friend bool operator==(BodyId, BodyId) = default;
};

struct SystemDef {
  Vector3 gravity = {0.0, -9.81, 0.0};  ///< m/s^2
  IntegratorDef integrator = {};
  SleepDef sleep = {};
  int threads = 1;  ///< > 0; results are the same bits for every number
  /// Runs the loops of every step in place of threads of our own, with the same bits; must outlive the
  /// system. Null: `threads`.
  HostExecutor* executor = nullptr;
};

/// How much work a step may be. Whatever runs out first ends the step after the sub-step that it is in: then
/// less time has gone by than was asked for, all of it as accurate as ever (StepReport::droppedTime,
/// StepFlag::BudgetExhausted). A step makes one sub-step at least.
struct WorkBudget {
  std::int64_t evaluations = std::numeric_limits<std::int64_t>::max();  ///< >= 0; the same on any machine
  double seconds = std::numeric_limits<double>::infinity();             ///< of wall time, >= 0
};

/// Which things meet: two owners are paired only if each one's group is in the other's mask (as in Bullet).
struct ContactFilter {
  std::uint32_t group = 1u;
  std::uint32_t mask = 0xffffffffu;
};

struct GrainDef {
  GrainShapeId shape = {};
  MaterialId material = {};
  Pose pose = {};                             ///< of the frame the shape's GrainShapeDef was drawn in
  Vector3 velocity = Vector3::Zero();         ///< of the centre of mass, m/s, world
  Vector3 angularVelocity = Vector3::Zero();  ///< rad/s, world
  double scale = 1.0;                         ///< all lengths of the shape times this, > 0
  ContactFilter filter = {};
  bool maySleep = true;  ///< where SleepDef::enabled
};

enum class BodyMotion : std::uint8_t {
  Static,     ///< never moves unless the host says so between steps; feels nothing
  Kinematic,  ///< moves with the velocity the host gives, feels nothing; its work is counted
  Dynamic,    ///< integrated together with the grains
};

/// Whom a body's exact surface is for.
enum class ExactUse : std::uint8_t {
  Everything,  ///< all particles meet it, besides the body's own particles
  /// Particles of other bodies meet it in place of the body's particles, which are left for grains. Two
  /// bodies that both have such a surface and move freely meet both ways, each with half the stiffness.
  /// Particles against particles nest: their faces sink into each other and lock.
  Bodies,
};

/// A rigid body whose surface carries particles. Body frame: origin at the centre of mass, principal axes of
/// inertia.
struct BodyDef {
  BodyMotion motion = BodyMotion::Static;
  Covering covering = {};  ///< at least one particle, unless an exact surface is given
  std::optional<ExactSurface> exact = std::nullopt;  ///< met by particles
  Pose exactPose = {};                               ///< of its frame in the body frame
  ExactUse exactUse = ExactUse::Everything;
  MaterialId material = {};
  double mass = 0.0;                           ///< kg; > 0 for dynamic bodies, ignored for others
  Vector3 principalInertia = Vector3::Zero();  ///< kg m^2; > 0 for dynamic bodies
  Pose pose = {};
  Vector3 velocity = Vector3::Zero();         ///< m/s, world; dynamic and kinematic
  Vector3 angularVelocity = Vector3::Zero();  ///< rad/s, world
  Vector3 linearFactor = Vector3::Ones();     ///< multiplies the acceleration, world axes; 0 locks an axis
  Vector3 angularFactor = Vector3::Ones();    ///< multiplies the torque, world axes
  ContactFilter filter = {};
  bool maySleep = true;  ///< where SleepDef::enabled; dynamic bodies
};

enum class OwnerKind : std::uint8_t { Grain, Body };

/// One round particle as it stands now: for drawing and for files.
struct ParticleView {
  Vector3 position = Vector3::Zero();  ///< m, world
  double radius = 0.0;                 ///< m
  OwnerKind ownerKind = OwnerKind::Grain;
  std::int32_t ownerIndex = -1;  ///< GrainId::index or BodyId::index
};

/// One contact as it stands now: for force chains and for files.
struct ContactView {
  OwnerKind ownerKind[2] = {OwnerKind::Grain, OwnerKind::Grain};
  std::int32_t ownerIndex[2] = {-1, -1};
  std::int32_t particle[2] = {-1, -1};  ///< local index within the owner; -1: its exact surface
  Vector3 point = Vector3::Zero();      ///< m, world
  Vector3 force = Vector3::Zero();      ///< N, on the first owner, world
  double overlap = 0.0;                 ///< m
};

/// What a contact under eqs. 17 and 19 remembers: for files, to go on from.
struct RememberedContact {
  OwnerKind kind[2] = {OwnerKind::Grain, OwnerKind::Grain};
  std::int32_t index[2] = {-1, -1};        ///< GrainId::index or BodyId::index
  std::int32_t local[2] = {-1, -1};        ///< particle within the owner; -1: its exact surface
  Vector3 displacement = Vector3::Zero();  ///< D of eq. 19, of the first owner against the second, m, world
  double stiffness = 0.0;                  ///< of its spring, N/m
  bool slides = false;
};

/// A contact between two owners of which none is awake: kept as it was, and not evaluated.
struct FrozenContact {
  RememberedContact memory;         ///< who touches whom; what it remembers only where `remembers`
  bool remembers = false;           ///< under laws 17 and 19
  Vector3 force = Vector3::Zero();  ///< N, on the first owner, world
  Vector3 point = Vector3::Zero();  ///< m, world
  double overlap = 0.0;             ///< m
  double relativeOverlap = 0.0;     ///< in smaller radii of the pair
  double normalEnergy = 0.0;        ///< in its normal spring, J
};

/// Who sleeps, what presses on them, and who is about to fall asleep: for files, to go on from.
struct SleepState {
  struct Sleeper {
    OwnerKind kind = OwnerKind::Grain;
    std::int32_t index = -1;  ///< GrainId::index or BodyId::index
    Wrench held;              ///< mean net force and torque, N and N m: as SleepDef::wakeImbalance
    double carried = 0.0;     ///< mean of the sum of the sizes of its contact forces, N; 0: not known
  };
  /// One that is awake, and has rested since it was here.
  struct Rester {
    OwnerKind kind = OwnerKind::Grain;
    std::int32_t index = -1;
    double seconds = 0.0;
    Pose pose;  ///< of the principal frame
  };
  std::vector<Sleeper> sleepers;
  std::vector<Rester> resters;
  std::vector<FrozenContact> frozen;
  double untilLook = 0.0;    ///< s until it is looked at next who may fall asleep
  double untilWaking = 0.0;  ///< s until those wake who can wait for others
};

class GranularSystem {
 public:
  explicit GranularSystem(const SystemDef& def = {});
  ~GranularSystem();
  GranularSystem(GranularSystem&&) noexcept;
  GranularSystem& operator=(GranularSystem&&) noexcept;

  // ---- set-up
  MaterialId addMaterial(const MaterialDef& def);
  /// Overrides the pair rule for two materials (or one with itself). Holds from the next step on.
  void setMaterialPair(MaterialId a, MaterialId b, const MaterialPairDef& def);
  /// The pair rule as it was set, or the default one.
  MaterialPairDef materialPair(MaterialId a, MaterialId b) const;
  GrainShapeId addGrainShape(const GrainShapeDef& def);

  GrainId addGrain(const GrainDef& def);
  void removeGrain(GrainId id);
  BodyId addBody(const BodyDef& def);
  void removeBody(BodyId id);
  /// Two bodies whose particles shall not meet (jointed bodies, pairs that the host's own solver handles).
  void setBodyPairContact(BodyId a, BodyId b, bool enabled);

  void setGravity(const Vector3& gravity);
  const Vector3& gravity() const;
  /// Holds for the steps to come.
  void setIntegrator(const IntegratorDef& def);
  const IntegratorDef& integrator() const;
  /// Holds for the steps to come; switching sleep off wakes everything.
  void setSleep(const SleepDef& def);
  const SleepDef& sleep() const;
  int threads() const;

  // ---- stepping
  /// Advances everything by dt seconds in as many sub-steps as accuracy needs, or by as much of it as the
  /// budget is enough for. Never throws: see StepReport::flags.
  StepReport step(double dt, const WorkBudget& budget = {});
  double time() const;  ///< s simulated so far

  // ---- bodies: the host's side
  /// Moves a body: a teleport for dynamic ones, pose at the start of the next step for kinematic ones.
  void setBodyMotion(BodyId id, const RigidMotion& motion);
  RigidMotion bodyMotion(BodyId id) const;
  /// External force and torque on a dynamic body, held constant until changed. Gravity comes on top. Factors
  /// do not apply: as in Bullet's totals, the host has multiplied them in already.
  void setBodyLoad(BodyId id, const Wrench& load);
  /// Acceleration of gravity for this body alone, m/s^2 (Bullet allows one per body); default: the system's.
  void setBodyGravity(BodyId id, const Vector3& gravity);
  void setBodyMass(BodyId id, double mass, const Vector3& principalInertia);
  void setBodyFactors(BodyId id, const Vector3& linearFactor, const Vector3& angularFactor);
  /// Impulse and angular impulse (about the body's centre at each moment) that contacts gave this dynamic or
  /// kinematic body during the last step, N s and N m s.
  Wrench contactImpulse(BodyId id) const;
  /// Contact force and torque on any body, static ones too, in the present state.
  Wrench contactWrench(BodyId id);
  BodyMotion bodyMotionType(BodyId id) const;
  /// Ids of all living bodies, by index.
  std::vector<BodyId> bodies() const;
  /// The def that would add this body as it is now.
  BodyDef bodyDef(BodyId id) const;
  Wrench bodyLoad(BodyId id) const;
  /// m/s^2: its own, or the system's.
  Vector3 bodyGravity(BodyId id) const;
  /// Whether setBodyPairContact leaves the two to each other.
  bool bodyPairContact(BodyId a, BodyId b) const;

  // ---- sleep. Moving, loading or removing something, and changing gravity or materials, wakes what feels
  // it.
  bool isAwake(GrainId id) const;
  bool isAwake(BodyId id) const;  ///< static and kinematic bodies never are: they feel nothing
  void wake(GrainId id);
  void wake(BodyId id);
  void wakeAll();
  /// Grains and bodies whose centres are in the box.
  void wakeRegion(const Box& box);
  SleepState sleepState() const;
  /// Puts such a state back into a system with the same owners at the same places, after setContactMemory().
  /// Everything is awake where SleepDef::enabled is not; frozen contacts of owners that are gone are dropped.
  /// Throws std::invalid_argument if a number is not finite.
  void setSleepState(const SleepState& state);

  // ---- grains: reading (spans stay valid until the next call that adds or steps)
  std::int32_t grainCount() const;     ///< living grains
  std::int32_t bodyCount() const;      ///< living bodies
  std::int64_t particleCount() const;  ///< particles on living grains and bodies
  std::span<const RigidMotion> grainMotions()
      const;  ///< by GrainId::index; read isAlive() where grains are removed
  bool isAlive(GrainId id) const;
  GrainId grainAt(std::int32_t index) const;  ///< id of the grain in that place; index -1 if none lives there
  void setGrainMotion(GrainId id, const RigidMotion& motion);
  const GrainShape& grainShape(GrainShapeId id) const;
  GrainShapeId shapeOf(GrainId id) const;
  MaterialId materialOf(GrainId id) const;
  double scaleOf(GrainId id) const;
  double massOf(GrainId id) const;  ///< kg
  const ContactFilter& filterOf(GrainId id) const;
  const MaterialDef& material(MaterialId id) const;
  const Covering& covering(BodyId id) const;

  /// Every particle of every living owner; grains first, then bodies, by index. Order is stable.
  void readParticles(std::vector<ParticleView>& particles) const;
  /// Every contact of the present state, ordered by owner and particle.
  void readContacts(std::vector<ContactView>& contacts);
  /// What contacts remember; empty where no pair of materials has a law with memory.
  std::vector<RememberedContact> contactMemory() const;
  /// Puts such memory back, into a system with the same owners; what belongs to no owner is dropped.
  void setContactMemory(const std::vector<RememberedContact>& memory);
  /// Energies, momentum, contacts of the present state, without stepping.
  StepReport measure();

  /// What is legal but unwise among the kinds of particles that are in the system now, for impacts at up to
  /// `speed`, m/s, >= 0. One line each, with the names of the materials and the number to change: overlaps
  /// beyond 5 % of the smaller radius; given viscosities, stiffnesses and dampings that ask for shorter
  /// sub-steps than the contact time does; creep under law 18 faster than 1 mm/s; restitution below 0.05.
  /// Such values are never refused: they cost time or looks, and steps stay finite and report what they give
  /// up (StepFlag). Throws std::invalid_argument if the speed is negative or not finite.
  std::vector<std::string> advice(double speed);

  /// Creep speed m g / kt that law 18 implies for one particle of this material resting on one contact of its
  /// own kind (Bell 2005, eq. 18), m/s, for a grain of the given mass, kg, and particle radius, m.
  double creepSpeed(MaterialId a, MaterialId b, double mass, double particleRadius) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace granular
