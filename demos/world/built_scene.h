// SPDX-License-Identifier: MIT
// A scene file come alive: a Bullet world with sand in it, its bodies covered, its grains placed.
// Nothing happens here that the file does not say.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bullet_bridge/bullet_bridge.h"
#include "demos/scene/scene_def.h"
#include "demos/world/body_covering.h"
#include "demos/world/body_solid.h"
#include "demos/world/impact_speed.h"
#include "demos/world/saved_state.h"
#include "demos/world/scene_joints.h"
#include "granular/io/vtp_writer.h"

namespace granular_demo {

struct BuiltBody {
  const BodyPart* part = nullptr;
  std::shared_ptr<const BodySolid> solid;        ///< copies of one body share it
  std::shared_ptr<const BodyCovering> covering;  ///< shared likewise; empty for a body without covering
  double mass = 0.0;                             ///< kg; 0 unless dynamic
  granular::MaterialId material;
  std::unique_ptr<btRigidBody> body;

  Pose pose() const;       ///< of the body frame, world, as Bullet has it
  Pose drawnPose() const;  ///< of the frame the shape was drawn in, world
};

/// Energy that came into grains and dynamic bodies by ways the core does not count, since the start.
struct OutsideEnergy {
  double emitted = 0.0;        ///< J, kinetic and gravitational (zero at the world's origin)
  double emittedMass = 0.0;    ///< kg
  double byConstraints = 0.0;  ///< J, by joints: change of energy by Bullet's solver
  double sum() const { return emitted + byConstraints; }
};

/// How an emitter did.
struct BuiltEmitter {
  const EmitterPart* part = nullptr;
  granular::Emitter emitter;
  std::int64_t mostWaiting = 0;  ///< grains that were due and found no room, at worst
  double firstWait = -1.0;       ///< s, when that first happened; < 0: never
};

class BuiltScene {
 public:
  /// `state`: grains, poses and motions to begin with in place of fills and grains of the file; of the same
  /// scene (by name) the time goes on, else it begins anew.
  /// Throws SceneError (json_object.h) with file and key path of the part that cannot be built.
  BuiltScene(SceneDef def, int threads, const SavedState* state = nullptr);
  ~BuiltScene();

  /// One Bullet step of the scene's frame time over its ticks; what the core did in it.
  granular::StepReport tick();

  const SceneDef& def() const { return def_; }
  double tickDuration() const { return def_.frameDuration() / def_.ticksPerFrame; }
  std::int64_t ticksDone() const { return ticksDone_; }
  double time() const { return static_cast<double>(ticksDone_) * tickDuration(); }
  bullet_bridge::GranularDynamicsWorld& world() { return *world_; }
  const bullet_bridge::GranularDynamicsWorld& world() const { return *world_; }
  granular::GranularSystem& grains() { return world_->grains(); }
  const granular::GranularSystem& grains() const { return world_->grains(); }
  const std::vector<BuiltBody>& bodies() const { return bodies_; }
  const SceneJoints& joints() const { return joints_; }
  const std::vector<BuiltEmitter>& emitters() const { return emitters_; }
  const OutsideEnergy& outsideEnergy() const { return outside_; }
  const BuiltBody& body(const std::string& name) const;
  granular::GrainId grain(const std::string& name) const { return namedGrains_.at(name); }
  granular::MaterialId material(const std::string& name) const { return materials_.at(name); }
  /// How the grain in that place shall look, by GrainId::index.
  const GrainLook& lookOf(std::int32_t grainIndex) const {
    return *sources_[sourceOfGrain_.at(grainIndex)].look;
  }
  std::int64_t coveringParticles() const;
  /// The largest speed of impacts to reckon with.
  const ImpactSpeed& impactSpeed() const { return impactSpeed_; }
  /// What is legal but unwise in this scene at that speed, one line each (granular::GranularSystem::advice).
  const std::vector<std::string>& advice() const { return advice_; }
  /// The covered bodies as the VTP writer wants them.
  std::vector<granular::CloudBody> cloudBodies() const;
  /// What there is, for a file to go on from.
  SavedState savedState() const;
  /// A number made of every bit of the state of grains and bodies: equal runs have equal hashes.
  std::uint64_t stateHash() const;

 private:
  void addMaterials();
  void addShapes();
  void addBody(const BodyPart& part, double smallestGrainRadius, int threads);
  void coverBody(BuiltBody& body, double smallestGrainRadius, int threads);
  void addJoints();
  void addEmitters(const SavedState* state);
  void listSources();
  const granular::GrainShapeDef& shapeNamed(const std::string& name) const;
  void restore(const SavedState& state);
  void restoreBody(const SavedState::Body& saved);
  void restoreGrains(const SavedState& state);
  void restoreMemory(const SavedState& state);
  void restoreSleep(const SavedState& state);
  bool findOwner(const SavedState& state, granular::OwnerKind kind, std::int32_t& index) const;
  bool findOwners(const SavedState& state, granular::RememberedContact& contact) const;
  void checkStartOverlap();
  void pour();
  granular::RigidMotion motionOf(const BuiltBody& body) const;
  void addFill(const FillPart& part, std::size_t index);
  void addGrain(const GrainPart& part);
  std::vector<granular::ShapeParticle> particlesNear(const Box& box) const;
  granular::FillRegion clearOfExactBodies(granular::FillRegion region) const;
  double smallestGrainRadius() const;
  void moveScriptedBodies(double time);

  SceneDef def_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  std::vector<BuiltBody> bodies_;
  std::unique_ptr<bullet_bridge::GranularDynamicsWorld> world_;
  std::map<std::string, granular::MaterialId> materials_;
  std::map<std::string, granular::GrainShapeId> shapes_;
  std::map<std::string, granular::GrainId> namedGrains_;
  /// Where grains come from, by name: "fills.heap".
  struct GrainSource {
    std::string name, shape, material;
    const GrainLook* look;
  };
  std::vector<GrainSource> sources_;
  std::int32_t sourceNamed(const std::string& name) const;  ///< -1: none
  granular::GrainId addGrainOf(std::int32_t source, granular::GrainDef def);

  std::vector<std::int32_t> sourceOfGrain_;  ///< by GrainId::index
  std::vector<BuiltEmitter> emitters_;
  SceneJoints joints_;
  OutsideEnergy outside_;
  std::int64_t ticksDone_ = 0;
  ImpactSpeed impactSpeed_;
  std::vector<std::string> advice_;
};

/// Puts the mesh of a file in place of the body the scene marks with "replaceableByMesh": same bounding size,
/// same place, mass properties from the mesh (a mass given in the file stays; a density makes the mass from
/// the volume). Throws std::runtime_error if no body is marked or the file is not a solid's mesh.
void replaceByMesh(SceneDef& scene, const std::filesystem::path& mesh);

}  // namespace granular_demo
