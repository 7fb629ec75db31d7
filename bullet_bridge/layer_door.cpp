// SPDX-License-Identifier: MIT
#include "bullet_bridge/layer_door.h"

#include "bullet_bridge/layer.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

LayerDoor::LayerDoor(std::unique_ptr<detail::Layer> layer) : layer_(std::move(layer)) {}

LayerDoor::~LayerDoor() = default;

std::vector<granular::GrainId> LayerDoor::addPile(const PileDef& def) {
  return layer_->addPile(def);
}

granular::BodyId LayerDoor::coverBody(btRigidBody& body, const CoverBodyDef& def) {
  return layer_->cover(body, def);
}

void LayerDoor::uncoverBody(btRigidBody& body) {
  layer_->uncover(body);
}

bool LayerDoor::isCovered(const btRigidBody& body) const {
  return layer_->isCovered(body);
}

granular::BodyId LayerDoor::bodyIdOf(const btRigidBody& body) const {
  return layer_->idOf(body);
}

granular::Pose LayerDoor::massFrameOf(const btRigidBody& body) const {
  return layer_->massFrameOf(body);
}

void LayerDoor::setPairOwner(const btRigidBody& a, const btRigidBody& b, PairOwner owner) {
  layer_->setPairOwner(a, b, owner);
}

granular::GranularSystem& LayerDoor::grains() {
  return layer_->system();
}

const granular::GranularSystem& LayerDoor::grains() const {
  return layer_->system();
}

const granular::StepReport& LayerDoor::lastStep() const {
  return layer_->report();
}

void LayerDoor::setBudget(const granular::WorkBudget& budget) {
  layer_->setBudget(budget);
}

void LayerDoor::readContacts(std::vector<BodyContact>& contacts) {
  layer_->readContacts(contacts);
}

void LayerDoor::setContactListener(ContactListener listener) {
  layer_->setContactListener(std::move(listener));
}

granular::Wrench LayerDoor::contactForce(const btRigidBody& body) {
  return layer_->contactForce(body);
}

std::optional<GrainHit> LayerDoor::castRay(const granular::Vector3& from, const granular::Vector3& to) const {
  return layer_->castRay(from, to);
}

void LayerDoor::readGrainPoses(std::vector<granular::Pose>& poses) const {
  layer_->readGrainPoses(poses);
}

void LayerDoor::showGrainsToQueries(int group, int mask) {
  layer_->showGrainsToQueries(group, mask);
}

void LayerDoor::hideGrainsFromQueries() {
  layer_->hideGrainsFromQueries();
}

std::optional<granular::GrainId> LayerDoor::grainOf(const btCollisionObject* object, int childIndex) const {
  return layer_->grainOf(object, childIndex);
}

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
