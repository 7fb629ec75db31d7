// SPDX-License-Identifier: MIT
#include "demos/world/built_scene.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "bullet_bridge/convert.h"
#include "bullet_bridge/pose_algebra.h"
#include "demos/scene/json_object.h"
#include "demos/world/body_copies.h"
#include "demos/world/motion_script.h"
#include "granular/base/random.h"
#include "granular/geometry/mesh_distance.h"

namespace granular_demo {
namespace {

using bullet_bridge::fromBullet;
using bullet_bridge::toBullet;

/// Runs a step of building and puts file and key path in front of what goes wrong.
template <class Work>
void named(const SceneDef& scene, const std::string& path, const Work& work) {
  try {
    work();
  } catch (const std::exception& error) {
    throw SceneError(scene.file.string(), path, error.what());
  }
}

/// A seed for one part of a scene: depends on the scene's seed, the part's own seed and its place.
std::uint64_t partSeed(const SceneDef& scene, std::uint64_t ownSeed, std::size_t place) {
  return granular::Random(scene.seed).forItem(ownSeed).forItem(place).bits();
}

class StateHash {  // FNV-1a
 public:
  void add(double x) {
    std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
    for (int i = 0; i < 8; ++i, bits >>= 8) value = (value ^ (bits & 0xff)) * 0x100000001b3ull;
  }
  template <class Vector>
  void addAll(const Vector& v) {
    for (int i = 0; i < v.size(); ++i) add(v[i]);
  }
  void add(const granular::RigidMotion& motion) {
    addAll(motion.pose.position);
    addAll(motion.pose.orientation.coeffs());
    addAll(motion.velocity);
    addAll(motion.angularVelocity);
  }

  std::uint64_t value = 0xcbf29ce484222325ull;
};

double massOf(const BodyPart& part, const BodySolid& solid) {
  if (part.motion != BodyKind::dynamic) return 0.0;
  return part.mass ? *part.mass : *part.density * solid.volume;
}

/// Principal moments in the body's frame, kg m^2; 0 for what does not move freely.
Vector3 inertiaOf(const BodyPart& part, const BodySolid& solid, double mass) {
  if (part.inertia) return *part.inertia;
  return solid.volume > 0.0 ? Vector3(mass / solid.volume * solid.unitInertia) : Vector3::Zero();
}

}  // namespace

Pose BuiltBody::pose() const {
  return fromBullet(body->getWorldTransform());
}

Pose BuiltBody::drawnPose() const {
  return bullet_bridge::composed(pose(), bullet_bridge::inverse(solid->frame));
}

BuiltScene::BuiltScene(SceneDef def, int threads, const SavedState* state) : def_(std::move(def)) {
  if (state) def_.seed = state->seed;
  if (state && state->scene == def_.name) ticksDone_ = state->ticks;
  def_.bodies = withCopies(def_);
  bullet_bridge::LayerDef layer;
  layer.integrator = def_.integrator;
  layer.sleep = def_.sleep;
  layer.threads = threads;
  world_ = std::make_unique<bullet_bridge::GranularDynamicsWorld>(&dispatcher_, &broadphase_, &solver_,
                                                                  &configuration_, layer);
  world_->setGravity(toBullet(def_.gravity));
  addMaterials();
  addShapes();
  const double smallest = smallestGrainRadius();
  bodies_.reserve(def_.bodies.size());
  for (const BodyPart& part : def_.bodies)
    named(def_, "bodies." + part.name, [&] { addBody(part, smallest, threads); });
  addJoints();
  listSources();
  if (state) {
    restore(*state);
  } else {
    checkStartOverlap();
    for (const GrainPart& part : def_.grains) named(def_, "grains." + part.name, [&] { addGrain(part); });
    for (std::size_t i = 0; i < def_.fills.size(); ++i) {
      named(def_, "fills." + def_.fills[i].name, [&] { addFill(def_.fills[i], i); });
    }
  }
  addEmitters(state);
  impactSpeed_ = impactSpeedOf(*this);
  advice_ = grains().advice(impactSpeed_.speed);
}

BuiltScene::~BuiltScene() {
  if (world_) joints_.removeFrom(*world_);
  for (BuiltBody& body : bodies_) {
    if (body.body) world_->removeRigidBody(body.body.get());
  }
}

void BuiltScene::addMaterials() {
  for (const granular::MaterialDef& material : def_.materials) {
    named(def_, "materials." + material.name,
          [&] { materials_[material.name] = grains().addMaterial(material); });
  }
  for (std::size_t i = 0; i < def_.pairs.size(); ++i) {
    const PairDef& pair = def_.pairs[i];
    named(def_, "pairs[" + std::to_string(i) + "]", [&] {
      grains().setMaterialPair(materials_.at(pair.materials[0]), materials_.at(pair.materials[1]), pair.law);
    });
  }
}

void BuiltScene::addShapes() {
  for (const granular::GrainShapeDef& shape : def_.shapes) {
    named(def_, "shapes." + shape.name, [&] { shapes_[shape.name] = grains().addGrainShape(shape); });
  }
}

double BuiltScene::smallestGrainRadius() const {
  double smallest = std::numeric_limits<double>::infinity();
  const auto use = [&](const std::string& name, double scale) {
    for (const granular::ShapeParticle& p : shapeNamed(name).particles)
      smallest = std::min(smallest, scale * p.radius);
  };
  for (const FillPart& fill : def_.fills) use(fill.shape, fill.fill.minScale);
  for (const GrainPart& grain : def_.grains) use(grain.shape, grain.scale);
  for (const EmitterPart& emitter : def_.emitters) use(emitter.shape, emitter.emitter.minScale);
  return std::isfinite(smallest) ? smallest : 0.0;
}

void BuiltScene::addBody(const BodyPart& part, double smallestGrainRadius, int threads) {
  const BuiltBody* twin = !part.group.empty() && !bodies_.empty() && bodies_.back().part->group == part.group
                              ? &bodies_.back()
                              : nullptr;
  BuiltBody built;
  built.part = &part;
  built.solid = twin ? twin->solid
                     : std::make_shared<const BodySolid>(makeBodySolid(
                           part.shape, part.motion, part.inertia ? BodyAxes::drawn : BodyAxes::principal));
  built.covering = twin ? twin->covering : std::make_shared<const BodyCovering>();
  built.mass = massOf(part, *built.solid);
  built.material = materials_.at(part.material);
  const Vector3 inertia = inertiaOf(part, *built.solid, built.mass);
  btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(built.mass), nullptr,
                                                &built.solid->shape(), toBullet(inertia));
  const Pose drawn =
      part.script.empty() ? part.pose : poseAt(def_.scripts.at(part.script), part.pose, time());
  info.m_startWorldTransform = toBullet(bullet_bridge::composed(drawn, built.solid->frame));
  const granular::MaterialDef& material = grains().material(built.material);
  info.m_friction = static_cast<btScalar>(material.friction);
  info.m_restitution = static_cast<btScalar>(material.restitution);
  built.body = std::make_unique<btRigidBody>(info);
  if (part.motion == BodyKind::kinematic) {
    built.body->setCollisionFlags(built.body->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  }
  // Energies are those of what moves: a body that Bullet put to sleep would take its own out of the balance.
  if (part.motion != BodyKind::fixed) built.body->setActivationState(DISABLE_DEACTIVATION);
  // The velocity of a file is that of the centre of mass, the body's own origin here.
  built.body->setLinearVelocity(toBullet(part.velocity));
  built.body->setAngularVelocity(toBullet(part.spin));
  world_->addRigidBody(built.body.get());
  bodies_.push_back(std::move(built));
  if (part.meetsGrains()) coverBody(bodies_.back(), smallestGrainRadius, threads);
}

void BuiltScene::coverBody(BuiltBody& body, double smallestGrainRadius, int threads) {
  const BodyPart& part = *body.part;
  bullet_bridge::CoverBodyDef cover;
  cover.material = body.material;
  if (part.contact == BodyContact::exact) {
    cover.contact = bullet_bridge::SurfaceContact::Exact;
    // Bullet's shape of a moving mesh is its hull.
    if (std::holds_alternative<MeshShape>(part.shape)) cover.surface = body.solid->parts.front();
    world_->coverBody(*body.body, cover);
    return;
  }
  if (body.covering->covering.positions.empty()) {  // of copies, the first one makes it
    CoveringPart covering = *part.covering;
    covering.seed = partSeed(def_, covering.seed, bodies_.size());
    body.covering = std::make_shared<const BodyCovering>(
        coverSolid(part.shape, *body.solid, covering, smallestGrainRadius, threads));
  }
  cover.covering = body.covering->covering;
  world_->coverBody(*body.body, cover);
}

void BuiltScene::addJoints() {
  const auto find = [&](const std::string& name) {
    const BuiltBody& found = body(name);
    return SceneJoints::End{found.body.get(), found.pose()};
  };
  for (const JointPart& part : def_.joints) {
    named(def_, "joints." + part.name,
          [&] { joints_.add(part, def_.bodies, find, *world_, tickDuration()); });
  }
}

void BuiltScene::listSources() {
  for (const FillPart& part : def_.fills)
    sources_.push_back({"fills." + part.name, part.shape, part.material, &part.look});
  for (const GrainPart& part : def_.grains)
    sources_.push_back({"grains." + part.name, part.shape, part.material, &part.look});
  for (const EmitterPart& part : def_.emitters)
    sources_.push_back({"emitters." + part.name, part.shape, part.material, &part.look});
}

std::int32_t BuiltScene::sourceNamed(const std::string& name) const {
  const auto found =
      std::find_if(sources_.begin(), sources_.end(), [&](const auto& source) { return source.name == name; });
  return found == sources_.end() ? -1 : static_cast<std::int32_t>(found - sources_.begin());
}

granular::GrainId BuiltScene::addGrainOf(std::int32_t source, granular::GrainDef def) {
  def.shape = shapes_.at(sources_[source].shape);
  def.material = materials_.at(sources_[source].material);
  const granular::GrainId id = grains().addGrain(def);
  sourceOfGrain_.resize(std::max(sourceOfGrain_.size(), static_cast<std::size_t>(id.index) + 1));
  sourceOfGrain_[id.index] = source;
  return id;
}

const granular::GrainShapeDef& BuiltScene::shapeNamed(const std::string& name) const {
  return *std::find_if(def_.shapes.begin(), def_.shapes.end(),
                       [&](const auto& shape) { return shape.name == name; });
}

/// Emitters that begin at once must have room for their first grain.
void BuiltScene::addEmitters(const SavedState* state) {
  for (std::size_t i = 0; i < def_.emitters.size(); ++i) {
    const EmitterPart& part = def_.emitters[i];
    named(def_, "emitters." + part.name, [&] {
      granular::EmitterDef emitter = part.emitter;
      emitter.seed = partSeed(def_, emitter.seed, def_.fills.size() + i);
      const granular::FillRegion region = clearOfExactBodies(part.region);
      if (part.from == 0.0 && !state) {
        granular::EmitterDef first = emitter;
        first.rate = 1.0;
        std::vector<granular::ParticleView> present;
        grains().readParticles(present);
        if (granular::Emitter(region, shapeNamed(part.shape), first).pour(1.0, present).empty())
          throw std::runtime_error("its region is full: no room for one grain (of " +
                                   std::to_string(part.emitter.rate) + " a second)");
      }
      emitters_.push_back({&part, granular::Emitter(region, shapeNamed(part.shape), emitter)});
      if (!state) return;
      for (const SavedState::Emitter& saved : state->emitters) {
        if (saved.name == part.name) emitters_.back().emitter.resume(saved.seconds, saved.poured);
      }
    });
  }
}

/// Bodies that reach far into one another would spring apart.
void BuiltScene::checkStartOverlap() {
  std::vector<granular::ContactView> contacts;
  grains().readContacts(contacts);
  for (const granular::ContactView& contact : contacts) {
    const BuiltBody* sides[2] = {nullptr, nullptr};
    double radius = std::numeric_limits<double>::infinity();
    for (const BuiltBody& body : bodies_) {
      if (!body.part->meetsGrains()) continue;
      const std::int32_t index = world_->bodyIdOf(*body.body).index;
      for (int side = 0; side < 2; ++side) {
        if (contact.ownerIndex[side] != index) continue;
        sides[side] = &body;
        if (contact.particle[side] >= 0)
          radius = std::min(radius, body.covering->covering.radii[contact.particle[side]]);
      }
    }
    if (!(contact.overlap > def_.largestStartOverlap * radius)) continue;
    char numbers[160];
    std::snprintf(numbers, sizeof numbers,
                  "%.3g m (%.2f particle radii) at the start; allowed: %.2f radii (\"largestStartOverlap\")",
                  contact.overlap, contact.overlap / radius, def_.largestStartOverlap);
    throw SceneError(def_.file.string(), "bodies." + sides[0]->part->name,
                     "reaches into \"" + sides[1]->part->name + "\" by " + numbers);
  }
}

void BuiltScene::addGrain(const GrainPart& part) {
  granular::GrainDef def;
  def.pose = part.pose;
  def.velocity = part.velocity;
  def.angularVelocity = part.spin;
  def.scale = part.scale;
  namedGrains_[part.name] = addGrainOf(sourceNamed("grains." + part.name), def);
}

void BuiltScene::addFill(const FillPart& part, std::size_t index) {
  granular::FillDef fill = part.fill;
  fill.seed = partSeed(def_, fill.seed, index);
  if (def_.gravity.norm() > 0.0) fill.up = -def_.gravity;
  fill.obstacles = particlesNear(part.region.bounds);
  granular::GrainDef def;
  def.velocity = part.velocity;
  def.angularVelocity = part.spin;
  const std::int32_t source = sourceNamed("fills." + part.name);
  for (const granular::PlacedGrain& grain :
       granular::fillRegion(clearOfExactBodies(part.region), shapeNamed(part.shape), fill)) {
    def.pose = grain.pose;
    def.scale = grain.scale;
    addGrainOf(source, def);
  }
}

/// The region less what is met exactly: a fill knows of no obstacles but particles.
granular::FillRegion BuiltScene::clearOfExactBodies(granular::FillRegion region) const {
  for (const BuiltBody& body : bodies_) {
    if (body.part->contact != BodyContact::exact) continue;
    const auto* space = std::get_if<HalfSpaceShape>(&body.part->shape);
    if (const auto* sphere = std::get_if<SphereShape>(&body.part->shape)) {
      region.depth = [depth = std::move(region.depth), center = body.pose().position,
                      radius = sphere->radius](const Vector3& p) {
        return std::min(depth(p), (p - center).norm() - radius);
      };
      continue;
    }
    if (!space) {
      const auto distance = std::make_shared<granular::MeshDistance>(body.solid->parts.front());
      region.depth = [depth = std::move(region.depth), pose = body.pose(), distance](const Vector3& p) {
        return std::min(depth(p), distance->nearest(pose.toOwn(p)).signedDistance);
      };
      continue;
    }
    region.depth = [depth = std::move(region.depth), pose = body.pose(), space](const Vector3& p) {
      return std::min(depth(p), space->normal.dot(pose.toOwn(p)) - space->height);
    };
  }
  return region;
}

/// What a fill must keep clear of: particles of bodies, and grains placed before.
std::vector<granular::ShapeParticle> BuiltScene::particlesNear(const Box& box) const {
  std::vector<granular::ParticleView> all;
  grains().readParticles(all);
  std::vector<granular::ShapeParticle> near;
  for (const granular::ParticleView& p : all) {
    const Vector3 nearest = p.position.cwiseMax(box.lower).cwiseMin(box.upper);
    if ((nearest - p.position).norm() <= 2.0 * p.radius) near.push_back({p.position, p.radius});
  }
  return near;
}

void BuiltScene::moveScriptedBodies(double time) {
  for (BuiltBody& built : bodies_) {
    if (built.part->script.empty()) continue;
    const Pose drawn = poseAt(def_.scripts.at(built.part->script), built.part->pose, time);
    built.body->setWorldTransform(toBullet(bullet_bridge::composed(drawn, built.solid->frame)));
  }
}

/// Grains that emitters owe for the tick to come.
void BuiltScene::pour() {
  std::vector<granular::ParticleView> present;
  for (std::size_t i = 0; i < emitters_.size(); ++i) {
    BuiltEmitter& built = emitters_[i];
    const EmitterPart& part = *built.part;
    const double seconds = std::min(time() + tickDuration(), part.to) - std::max(time(), part.from);
    if (seconds <= 0.0 || built.emitter.isDone()) continue;
    grains().readParticles(present);
    granular::GrainDef def;
    def.velocity = part.velocity;
    for (const granular::PlacedGrain& grain : built.emitter.pour(seconds, present)) {
      def.pose = grain.pose;
      def.scale = grain.scale;
      const granular::GrainId id = addGrainOf(sourceNamed("emitters." + part.name), def);
      const double mass = grains().massOf(id);
      const Vector3& center = grains().grainMotions()[id.index].pose.position;
      outside_.emitted += mass * (0.5 * def.velocity.squaredNorm() - def_.gravity.dot(center));
      outside_.emittedMass += mass;
    }
    built.mostWaiting = std::max(built.mostWaiting, built.emitter.waiting());
    if (built.emitter.waiting() > 0 && built.firstWait < 0.0) built.firstWait = time();
  }
}

granular::StepReport BuiltScene::tick() {
  pour();
  moveScriptedBodies(static_cast<double>(ticksDone_ + 1) * tickDuration());
  const auto dt = static_cast<btScalar>(tickDuration());
  world_->stepSimulation(dt, 1, dt);
  joints_.releaseBroken(*world_);
  ++ticksDone_;
  granular::StepReport report = world_->lastStep();
  report.time = time();
  if (joints_.count() > 0) {  // Bullet's solver moves bodies after the core has measured
    const granular::StepReport after = grains().measure();
    outside_.byConstraints += after.energy.total() - report.energy.total();
    report.energy = after.energy;
    report.momentum = after.momentum;
    report.angularMomentum = after.angularMomentum;
  }
  return report;
}

const BuiltBody& BuiltScene::body(const std::string& name) const {
  const auto found =
      std::find_if(bodies_.begin(), bodies_.end(), [&](const BuiltBody& b) { return b.part->name == name; });
  if (found == bodies_.end()) throw std::out_of_range("no body is named " + name);
  return *found;
}

std::int64_t BuiltScene::coveringParticles() const {
  std::int64_t count = 0;
  for (const BuiltBody& body : bodies_)
    count += static_cast<std::int64_t>(body.covering->covering.positions.size());
  return count;
}

std::vector<granular::CloudBody> BuiltScene::cloudBodies() const {
  std::vector<granular::CloudBody> all;
  for (const BuiltBody& body : bodies_) {
    if (body.part->meetsGrains()) all.push_back({world_->bodyIdOf(*body.body), body.material});
  }
  return all;
}

std::uint64_t BuiltScene::stateHash() const {
  StateHash hash;
  for (const granular::RigidMotion& motion : grains().grainMotions()) hash.add(motion);
  for (const granular::CloudBody& body : cloudBodies()) hash.add(grains().bodyMotion(body.id));
  return hash.value;
}

void replaceByMesh(SceneDef& scene, const std::filesystem::path& mesh) {
  const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                                 [](const BodyPart& b) { return b.replaceableByMesh; });
  if (body == scene.bodies.end()) {
    throw SceneError(scene.file.string(), "bodies",
                     "none is marked \"replaceableByMesh\", so --mesh has no place");
  }
  const Box bounds = boundsOf(body->shape);
  body->shape = MeshShape{.file = mesh, .boundingSize = bounds.size().norm(), .center = bounds.center()};
  boundsOf(body->shape);  // reads the file: throws now what is wrong with it
}

}  // namespace granular_demo
