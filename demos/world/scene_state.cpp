// SPDX-License-Identifier: MIT
// BuiltScene out of and into a SavedState.
#include <algorithm>
#include <map>

#include "bullet_bridge/convert.h"
#include "demos/scene/json_object.h"
#include "demos/world/built_scene.h"

namespace granular_demo {
namespace {

using bullet_bridge::toBullet;
using granular::OwnerKind;

constexpr const char* kFile = "state";

}  // namespace

SavedState BuiltScene::savedState() const {
  SavedState state;
  state.document = def_.document;
  state.scene = def_.name;
  state.scale = def_.scale;
  state.seed = def_.seed;
  state.time = time();
  state.ticks = ticksDone_;
  for (const GrainSource& source : sources_) state.sources.push_back(source.name);
  const auto motions = grains().grainMotions();
  std::map<std::int32_t, std::int32_t> placeOfGrain, placeOfBody;
  for (std::int32_t i = 0; i < static_cast<std::int32_t>(motions.size()); ++i) {
    const granular::GrainId id = grains().grainAt(i);
    if (id.index < 0) continue;  // removed
    placeOfGrain[i] = static_cast<std::int32_t>(state.grains.size());
    state.grains.push_back({sourceOfGrain_[i], grains().scaleOf(id), motions[i]});
  }
  for (const BuiltBody& body : bodies_) {
    if (body.part->meetsGrains())
      placeOfBody[world_->bodyIdOf(*body.body).index] = static_cast<std::int32_t>(state.bodyNames.size());
    state.bodyNames.push_back(body.part->name);
    if (body.part->motion == BodyKind::dynamic) state.bodies.push_back({body.part->name, motionOf(body)});
  }
  for (const BuiltEmitter& built : emitters_)
    state.emitters.push_back({built.part->name, built.emitter.secondsPoured(), built.emitter.poured()});
  state.brokenJoints = joints_.brokenNames();
  const auto place = [&](OwnerKind kind, std::int32_t& index) {
    index = (kind == OwnerKind::Grain ? placeOfGrain : placeOfBody).at(index);
  };
  const auto placeBoth = [&](granular::RememberedContact& contact) {
    for (int side = 0; side < 2; ++side) place(contact.kind[side], contact.index[side]);
  };
  state.memory = grains().contactMemory();
  for (granular::RememberedContact& contact : state.memory) placeBoth(contact);
  state.sleep = grains().sleepState();
  for (granular::SleepState::Sleeper& sleeper : state.sleep.sleepers) place(sleeper.kind, sleeper.index);
  for (granular::SleepState::Rester& rester : state.sleep.resters) place(rester.kind, rester.index);
  for (granular::FrozenContact& contact : state.sleep.frozen) placeBoth(contact.memory);
  return state;
}

granular::RigidMotion BuiltScene::motionOf(const BuiltBody& body) const {
  if (body.part->meetsGrains()) return grains().bodyMotion(world_->bodyIdOf(*body.body));
  return {.pose = body.pose(),
          .velocity = bullet_bridge::fromBullet(body.body->getLinearVelocity()),
          .angularVelocity = bullet_bridge::fromBullet(body.body->getAngularVelocity())};
}

void BuiltScene::restore(const SavedState& state) {
  for (const SavedState::Body& saved : state.bodies) restoreBody(saved);
  for (const std::string& name : state.brokenJoints) {
    try {
      joints_.breakByName(name);
    } catch (const std::invalid_argument& error) {
      throw SceneError(kFile, "brokenJoints", error.what());
    }
  }
  restoreGrains(state);
  restoreMemory(state);
  restoreSleep(state);
}

/// A body that the scene no longer has is left out: a scene that goes on may take bodies away.
void BuiltScene::restoreBody(const SavedState::Body& saved) {
  const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                  [&](const BuiltBody& body) { return body.part->name == saved.name; });
  if (found == bodies_.end()) return;
  if (found->part->motion != BodyKind::dynamic)
    throw SceneError(def_.file.string(), "bodies." + saved.name + ".motion",
                     "is dynamic in the state file; allowed: \"dynamic\"");
  btRigidBody& body = *found->body;
  body.setCenterOfMassTransform(toBullet(saved.motion.pose));
  body.setInterpolationWorldTransform(body.getWorldTransform());
  body.setLinearVelocity(toBullet(saved.motion.velocity));
  body.setAngularVelocity(toBullet(saved.motion.angularVelocity));
  body.activate(true);
  if (found->part->meetsGrains()) grains().setBodyMotion(world_->bodyIdOf(body), saved.motion);
}

void BuiltScene::restoreGrains(const SavedState& state) {
  std::vector<std::int32_t> sourceNow;
  for (const std::string& name : state.sources) sourceNow.push_back(sourceNamed(name));
  for (const SavedState::Grain& saved : state.grains) {
    if (sourceNow[saved.source] < 0)
      throw SceneError(def_.file.string(), state.sources[saved.source],
                       "is missing; grains of the state file come from it");
    granular::GrainDef def;
    def.scale = saved.scale;
    const granular::GrainId id = addGrainOf(sourceNow[saved.source], def);
    grains().setGrainMotion(id, saved.motion);
    if (state.sources[saved.source].starts_with("grains."))
      namedGrains_[state.sources[saved.source].substr(7)] = id;
  }
}

/// Index of an owner of the file; grains were added in the order of the file, so their places are their
/// indices. Whether the scene still has it.
bool BuiltScene::findOwner(const SavedState& state, OwnerKind kind, std::int32_t& index) const {
  if (kind == OwnerKind::Grain) return true;
  const std::string& name = state.bodyNames[index];
  const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                  [&](const BuiltBody& body) { return body.part->name == name; });
  if (found == bodies_.end() || !found->part->meetsGrains()) return false;
  index = world_->bodyIdOf(*found->body).index;
  return true;
}

bool BuiltScene::findOwners(const SavedState& state, granular::RememberedContact& contact) const {
  return findOwner(state, contact.kind[0], contact.index[0]) &&
         findOwner(state, contact.kind[1], contact.index[1]);
}

void BuiltScene::restoreMemory(const SavedState& state) {
  std::vector<granular::RememberedContact> memory;
  for (granular::RememberedContact contact : state.memory) {
    if (findOwners(state, contact)) memory.push_back(contact);
  }
  if (!memory.empty()) grains().setContactMemory(memory);
}

void BuiltScene::restoreSleep(const SavedState& state) {
  granular::SleepState sleep;
  sleep.untilLook = state.sleep.untilLook;
  sleep.untilWaking = state.sleep.untilWaking;
  for (granular::SleepState::Rester rester : state.sleep.resters) {
    if (findOwner(state, rester.kind, rester.index)) sleep.resters.push_back(rester);
  }
  for (granular::SleepState::Sleeper sleeper : state.sleep.sleepers) {
    if (findOwner(state, sleeper.kind, sleeper.index)) sleep.sleepers.push_back(sleeper);
  }
  for (granular::FrozenContact contact : state.sleep.frozen) {
    if (findOwners(state, contact.memory)) sleep.frozen.push_back(contact);
  }
  if (!sleep.sleepers.empty() || !sleep.resters.empty()) grains().setSleepState(sleep);
}

}  // namespace granular_demo
