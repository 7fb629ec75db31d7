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

ParticleKind particleKind(const Owner& owner, std::int32_t local) {
  return {.inverseRadius = 1.0 / (owner.particles[local].radius * owner.scale),
          .inverseMass = owner.inverseMass,
          .material = owner.material,
          .isBody = owner.kind == OwnerKind::Body,
          .bodyLength = owner.body->length,
          .bodyArea = owner.body->area};
}

ParticleKind surfaceKind(const Owner& owner) {
  const auto* ball = std::get_if<ExactSphere>(owner.body->exact);
  const double area = shownArea(*owner.body->exact).maxCoeff();
  return {.inverseRadius = ball ? 1.0 / ball->radius : 0.0,
          .inverseMass = owner.inverseMass,
          .material = owner.material,
          .isBody = true,
          .bodyLength = std::sqrt(0.5 * area),
          .bodyArea = area};
}

void Layout::finish() {
  particleCount = dynamicParticles = movingParticles = patchCount = 0;
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(owners.size()); ++o) {
    Owner& owner = owners[o];
    const auto count = static_cast<std::int32_t>(owner.particles.size());
    owner.firstRank = particleCount;
    particleCount += count;
    if (o < dynamicCount()) dynamicParticles += count;
    if (o < movingCount()) movingParticles += count;
    patchCount += patchCountOf(o);
    if (owner.body->exact != nullptr) ownerOfSurface.push_back(o);
  }
  noteBodySurfaces();
  noteOverhangs();
  measureRadii();
  findKinds();
}

std::int32_t Layout::patchCountOf(std::int32_t owner) const {
  if (owner >= movingCount()) return 0;
  if (owners[owner].kind == OwnerKind::Grain) return 1;
  const auto count = static_cast<std::int32_t>(owners[owner].particles.size());
  return std::max(1, (count + kParticlesPerPatch - 1) / kParticlesPerPatch);
}

void Layout::noteOverhangs() {
  for (std::size_t o = 0; o < owners.size(); ++o) {
    const double length = detail::overhangOf(owners[o]);
    if (length == 0.0) continue;
    overhang.resize(owners.size(), 0.0);
    overhang[o] = length;
  }
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

/// What a body can touch with at once, and how deep it is: the largest area it shows along an axis of its
/// own, which both its sides make up, and the edge of a square of one side.
void Layout::measureBody(const Owner& owner, BodyTraits& traits) {
  for (int axis = 0; axis < 3; ++axis) {
    double area = 0.0;
    if (owner.body->pieces.empty()) {
      for (std::int32_t k = 0; k < static_cast<std::int32_t>(owner.particles.size()); ++k) {
        area += areaAlong(owner, k, Vector3::Unit(axis));
      }
    }
    for (const SurfacePiece& piece : owner.body->pieces) area += std::abs(piece.areaVector()[axis]);
    traits.area = std::max(traits.area, area);
  }
  traits.length = std::sqrt(0.5 * traits.area);
}

void Layout::measureRadii() {
  smallestRadius = largestRadius = 0.0;
  for (const Owner& owner : owners) {
    for (const ShapeParticle& particle : owner.particles) {
      const double radius = particle.radius * owner.scale;
      smallestRadius = smallestRadius == 0.0 ? radius : std::min(smallestRadius, radius);
      largestRadius = std::max(largestRadius, radius);
    }
  }
  if (smallestRadius == 0.0) smallestRadius = largestRadius = 1.0;  // no particles: nothing is measured by it
}

void Layout::findKinds() {
  std::map<ParticleKind, std::int32_t> known;
  kindOfRank.reserve(particleCount + surfaceCount());
  forEachKind([&](const ParticleKind& kind, std::int32_t, bool) {
    if (known.size() > kMostKinds) return;
    const auto [found, isNew] = known.try_emplace(kind, static_cast<std::int32_t>(kinds.size()));
    if (isNew) kinds.push_back(kind);
    kindOfRank.push_back(found->second);
  });
  if (known.size() <= kMostKinds) return;
  kinds.clear();
  std::vector<std::int32_t>().swap(kindOfRank);
}

void Layout::sortPlaces(const std::function<Vector3(std::int32_t)>& centerOf) {
  // Cells of a few grains, walked in Z-order (Morton 1966): neighbours in space become neighbours in memory.
  const double edge = 4.0 * largestRadius;
  const auto spread = [](std::uint64_t v) {  // 21 bits, two zero bits between each
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    return (v | v << 2) & 0x1249249249249249;
  };
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed(dynamicCount());
  for (std::int32_t o = 0; o < dynamicCount(); ++o) {
    std::uint64_t key = 0;
    const Vector3 center = centerOf(o);
    for (int axis = 0; axis < 3; ++axis) {
      const double cell = std::clamp(std::floor(center[axis] / edge) + 0x100000, 0.0, double{0x1fffff});
      key |= spread(static_cast<std::uint64_t>(cell)) << axis;
    }
    keyed[o] = {key, o};
  }
  std::sort(keyed.begin(), keyed.end());
  ownerOfPlace.resize(owners.size());
  std::iota(ownerOfPlace.begin(), ownerOfPlace.end(), 0);
  std::transform(keyed.begin(), keyed.end(), ownerOfPlace.begin(), [](const auto& k) { return k.second; });
  assignSlots();
}

/// In the order of ownerOfPlace.
void Layout::assignSlots() {
  const auto ownerCount = static_cast<std::int32_t>(owners.size());
  placeOfOwner.resize(ownerCount);
  isotropicInverseInertia.resize(ownerCount);
  isSphere.resize(ownerCount);
  for (auto* byPlace : {&slotOfPlace, &patchOfPlace}) byPlace->resize(ownerCount + 1);
  for (auto* bySlot : {&ownerOfSlot, &placeOfSlot, &rankOfSlot, &patchOfSlot, &slotOfRank}) {
    bySlot->resize(particleCount + surfaceCount());
  }
  movesOnlySpheres = movingBodies() == 0;
  std::int32_t slot = 0, patch = 0;
  for (std::int32_t place = 0; place < ownerCount; ++place) {
    const std::int32_t o = ownerOfPlace[place];
    Owner& owner = owners[o];
    placeOfOwner[o] = place;
    const bool turnsFreely = owner.isotropic && !owner.isLocked;
    isotropicInverseInertia[place] = turnsFreely ? owner.inverseInertia.x() : 0.0;
    isSphere[place] = owner.isSphere && turnsFreely;
    if (place < dynamicCount()) movesOnlySpheres &= owner.isSphere && turnsFreely;
    owner.firstSlot = slotOfPlace[place] = slot;
    patchOfPlace[place] = patch;
    const std::int32_t patches = patchCountOf(o);
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(owner.particles.size()); ++k, ++slot) {
      const std::int32_t rank = owner.firstRank + k;
      ownerOfSlot[slot] = o;
      placeOfSlot[slot] = place;
      rankOfSlot[slot] = rank;
      slotOfRank[rank] = slot;
      patchOfSlot[slot] = patches == 0 ? -1 : patches == 1 ? patch : patch + k / kParticlesPerPatch;
    }
    patch += patches;
  }
  slotOfPlace[ownerCount] = slot;
  patchOfPlace[ownerCount] = patch;
  for (std::int32_t s = 0; s < surfaceCount(); ++s) {
    const std::int32_t o = ownerOfSurface[s], at = particleCount + s;
    ownerOfSlot[at] = o;
    placeOfSlot[at] = placeOfOwner[o];
    rankOfSlot[at] = slotOfRank[at] = at;
    patchOfSlot[at] = patchCountOf(o) > 0 ? patchOfPlace[placeOfOwner[o]] : -1;
  }
}

}  // namespace granular::detail
