// SPDX-License-Identifier: MIT
// Which pairs of covered bodies meet in the core, and which manifolds Bullet's solver must not see.
#include <algorithm>
#include <stdexcept>

#include "bullet_bridge/layer.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {
namespace detail {

Layer::Pair Layer::makePair(const btRigidBody& a, const btRigidBody& b) {
  return std::less<>{}(&a, &b) ? Pair{&a, &b} : Pair{&b, &a};
}

void Layer::forgetPairsOf(const btRigidBody& body, std::set<Pair>& pairs) {
  std::erase_if(pairs, [&](const Pair& pair) { return pair.first == &body || pair.second == &body; });
}

void Layer::setPairOwner(const btRigidBody& a, const btRigidBody& b, PairOwner owner) {
  if (!isCovered(a) || !isCovered(b) || &a == &b) {
    throw std::invalid_argument("setPairOwner: both bodies must be covered, and not be the same");
  }
  if (owner == PairOwner::Bullet) {
    bulletOwned_.insert(makePair(a, b));
  } else {
    bulletOwned_.erase(makePair(a, b));
  }
}

/// The program's overlap filter is asked once per pair, as Bullet does: when the pair could first come into
/// being.
void Layer::noteFilteredPairs(const btRigidBody& body) {
  btOverlappingPairCache& cache = *world_.getPairCache();
  if (!cache.getOverlapFilterCallback()) return;
  auto* proxy = const_cast<btBroadphaseProxy*>(body.getBroadphaseProxy());
  for (const CoveredBody& other : bodies_) {
    if (!cache.needsBroadphaseCollision(other.body->getBroadphaseProxy(), proxy)) {
      filteredOut_.insert(makePair(body, *other.body));
    }
  }
}

/// Pairs of covered bodies that must not meet in the core: Bullet's own, filtered ones, linked bodies and
/// ignore lists, and among pairs that Bullet sees near each other whatever an overridden check or dispatcher
/// says no to.
std::set<Layer::Pair> Layer::wantedExclusions() const {
  std::set<Pair> pairs = bulletOwned_;
  pairs.insert(filteredOut_.begin(), filteredOut_.end());
  if (bodies_.size() < 2) return pairs;
  for (const CoveredBody& covered : bodies_) {
    for (int i = 0; i < covered.body->getNumObjectsWithoutCollision(); ++i) {
      const CoveredBody* other = find(covered.body->getObjectWithoutCollision(i));
      if (other) pairs.insert(makePair(*covered.body, *other->body));
    }
  }
  const btBroadphasePairArray& near = world_.getPairCache()->getOverlappingPairArray();
  for (int i = 0; i < near.size(); ++i) {
    const CoveredBody* a = find(static_cast<btCollisionObject*>(near[i].m_pProxy0->m_clientObject));
    const CoveredBody* b =
        a ? find(static_cast<btCollisionObject*>(near[i].m_pProxy1->m_clientObject)) : nullptr;
    if (!b || (a->body->isStaticOrKinematicObject() && b->body->isStaticOrKinematicObject())) continue;
    const bool meet = a->body->checkCollideWith(b->body) && b->body->checkCollideWith(a->body) &&
                      world_.getDispatcher()->needsResponse(a->body, b->body);
    if (!meet) pairs.insert(makePair(*a->body, *b->body));
  }
  return pairs;
}

void Layer::updateExclusions() {
  std::set<Pair> wanted = wantedExclusions();
  if (wanted == excluded_) return;
  for (const Pair& pair : excluded_) {
    if (!wanted.contains(pair)) system_.setBodyPairContact(idOf(*pair.first), idOf(*pair.second), true);
  }
  for (const Pair& pair : wanted) {
    if (!excluded_.contains(pair)) system_.setBodyPairContact(idOf(*pair.first), idOf(*pair.second), false);
  }
  excluded_ = std::move(wanted);
}

/// Bullet keeps finding the contacts of pairs the particles own, for the program's eyes; only its solver must
/// not see them. Predictive contacts are manifolds as well.
void Layer::silenceOwnPairs() {
  if (bodies_.size() < 2) return;
  btDispatcher& dispatcher = *world_.getDispatcher();
  for (int i = 0; i < dispatcher.getNumManifolds(); ++i) {
    btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(i);
    if (manifold->getNumContacts() == 0) continue;
    const CoveredBody* a = find(manifold->getBody0());
    const CoveredBody* b = a ? find(manifold->getBody1()) : nullptr;
    if (!b || !meetInCore(*a, *b) || bulletOwned_.contains(makePair(*a->body, *b->body))) continue;
    silenced_.emplace_back(manifold, manifold->getNumContacts());
    manifold->setNumContacts(0);
  }
}

void Layer::unsilenceOwnPairs() {
  for (const auto& [manifold, contacts] : silenced_) manifold->setNumContacts(contacts);
  silenced_.clear();
}

}  // namespace detail
}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
