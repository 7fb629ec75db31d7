// SPDX-License-Identifier: MIT
// From what the host added to a layout and a state vector, and back.
#include <algorithm>
#include <cmath>

#include "granular/base/require.h"
#include "granular/base/room.h"
#include "granular/system/detail/system_impl.h"

namespace granular {

namespace state = detail::state;
using detail::BodyRecord;
using detail::GrainRecord;

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

void GranularSystem::Impl::setStepper() {
  stepper = makeStepMethod(integrator.stepper);
  control = StepControl(stepper->errorOrder());
  startIsCurrent = false;
}

void GranularSystem::Impl::prepare() {
  if (!layoutIsOld) return;
  std::vector<RememberedContact> memory = memoryOfAwake();
  if (givenMemory) memory = amongAwake(std::move(*givenMemory));
  givenMemory.reset();
  makeLayout();
  loadSurroundings();
  loadSleepers();
  evaluation.reset(materialPairs(), materials);
  const double contactTime = evaluation.referenceContactTime();
  contactTimeAtReference = layoutHasAll ? contactTime : std::min(contactTimeAtReference, contactTime);
  loadState();
  evaluation.importMemory(memory, y);
  sleepers.update(frozen);
  noteFrozenOnKinematic();
  layoutIsOld = everythingIsOld = false;
  startIsCurrent = false;
}

void GranularSystem::Impl::surroundingsChanged() {
  if (layoutIsOld) return;
  loadSurroundings();
  startIsCurrent = false;
}

/// Something was added or removed, or weighs something else.
void GranularSystem::Impl::everythingChanged() {
  layoutIsOld = everythingIsOld = true;
}

/// Takes out who has fallen asleep or is gone, and puts in order who has come.
void GranularSystem::Impl::updateAwakeGrains() {
  std::erase_if(awakeGrains, [&](std::int32_t g) { return !isAwake(OwnerKind::Grain, g); });
  std::sort(awakeGrains.begin(), awakeGrains.end());
  awakeGrains.erase(std::unique(awakeGrains.begin(), awakeGrains.end()), awakeGrains.end());
}

/// Puts these grains into the layout. Returns how many they are.
std::int32_t GranularSystem::Impl::addGrains(const std::vector<std::int32_t>& indices) {
  detail::Layout& layout = evaluation.layout();
  for (const std::int32_t g : indices) {
    const GrainRecord& record = grains[g];
    const GrainShape& shape = shapes[record.shape.index];
    ownerOfGrain[g] = static_cast<std::int32_t>(layout.owners.size());
    detail::Owner& owner = layout.owners.emplace_back();
    owner.kind = OwnerKind::Grain;
    owner.index = g;
    owner.particles = shape.particles;
    owner.scale = record.scale;
    owner.inverseMass = 1.0 / record.mass;
    owner.inverseInertia = inertiaOf(record).cwiseInverse();
    owner.isotropic = shape.isotropic;
    owner.isSphere = shape.particles.size() == 1 && shape.particles.front().position.isZero();
    owner.reach = record.scale * shape.boundingRadius;
    owner.material = record.material.index;
  }
  return static_cast<std::int32_t>(indices.size());
}

/// Puts bodies that move in this way into it, those that are awake or those that are not.
std::int32_t GranularSystem::Impl::addBodies(BodyMotion type, bool asleep) {
  detail::Layout& layout = evaluation.layout();
  const std::size_t before = layout.owners.size();
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(bodies.size()); ++b) {
    const BodyRecord& record = bodies[b];
    if (!record.alive || record.motionType != type || record.asleep != asleep) continue;
    ownerOfBody[b] = static_cast<std::int32_t>(layout.owners.size());
    detail::Owner& owner = layout.owners.emplace_back();
    owner.kind = OwnerKind::Body;
    owner.index = b;
    owner.particles = record.particles;
    detail::BodyTraits& traits = layout.bodyTraits.emplace_back();
    owner.body = &traits;
    traits.pieces = record.covering.pieces;
    traits.firstPiece = record.firstPiece;
    if (record.exact) traits.exact = &*record.exact;
    traits.exactPose = record.exactPose;
    traits.exactUse = record.exactUse;
    detail::Layout::measureBody(owner, traits);
    owner.reach = record.reach;
    owner.material = record.material.index;
    if (type != BodyMotion::Dynamic) continue;
    owner.inverseMass = 1.0 / record.mass;
    owner.inverseInertia = record.inertia.cwiseInverse();
    owner.isotropic = record.inertia.minCoeff() == record.inertia.maxCoeff();
    traits.linearFactor = record.linearFactor;
    traits.angularFactor = record.angularFactor;
    traits.freeAxes = (record.angularFactor.array() != 0.0).cast<double>();
    owner.isLocked = traits.freeAxes != Vector3::Ones();
  }
  return static_cast<std::int32_t>(layout.owners.size() - before);
}

void GranularSystem::Impl::makeLayout() {
  detail::Layout& layout = evaluation.layout();
  for (const detail::Owner& owner : layout.owners) {
    if (owner.kind == OwnerKind::Grain) ownerOfGrain[owner.index] = -1;
  }
  makeRoom(ownerOfGrain, grains.size());
  ownerOfGrain.resize(grains.size(), -1);
  layout = {};
  ownerOfBody.assign(bodies.size(), -1);
  updateAwakeGrains();
  layout.owners.reserve(awakeGrains.size() + aliveBodies);
  layout.dynamicGrains = addGrains(awakeGrains);
  layout.dynamicBodies = addBodies(BodyMotion::Dynamic, false);
  layout.kinematicBodies = addBodies(BodyMotion::Kinematic, false);
  addBodies(BodyMotion::Static, false);
  layout.firstSleeper = static_cast<std::int32_t>(layout.owners.size());
  const std::vector<std::int32_t> near = findNearSleepers();
  layout.owners.reserve(awakeGrains.size() + near.size() + aliveBodies);
  layout.sleepingGrains = addGrains(near);
  addBodies(BodyMotion::Dynamic, true);
  noteFilters();
  layout.finish();
  measureScales();
  layout.sortPlaces([&](std::int32_t o) { return motionOf(layout.owners[o]).pose.position; });
}

/// Which owners meet; by their own filters only where one of these is not the usual one.
void GranularSystem::Impl::noteFilters() {
  const detail::Layout& layout = evaluation.layout();
  MeetingRules& rules = evaluation.layout().rules;
  const auto filterOf = [&](const detail::Owner& owner) -> const ContactFilter& {
    return owner.kind == OwnerKind::Grain ? grains[owner.index].filter : bodies[owner.index].filter;
  };
  const auto isUsual = [&](const detail::Owner& owner) {
    return filterOf(owner).group == ContactFilter{}.group && filterOf(owner).mask == ContactFilter{}.mask;
  };
  if (!std::all_of(layout.owners.begin(), layout.owners.end(), isUsual)) {
    for (const detail::Owner& owner : layout.owners) {
      rules.group.push_back(filterOf(owner).group);
      rules.mask.push_back(filterOf(owner).mask);
    }
  }
  for (const std::uint64_t pair : excludedPairs) {
    const std::int32_t a = ownerOfBody[pair >> 32], b = ownerOfBody[pair & 0xffffffffu];
    if (a >= 0 && b >= 0) rules.excludedPairs.push_back(MeetingRules::pairKey(a, b));
  }
  std::sort(rules.excludedPairs.begin(), rules.excludedPairs.end());
}

/// Scales are those of all that is there, whoever is in the layout.
void GranularSystem::Impl::measureScales() {
  detail::Layout& layout = evaluation.layout();
  if (layoutHasAll) {
    smallestRadius = layout.smallestRadius;
    largestRadius = layout.largestRadius;
  } else if (layout.particleCount > 0) {
    smallestRadius = std::min(smallestRadius, layout.smallestRadius);
    largestRadius = std::max(largestRadius, layout.largestRadius);
  }
  layout.smallestRadius = smallestRadius;
  layout.largestRadius = largestRadius;
}

/// Of materials a and b at a * count + b. Finding a damping by impacts takes milliseconds, and a layout is
/// made whenever somebody wakes.
const std::vector<MaterialPair>& GranularSystem::Impl::materialPairs() {
  if (!combined.empty()) return combined;
  const auto count = static_cast<std::int32_t>(materials.size());
  combined.resize(materials.size() * materials.size());
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a; b < count; ++b) {
      const auto found = pairDefs.find({a, b});
      const MaterialPairDef def = found == pairDefs.end() ? MaterialPairDef{} : found->second;
      combined[a * count + b] = combined[b * count + a] = combineMaterials(materials[a], materials[b], def);
    }
  }
  return combined;
}

void GranularSystem::Impl::loadSurroundings() {
  detail::Surroundings& s = evaluation.surroundings();
  const detail::Layout& layout = evaluation.layout();
  s.gravity = gravity;
  s.bodyGravity.clear();
  s.bodyLoad.clear();
  s.kinematic.clear();
  s.fixed.clear();
  for (std::int32_t o = layout.dynamicGrains; o < layout.firstSleeper; ++o) {
    const BodyRecord& record = bodies[layout.owners[o].index];
    if (record.motionType == BodyMotion::Dynamic) {
      s.bodyGravity.push_back(record.gravity.value_or(gravity));
      s.bodyLoad.push_back(record.load);
    } else {
      (record.motionType == BodyMotion::Kinematic ? s.kinematic : s.fixed).push_back(record.motion);
    }
  }
}

/// Principal moments of inertia, kg m^2.
Vector3 GranularSystem::Impl::inertiaOf(const GrainRecord& record) const {
  return materials[record.material.index].density * std::pow(record.scale, 5) *
         shapes[record.shape.index].unitInertia;
}

const RigidMotion& GranularSystem::Impl::motionOf(const detail::Owner& owner) const {
  return owner.kind == OwnerKind::Grain ? grainMotions[owner.index] : bodies[owner.index].motion;
}

void GranularSystem::Impl::writeOwner(std::int32_t o, const RigidMotion& motion) {
  const auto own = evaluation.layout().numbersOf(o, y.data());
  const detail::Owner& owner = evaluation.layout().owners[o];
  const bool isGrain = owner.kind == OwnerKind::Grain;
  const Vector3 inertia = isGrain ? inertiaOf(grains[owner.index]) : bodies[owner.index].inertia;
  const Quaternion& q = motion.pose.orientation;
  own.position() = motion.pose.position;
  own.setOrientation(q);
  own.velocity() = motion.velocity;
  own.angularMomentum() = q * inertia.cwiseProduct(q.conjugate() * motion.angularVelocity);
}

RigidMotion GranularSystem::Impl::readOwner(std::int32_t o) const {
  const auto own = evaluation.layout().numbersOf(o, y.data());
  const detail::Owner& owner = evaluation.layout().owners[o];
  RigidMotion motion;
  motion.pose = {own.position(), own.orientation()};
  motion.velocity = own.velocity();
  motion.angularVelocity = detail::angularVelocityOf(owner, motion.pose.orientation, own.angularMomentum());
  return motion;
}

/// Puts the state into the order in which owners lie in space, so that neighbours are neighbours in memory.
/// Nothing that is computed depends on it. What contacts did at the last evaluation is lost.
void GranularSystem::Impl::sortState() {
  const std::vector<std::int32_t> from = evaluation.sortPlaces(y);
  const detail::Layout& layout = evaluation.layout();
  std::vector<double>& before = stepper->result();  // of a trial that is over
  const auto reorder = [&](double* rows, std::size_t size) {
    before.assign(rows, rows + from.size() * size);
    for (std::size_t place = 0; place < from.size(); ++place) {
      std::copy_n(before.data() + from[place] * size, size, rows + place * size);
    }
  };
  reorder(y.data(), state::kPoseSize);
  reorder(y.data() + layout.firstMomentum(), state::kMomentaSize);
  const std::size_t poses = stepper->needsPoseRates() ? layout.firstMomentum() : 0;
  for (std::vector<double>* rates : stepper->kept()) {
    if (rates->size() < poses + from.size() * state::kMomentaSize) continue;  // of another layout: not read
    if (poses > 0) reorder(rates->data(), state::kPoseSize);
    reorder(rates->data() + poses, state::kMomentaSize);
  }
}

void GranularSystem::Impl::loadState() {
  const detail::Layout& layout = evaluation.layout();
  y.assign(evaluation.stateSize(), 0.0);
  for (std::int32_t o = 0; o < layout.dynamicCount(); ++o) writeOwner(o, motionOf(layout.owners[o]));
}

}  // namespace granular
