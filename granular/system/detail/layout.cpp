// SPDX-License-Identifier: MIT
#include "granular/system/detail/layout.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <variant>

namespace granular::detail {
namespace {

/// The corner of the piece farthest from its particle's centre against the particle's own radius.
double overhangOf(const Owner& owner) {
  double most = 0.0;
  for (const SurfacePiece& piece : owner.body->pieces) {
    const ShapeParticle& particle = owner.particles[piece.particle];
    for (const Vector3& corner : piece.corners) {
      most = std::max(most, (corner - particle.position).norm() - particle.radius);
    }
  }
  return most;
}

}  // namespace

const BodyTraits kNoBody;

void Layout::finish(const std::vector<std::uint64_t>& excludedPairs) {
  particleCount = dynamicParticles = movingParticles = patchCount = 0;
  ownerOfSurface.clear();
  overhang.clear();
  rules = {};
  bool everythingMeets = true;
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(owners.size()); ++o) {
    Owner& owner = owners[o];
    const auto count = static_cast<std::int32_t>(owner.particles.size());
    owner.firstRank = particleCount;
    particleCount += count;
    if (o < dynamicCount()) dynamicParticles += count;
    if (o < movingCount()) {
      movingParticles += count;
      owner.patchCount = owner.kind == OwnerKind::Grain
                             ? 1
                             : std::max(1, (count + kParticlesPerPatch - 1) / kParticlesPerPatch);
      patchCount += owner.patchCount;
    }
    if (owner.body->exact != nullptr) ownerOfSurface.push_back(o);
    overhang.push_back(overhangOf(owner));
    everythingMeets &=
        owner.filter.group == ContactFilter{}.group && owner.filter.mask == ContactFilter{}.mask;
  }
  if (!everythingMeets) {
    for (const Owner& owner : owners) {
      rules.group.push_back(owner.filter.group);
      rules.mask.push_back(owner.filter.mask);
    }
  }
  rules.excludedPairs = excludedPairs;
  noteBodySurfaces();
  std::sort(rules.excludedPairs.begin(), rules.excludedPairs.end());
  findKinds();
  std::vector<std::int32_t> order(dynamicCount());
  std::iota(order.begin(), order.end(), 0);
  assignSlots(std::move(order));
}

void Layout::noteBodySurfaces() {
  const bool any = std::any_of(owners.begin(), owners.end(), [](const Owner& owner) {
    return owner.body->exact != nullptr && owner.body->exactUse == ExactUse::Bodies;
  });
  if (!any) return;
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(owners.size()); ++o) {
    const Owner& owner = owners[o];
    const bool movesParticles = o < dynamicCount() && !owner.particles.empty();
    rules.bodies.push_back(
        {.isBody = owner.kind == OwnerKind::Body,
         .movesParticles = owner.kind == OwnerKind::Body && movesParticles,
         .hasSurface = owner.body->exact != nullptr && owner.body->exactUse == ExactUse::Bodies});
  }
}

double Layout::areaAlong(const Owner& owner, std::int32_t local, const Vector3& N) {
  if (owner.body->pieces.empty()) {
    const double radius = owner.particles[local].radius;
    return 2.0 * std::sqrt(3.0) * radius * radius;
  }
  double area = 0.0;
  for (const SurfacePiece& piece : owner.body->piecesOf(local)) {
    area += std::max(0.0, N.dot(piece.areaVector()));
  }
  return area;
}

namespace {

/// What a body can touch with at once, and how deep it is: the largest area it shows along an axis of its
/// own, which both its sides make up, and the edge of a square of one side.
void measureBody(const Owner& owner, ParticleKind& kind) {
  for (int axis = 0; axis < 3; ++axis) {
    double area = 0.0;
    if (owner.body->pieces.empty()) {
      for (std::int32_t k = 0; k < static_cast<std::int32_t>(owner.particles.size()); ++k) {
        area += Layout::areaAlong(owner, k, Vector3::Unit(axis));
      }
    }
    for (const SurfacePiece& piece : owner.body->pieces) area += std::abs(piece.areaVector()[axis]);
    kind.bodyArea = std::max(kind.bodyArea, area);
  }
  kind.bodyLength = std::sqrt(0.5 * kind.bodyArea);
}

}  // namespace

void Layout::findKinds() {
  kinds.clear();
  kindOfRank.clear();
  kindOfRank.reserve(particleCount + surfaceCount());
  std::map<ParticleKind, std::int32_t> known;
  const auto kindIndex = [&](const ParticleKind& kind) {
    const auto [found, isNew] = known.try_emplace(kind, static_cast<std::int32_t>(kinds.size()));
    if (isNew) kinds.push_back(kind);
    return found->second;
  };
  smallestRadius = largestRadius = 0.0;
  for (const Owner& owner : owners) {
    ParticleKind kind{.inverseMass = owner.inverseMass,
                      .material = owner.material,
                      .isBody = owner.kind == OwnerKind::Body};
    if (kind.isBody) measureBody(owner, kind);
    for (const ShapeParticle& particle : owner.particles) {
      const double radius = particle.radius * owner.scale;
      smallestRadius = smallestRadius == 0.0 ? radius : std::min(smallestRadius, radius);
      largestRadius = std::max(largestRadius, radius);
      kind.inverseRadius = 1.0 / radius;
      kindOfRank.push_back(kindIndex(kind));
    }
  }
  if (smallestRadius == 0.0) smallestRadius = largestRadius = 1.0;  // no particles: nothing is measured by it
  for (const std::int32_t o : ownerOfSurface) {
    ParticleKind kind{.inverseMass = owners[o].inverseMass, .material = owners[o].material, .isBody = true};
    if (const auto* ball = std::get_if<ExactSphere>(owners[o].body->exact))
      kind.inverseRadius = 1.0 / ball->radius;
    kind.bodyArea = shownArea(*owners[o].body->exact).maxCoeff();
    kind.bodyLength = std::sqrt(0.5 * kind.bodyArea);
    kindOfRank.push_back(kindIndex(kind));
  }
}

void Layout::assignSlots(std::vector<std::int32_t> order) {
  ownerOfPlace = std::move(order);
  for (auto o = static_cast<std::int32_t>(ownerOfPlace.size()); o < static_cast<std::int32_t>(owners.size());
       ++o) {
    ownerOfPlace.push_back(o);
  }
  placeOfOwner.resize(owners.size());
  for (auto* bySlot : {&ownerOfSlot, &placeOfSlot, &rankOfSlot, &patchOfSlot, &slotOfRank}) {
    bySlot->resize(particleCount + surfaceCount());
  }
  placeOfPatch.clear();
  slotOfPatch.clear();
  slotOfPlace.clear();
  patchOfPlace.clear();
  isotropicInverseInertia.clear();
  isSphere.clear();
  movesOnlySpheres = movingBodies() == 0;
  std::int32_t slot = 0;
  for (std::int32_t place = 0; place < static_cast<std::int32_t>(owners.size()); ++place) {
    const std::int32_t o = ownerOfPlace[place];
    Owner& owner = owners[o];
    placeOfOwner[o] = place;
    const bool turnsFreely = owner.isotropic && !owner.isLocked;
    isotropicInverseInertia.push_back(turnsFreely ? owner.inverseInertia.x() : 0.0);
    isSphere.push_back(owner.isSphere && turnsFreely);
    if (place < dynamicCount()) movesOnlySpheres &= owner.isSphere && turnsFreely;
    slotOfPlace.push_back(slot);
    patchOfPlace.push_back(static_cast<std::int32_t>(placeOfPatch.size()));
    owner.firstSlot = slot;
    if (owner.patchCount > 0) owner.firstPatch = static_cast<std::int32_t>(placeOfPatch.size());
    for (std::int32_t patch = 0; patch < owner.patchCount; ++patch) {
      placeOfPatch.push_back(place);
      slotOfPatch.push_back(slot + patch * kParticlesPerPatch);
    }
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(owner.particles.size()); ++k, ++slot) {
      const std::int32_t rank = owner.firstRank + k;
      ownerOfSlot[slot] = o;
      placeOfSlot[slot] = place;
      rankOfSlot[slot] = rank;
      slotOfRank[rank] = slot;
      patchOfSlot[slot] = owner.patchCount == 0   ? -1
                          : owner.patchCount == 1 ? owner.firstPatch
                                                  : owner.firstPatch + k / kParticlesPerPatch;
    }
  }
  slotOfPlace.push_back(slot);
  slotOfPatch.push_back(movingParticles);
  patchOfPlace.push_back(static_cast<std::int32_t>(placeOfPatch.size()));
  for (std::int32_t s = 0; s < surfaceCount(); ++s) {
    const std::int32_t at = particleCount + s;
    ownerOfSlot[at] = ownerOfSurface[s];
    placeOfSlot[at] = placeOfOwner[ownerOfSurface[s]];
    rankOfSlot[at] = slotOfRank[at] = at;
    patchOfSlot[at] = owners[ownerOfSurface[s]].firstPatch;
  }
}

}  // namespace granular::detail
