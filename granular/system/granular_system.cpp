// SPDX-License-Identifier: MIT
// The public face of GranularSystem: checks what it is given, hands out what there is.
#include "granular/system/granular_system.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "granular/base/require.h"
#include "granular/base/room.h"
#include "granular/system/detail/system_impl.h"

namespace granular {
namespace {

using detail::BodyRecord;
using detail::GrainRecord;

void checkMotion(const RigidMotion& m, const std::string& what) {
  requireFinite(m.pose.position, what + ".pose.position", "m");
  requireRotation(m.pose.orientation, what + ".pose.orientation");
  requireFinite(m.velocity, what + ".velocity", "m/s");
  requireFinite(m.angularVelocity, what + ".angularVelocity", "rad/s");
}

void checkIntegrator(const IntegratorDef& def) {
  requireNotNegative(def.fixedSubStep, "IntegratorDef.fixedSubStep", "s");
  requirePositive(def.tolerance, "IntegratorDef.tolerance", "radii");
  const bool isRungeKutta = def.stepper == Stepper::Rkf45 || def.stepper == Stepper::BogackiShampine;
  require(def.contactTimeFraction > 0.0 && def.contactTimeFraction <= (isRungeKutta ? 0.3 : 0.9),
          "IntegratorDef.contactTimeFraction", def.contactTimeFraction, "",
          isRungeKutta ? "in (0, 0.3]" : "in (0, 0.9] for this stepper");
  require(def.eventFraction > 0.0 && def.eventFraction <= 1.0, "IntegratorDef.eventFraction",
          def.eventFraction, "", "in (0, 1]");
  require(def.eventContacts >= 0, "IntegratorDef.eventContacts", def.eventContacts, "contacts", ">= 0");
  requirePositive(def.smallestSubStep, "IntegratorDef.smallestSubStep", "s");
  require(def.trialLimit > 0, "IntegratorDef.trialLimit", def.trialLimit, "trials", "> 0");
}

void checkSleep(const SleepDef& def) {
  requirePositive(def.restTime, "SleepDef.restTime", "s");
  requirePositive(def.restWay, "SleepDef.restWay", "radii");
  requirePositive(def.balance, "SleepDef.balance", "");
  require(std::isfinite(def.wakeImbalance) && def.wakeImbalance >= def.balance, "SleepDef.wakeImbalance",
          def.wakeImbalance, "", "finite and >= SleepDef.balance");
}

void checkPieces(const Covering& covering) {
  std::int32_t before = 0;
  for (const SurfacePiece& piece : covering.pieces) {
    require(piece.particle >= before && piece.particle < std::ssize(covering.positions),
            "BodyDef.covering.pieces.particle", piece.particle, "",
            "an index of a particle, not below that of the piece before");
    before = piece.particle;
    for (const Vector3& corner : piece.corners) requireFinite(corner, "BodyDef.covering.pieces.corners", "m");
    requirePositive(piece.areaVector().norm(), "BodyDef.covering.pieces area", "m^2");
  }
}

void checkBody(const BodyDef& def) {
  const std::size_t count = def.covering.positions.size();
  require(count > 0 || def.exact, "BodyDef.covering.positions", 0, "particles",
          "at least one, or BodyDef.exact given");
  require(def.covering.radii.size() == count, "BodyDef.covering.radii", def.covering.radii.size(), "entries",
          "as many as positions");
  for (const Vector3& p : def.covering.positions) requireFinite(p, "BodyDef.covering.positions", "m");
  for (const double r : def.covering.radii) requirePositive(r, "BodyDef.covering.radii", "m");
  checkPieces(def.covering);
  if (def.exact) {
    checkExactSurface(*def.exact, "BodyDef.exact");
    requireFinite(def.exactPose.position, "BodyDef.exactPose.position", "m");
    requireRotation(def.exactPose.orientation, "BodyDef.exactPose.orientation");
    require(count > 0 || def.exactUse == ExactUse::Everything, "BodyDef.exactUse", "Bodies", "",
            "Everything for a body without particles");
    require(!std::holds_alternative<HalfSpace>(*def.exact) || def.motion != BodyMotion::Dynamic,
            "BodyDef.motion", "Dynamic", "", "Static or Kinematic for a half-space");
  }
  checkMotion({def.pose, def.velocity, def.angularVelocity}, "BodyDef");
}

/// Where the pieces of each particle begin, and where the last one's end.
std::vector<std::int32_t> firstPieces(const Covering& covering) {
  std::vector<std::int32_t> first(covering.positions.size() + 1, 0);
  for (const SurfacePiece& piece : covering.pieces) ++first[piece.particle + 1];
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  return first;
}

void checkBodyMass(double mass, const Vector3& inertia) {
  requirePositive(mass, "BodyDef.mass", "kg");
  require(inertia.allFinite() && inertia.minCoeff() > 0.0, "BodyDef.principalInertia", inertia.transpose(),
          "kg m^2", "finite and > 0 for a dynamic body");
}

}  // namespace

GranularSystem::GranularSystem(const SystemDef& def) {
  requireFinite(def.gravity, "SystemDef.gravity", "m/s^2");
  require(def.threads > 0, "SystemDef.threads", def.threads, "threads", "> 0");
  checkIntegrator(def.integrator);
  checkSleep(def.sleep);
  impl_ = std::make_unique<Impl>(def);
}
GranularSystem::~GranularSystem() = default;
GranularSystem::GranularSystem(GranularSystem&&) noexcept = default;
GranularSystem& GranularSystem::operator=(GranularSystem&&) noexcept = default;

MaterialId GranularSystem::addMaterial(const MaterialDef& def) {
  checkMaterial(def);
  impl_->materials.push_back(def);
  impl_->combined.clear();
  impl_->layoutIsOld = true;
  return {static_cast<std::int32_t>(impl_->materials.size()) - 1};
}

void GranularSystem::setMaterialPair(MaterialId a, MaterialId b, const MaterialPairDef& def) {
  impl_->checkMaterialId(a, "MaterialId");
  impl_->checkMaterialId(b, "MaterialId");
  checkMaterialPair(def);
  impl_->pairDefs[std::minmax(a.index, b.index)] = def;
  impl_->combined.clear();
  impl_->wakeAll();
  impl_->everythingChanged();
}

MaterialPairDef GranularSystem::materialPair(MaterialId a, MaterialId b) const {
  impl_->checkMaterialId(a, "MaterialId");
  impl_->checkMaterialId(b, "MaterialId");
  const auto found = impl_->pairDefs.find(std::minmax(a.index, b.index));
  return found == impl_->pairDefs.end() ? MaterialPairDef{} : found->second;
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
    makeRoom(s.grains, s.grains.size() + 1);
    makeRoom(s.grainMotions, s.grains.size() + 1);
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
            .filter = def.filter,
            .generation = record.generation,
            .alive = true,
            .maySleep = def.maySleep};
  const Quaternion orientation = def.pose.orientation.normalized();
  s.grainMotions[index] = {
      .pose = {def.pose.position + orientation * (def.scale * shape.principalFrame.position),
               (orientation * shape.principalFrame.orientation).normalized()},
      .velocity = def.velocity,
      .angularVelocity = def.angularVelocity};
  ++s.aliveGrains;
  makeRoom(s.awakeGrains, s.awakeGrains.size() + 1);
  s.awakeGrains.push_back(index);
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
  record.exactUse = def.exactUse;
  record.exactPose = {def.exactPose.position, def.exactPose.orientation.normalized()};
  for (std::size_t i = 0; i < def.covering.positions.size(); ++i) {
    const ShapeParticle particle{def.covering.positions[i], def.covering.radii[i]};
    record.particles.push_back(particle);
    record.reach = std::max(record.reach, particle.position.norm() + particle.radius);
  }
  record.firstPiece = firstPieces(def.covering);
  if (def.exact && !std::holds_alternative<HalfSpace>(*def.exact)) {
    record.reach = std::max(record.reach, def.exactPose.position.norm() + boundingRadius(*def.exact));
  }
  record.material = def.material;
  record.mass = def.mass;
  record.inertia = def.principalInertia;
  record.linearFactor = def.linearFactor;
  record.angularFactor = def.angularFactor;
  record.filter = def.filter;
  record.maySleep = def.maySleep;
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
  if (def.motion != BodyMotion::Dynamic) s.notePlaced(index);
  return {index, s.bodies[index].generation};
}

void GranularSystem::removeBody(BodyId id) {
  Impl& s = *impl_;
  BodyRecord& record = s.body(id);
  s.wakeTouching(id.index);
  s.removeSleeper({OwnerKind::Body, id.index});
  record.alive = record.asleep = false;
  ++record.generation;
  s.freeBodies.push_back(id.index);
  std::erase_if(s.excludedPairs, [&](std::uint64_t pair) {
    return static_cast<std::int32_t>(pair >> 32) == id.index ||
           static_cast<std::int32_t>(pair & 0xffffffffu) == id.index;
  });
  --s.aliveBodies;
  s.everythingChanged();
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
  for (const BodyId id : {a, b}) {
    s.wake(OwnerKind::Body, id.index);
    if (s.bodies[id.index].motionType != BodyMotion::Dynamic) s.notePlaced(id.index);
  }
  s.layoutIsOld = true;
}

void GranularSystem::setGravity(const Vector3& gravity) {
  requireFinite(gravity, "gravity", "m/s^2");
  if (gravity == impl_->gravity) return;
  impl_->gravity = gravity;
  impl_->wakeAll();
  impl_->surroundingsChanged();
}
const Vector3& GranularSystem::gravity() const {
  return impl_->gravity;
}

void GranularSystem::setIntegrator(const IntegratorDef& def) {
  checkIntegrator(def);
  const bool changesStepper = def.stepper != impl_->integrator.stepper;
  if (def.precision != impl_->integrator.precision) impl_->startIsCurrent = false;
  impl_->integrator = def;
  impl_->evaluation.usePrecision(def.precision);
  impl_->equations.turnSpheres(def.turnSpheres);
  if (changesStepper) impl_->setStepper();
}
const IntegratorDef& GranularSystem::integrator() const {
  return impl_->integrator;
}
void GranularSystem::setSleep(const SleepDef& def) {
  checkSleep(def);
  impl_->sleep = def;
  if (!def.enabled) impl_->wakeAll();
}
const SleepDef& GranularSystem::sleep() const {
  return impl_->sleep;
}
int GranularSystem::threads() const {
  return impl_->evaluation.executor().threads();
}

StepReport GranularSystem::step(double dt, const WorkBudget& budget) {
  return impl_->step(dt, budget);
}
double GranularSystem::time() const {
  return impl_->time;
}

void GranularSystem::setBodyMotion(BodyId id, const RigidMotion& motion) {
  Impl& s = *impl_;
  BodyRecord& record = s.body(id);
  checkMotion(motion, "RigidMotion");
  RigidMotion next = motion;
  next.pose.orientation.normalize();
  const bool isSame = next.pose.position == record.motion.pose.position &&
                      next.pose.orientation.coeffs() == record.motion.pose.orientation.coeffs() &&
                      next.velocity == record.motion.velocity &&
                      next.angularVelocity == record.motion.angularVelocity;
  if (isSame) return;
  if (record.motionType != BodyMotion::Dynamic) {
    s.wakeTouching(id.index);
    s.notePlaced(id.index);
  }
  s.wake(OwnerKind::Body, id.index);
  record.motion = next;
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
  impl_->wake(OwnerKind::Body, id.index);
  impl_->surroundingsChanged();
}

void GranularSystem::setBodyGravity(BodyId id, const Vector3& gravity) {
  BodyRecord& record = impl_->body(id);
  requireFinite(gravity, "gravity", "m/s^2");
  if (record.gravity == gravity) return;
  record.gravity = gravity;
  impl_->wake(OwnerKind::Body, id.index);
  impl_->surroundingsChanged();
}

void GranularSystem::setBodyMass(BodyId id, double mass, const Vector3& principalInertia) {
  BodyRecord& record = impl_->body(id);
  checkBodyMass(mass, principalInertia);
  if (mass == record.mass && principalInertia == record.inertia) return;
  record.mass = mass;
  record.inertia = principalInertia;
  impl_->wake(OwnerKind::Body, id.index);
  impl_->everythingChanged();
}

void GranularSystem::setBodyFactors(BodyId id, const Vector3& linearFactor, const Vector3& angularFactor) {
  BodyRecord& record = impl_->body(id);
  requireFinite(linearFactor, "linearFactor", "");
  requireFinite(angularFactor, "angularFactor", "");
  if (linearFactor == record.linearFactor && angularFactor == record.angularFactor) return;
  record.linearFactor = linearFactor;
  record.angularFactor = angularFactor;
  impl_->wake(OwnerKind::Body, id.index);
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
  s.evaluation.listContacts(s.y);
  const detail::Layout& layout = s.evaluation.layout();
  const std::int32_t owner = s.ownerOfBody[id.index];
  const Vector3 center = s.bodies[id.index].motion.pose.position;
  Wrench sum = s.frozen.wrenchOn(id.index, center);
  s.evaluation.forEachContact([&](const detail::Contact& contact, const detail::ContactForce& f) {
    const bool first = layout.ownerOfSlot[contact.slot1] == owner;
    if (!first && layout.ownerOfSlot[contact.slot2] != owner) return;
    const Vector3 force = first ? f.force : Vector3(-f.force);
    sum.force += force;
    sum.torque += (s.evaluation.pointOf(contact, f) - center).cross(force);
  });
  return sum;
}

BodyMotion GranularSystem::bodyMotionType(BodyId id) const {
  return impl_->body(id).motionType;
}

std::vector<BodyId> GranularSystem::bodies() const {
  std::vector<BodyId> ids;
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(impl_->bodies.size()); ++b) {
    if (impl_->bodies[b].alive) ids.push_back({b, impl_->bodies[b].generation});
  }
  return ids;
}

BodyDef GranularSystem::bodyDef(BodyId id) const {
  const BodyRecord& record = impl_->body(id);
  return {.motion = record.motionType,
          .covering = record.covering,
          .exact = record.exact,
          .exactPose = record.exactPose,
          .exactUse = record.exactUse,
          .material = record.material,
          .mass = record.mass,
          .principalInertia = record.inertia,
          .pose = record.motion.pose,
          .velocity = record.motion.velocity,
          .angularVelocity = record.motion.angularVelocity,
          .linearFactor = record.linearFactor,
          .angularFactor = record.angularFactor,
          .filter = record.filter,
          .maySleep = record.maySleep};
}

Wrench GranularSystem::bodyLoad(BodyId id) const {
  return impl_->body(id).load;
}
Vector3 GranularSystem::bodyGravity(BodyId id) const {
  return impl_->body(id).gravity.value_or(impl_->gravity);
}
bool GranularSystem::bodyPairContact(BodyId a, BodyId b) const {
  impl_->body(a);
  impl_->body(b);
  const std::vector<std::uint64_t>& excluded = impl_->excludedPairs;
  return std::find(excluded.begin(), excluded.end(), MeetingRules::pairKey(a.index, b.index)) ==
         excluded.end();
}

bool GranularSystem::isAwake(GrainId id) const {
  impl_->grain(id);
  return impl_->isAwake(OwnerKind::Grain, id.index);
}
bool GranularSystem::isAwake(BodyId id) const {
  impl_->body(id);
  return impl_->isAwake(OwnerKind::Body, id.index);
}
void GranularSystem::wake(GrainId id) {
  impl_->grain(id);
  impl_->wake(OwnerKind::Grain, id.index);
}
void GranularSystem::wake(BodyId id) {
  impl_->body(id);
  impl_->wake(OwnerKind::Body, id.index);
}
void GranularSystem::wakeAll() {
  impl_->wakeAll();
}
void GranularSystem::wakeRegion(const Box& box) {
  const auto isInside = [&](const RigidMotion& motion) {
    const Vector3& p = motion.pose.position;
    return (p.array() >= box.lower.array()).all() && (p.array() <= box.upper.array()).all();
  };
  for (std::int32_t g = 0; g < static_cast<std::int32_t>(impl_->grains.size()); ++g) {
    if (isInside(impl_->grainMotions[g])) impl_->wake(OwnerKind::Grain, g);
  }
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(impl_->bodies.size()); ++b) {
    if (isInside(impl_->bodies[b].motion)) impl_->wake(OwnerKind::Body, b);
  }
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
  s.wake(OwnerKind::Grain, id.index);
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
const ContactFilter& GranularSystem::filterOf(GrainId id) const {
  return impl_->grain(id).filter;
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
  impl_->evaluation.listContacts(impl_->y);
  const detail::Layout& layout = impl_->evaluation.layout();
  impl_->evaluation.forEachContact([&](const detail::Contact& contact, const detail::ContactForce& f) {
    ContactView view;
    const std::int32_t slots[2] = {contact.slot1, contact.slot2};
    for (int side = 0; side < 2; ++side) {
      const detail::Owner& owner = layout.owners[layout.ownerOfSlot[slots[side]]];
      view.ownerKind[side] = owner.kind;
      view.ownerIndex[side] = owner.index;
      view.particle[side] =
          slots[side] < layout.particleCount ? layout.rankOfSlot[slots[side]] - owner.firstRank : -1;
    }
    view.point = impl_->evaluation.pointOf(contact, f);
    view.force = f.force;
    view.overlap = f.overlap;
    contacts.push_back(view);
  });
  if (!impl_->frozen.empty()) impl_->addFrozen(contacts);
}

std::vector<RememberedContact> GranularSystem::contactMemory() const {
  const Impl& s = *impl_;
  if (s.givenMemory) return *s.givenMemory;
  std::vector<RememberedContact> memory = s.evaluation.exportMemory(s.y);
  memory.insert(memory.end(), s.thawed.begin(), s.thawed.end());
  if (s.frozen.empty()) return memory;
  memory = s.amongAwake(std::move(memory));  // others were frozen since the last evaluation
  for (const FrozenContact& contact : s.frozen.all()) {
    if (contact.remembers) memory.push_back(contact.memory);
  }
  return memory;
}

void GranularSystem::setContactMemory(const std::vector<RememberedContact>& memory) {
  for (const RememberedContact& contact : memory) {
    requireFinite(contact.displacement, "RememberedContact.displacement", "m");
    requireNotNegative(contact.stiffness, "RememberedContact.stiffness", "N/m");
  }
  impl_->wakeAll();
  impl_->givenMemory = memory;
  impl_->layoutIsOld = true;
}

StepReport GranularSystem::measure() {
  StepReport report;
  impl_->measure(report);
  return report;
}

double GranularSystem::creepSpeed(MaterialId a, MaterialId b, double mass, double particleRadius) const {
  const Impl& s = *impl_;
  const MaterialPair pair = combineMaterials(s.materials[a.index], s.materials[b.index], materialPair(a, b));
  const auto side = [&](MaterialId m) {
    const MaterialDef& material = s.materials[m.index];
    return PairSide{
        .contact = {1.0 / mass, 1.0 / particleRadius, material.youngsModulus, material.poissonRatio}};
  };
  return mass * s.gravity.norm() / makePairLaw(pair, side(a), side(b)).shear.viscosity;
}

}  // namespace granular
