// SPDX-License-Identifier: MIT
// The stages that find contacts and work out their forces: which laws hold between which kinds of particles,
// where two particles meet, and runs of contacts through the kernel compiled for their two laws.
#include <cmath>
#include <limits>
#include <span>
#include <variant>

#include "granular/contact/law_list.h"
#include "granular/contact/pressed_patch.h"
#include "granular/system/detail/contact_pack.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

/// Line of centres for two particles in one place: any direction does, as long as it is always the same.
const Vector3 kAnyDirection = Vector3::UnitY();

}  // namespace

PairLaw Evaluation::makeLaw(std::int32_t kindA, std::int32_t kindB) const {
  const ParticleKind &a = layout_.kinds[kindA], &b = layout_.kinds[kindB];
  return makePairLaw(materialPairs_[a.material * materials_.size() + b.material],
                     sideOf(a, materials_[a.material]), sideOf(b, materials_[b.material]));
}

void Evaluation::makePairLaws() {
  if (lawsByKind_) {
    const auto kinds = static_cast<std::int32_t>(layout_.kinds.size());
    pairLaws_.assign(layout_.kinds.size() * layout_.kinds.size(), PairLaw{});
    for (std::int32_t a = 0; a < kinds; ++a) {
      for (std::int32_t b = 0; b < kinds; ++b) {
        // Two planes, or two held things: they never meet, and nothing could be said of them.
        const ParticleKind &kindA = layout_.kinds[a], &kindB = layout_.kinds[b];
        if (kindA.inverseMass + kindB.inverseMass > 0.0 && kindA.inverseRadius + kindB.inverseRadius > 0.0) {
          pairLaws_[a * kinds + b] = makeLaw(a, b);
        }
      }
    }
    return;
  }
  pairLaws_.resize(list_.size());
  executor_.forRanges(layout_.dynamicParticles, kRowsPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      for (std::int32_t c = list_.rowStart()[i]; c < list_.rowStart()[i + 1]; ++c) {
        pairLaws_[c] = makeLaw(layout_.kindOfSlot[i], layout_.kindOfSlot[list_.partner()[c]]);
      }
    }
  });
}

/// Which laws can occur at all: scenes without memory, and scenes with one kernel, pay for neither.
void Evaluation::noteLaws() {
  hasMemory_ = false;
  oneKernel_ = true;
  const MaterialPairDef& first = materialPairs_.empty() ? MaterialPairDef{} : materialPairs_.front().def;
  for (const MaterialPair& pair : materialPairs_) {
    const ShearLaw shear = pair.def.shear.law;
    hasMemory_ |= withShearLaw(shear, []<class Law>(Law) { return Law::kHasMemory; });
    oneKernel_ &= shear == first.shear.law && pair.def.normal.law == first.normal.law;
    // Bodies meet under bodyNormal, at least one of them moving.
    oneKernel_ &= layout_.dynamicBodies == 0 || pair.def.bodyNormal.law == first.normal.law;
  }
}

const PairLaw& Evaluation::pairLaw(const Contact& contact) const {
  if (!lawsByKind_) return pairLaws_[contact.candidate];
  return pairLaws_[layout_.kindOfSlot[contact.slot1] * layout_.kinds.size() +
                   layout_.kindOfSlot[contact.slot2]];
}

void Evaluation::findContacts() {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::FindContacts)]);
  const std::int32_t rows = layout_.dynamicParticles;
  const std::int32_t pieces = Executor::pieceCount(rows, kRowsPerPiece);
  contactsInPiece_.assign(pieces, 0);
  executor_.forPieces(pieces, [&](std::int32_t piece) {
    const std::int32_t begin = piece * kRowsPerPiece;
    const std::int32_t end = std::min(rows, begin + kRowsPerPiece);
    const std::int32_t* rowStart = list_.rowStart().data();
    const std::int32_t* partner = list_.partner().data();
    std::int32_t n = rowStart[begin];
    for (std::int32_t i = begin; i < end; ++i) {
      const ParticleRow a = particles_[i];
      const std::int32_t first = n;
      for (std::int32_t c = rowStart[i]; c < rowStart[i + 1]; ++c) {
        bool touches;
        if (partner[c] < layout_.particleCount) {
          const ParticleRow& b = particles_[partner[c]];
          const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z, reach = a.radius + b.radius;
          touches = dx * dx + dy * dy + dz * dz < reach * reach;
        } else {
          const double reach = a.radius + layout_.overhang[layout_.ownerOfSlot[i]];
          const SurfaceRow& surface = surfaces_[partner[c] - layout_.particleCount];
          touches = surface.distance({a.x, a.y, a.z}).distance < reach;
        }
        contactOfCandidate_[c] = touches ? n : -1;
        contacts_[n] = {i, partner[c], c};  // overwritten by the next one unless it counts: n <= c always
        n += touches;
      }
      contactsOfRow_[i] = {first, n};
    }
    contactsInPiece_[piece] = n - rowStart[begin];
  });
}

/// What bodies press with. Of a particle against an exact surface: its pieces, where they are below it. Of
/// two particles: the areas they show, as springs one behind the other, as deep as the particles overlap.
/// `center`: of particle 1. In: xi and N of the particles. False if nothing presses.
bool Evaluation::foundationGeometry(const Contact& contact, const Vector3& center, ContactGeometry& g) const {
  const auto areaOf = [&](std::int32_t slot, const Vector3& N) {
    const std::int32_t o = layout_.ownerOfSlot[slot];
    const Owner& owner = layout_.owners[o];
    return Layout::areaAlong(owner, layout_.rankOfSlot[slot] - owner.firstRank,
                             rotations_[o].transpose() * N);
  };
  const std::int32_t o = layout_.ownerOfSlot[contact.slot1];
  const Owner& owner = layout_.owners[o];
  const bool onSurface = contact.slot2 >= layout_.particleCount;
  const std::int32_t other = layout_.ownerOfSlot[contact.slot2];
  // Bodies that meet both ways, the particles of each on the surface of the other, share the stiffness.
  const bool bothWays = layout_.rules.onSurface(o, other) && layout_.rules.onSurface(other, o);
  const double weight = bothWays ? 0.5 : 1.0;
  if (!onSurface || owner.pieces.empty()) {
    if (!(g.xi > 0.0)) return false;
    const double first = areaOf(contact.slot1, g.N), second = onSurface ? 0.0 : areaOf(contact.slot2, -g.N);
    g.share = onSurface ? weight * first : first * second > 0.0 ? first * second / (first + second) : 0.0;
    g.meanSquareOverlap = g.xi * g.xi;
    return g.share > 0.0;
  }
  const Matrix3& rotation = rotations_[o];
  const std::int32_t local = layout_.rankOfSlot[contact.slot1] - owner.firstRank;
  const double distance = particles_[contact.slot1].radius - g.xi;
  const PressedPatch patch = pressedPatch(owner.piecesOf(local), owner.particles[local].position, distance,
                                          rotation.transpose() * g.N);
  if (!(patch.area > 0.0)) return false;
  g.xi = patch.depth;
  g.share = weight * patch.area;
  g.shareGrowth = patch.areaSlope / patch.area;
  g.meanSquareOverlap = patch.meanSquareDepth;
  const Vector3 point = owners_[o].center + rotation * patch.center;
  g.point = point - (g.N.dot(point - center) - distance) * g.N;
  return true;
}

/// False where the particles do not touch after all: by rounding, or as one overhangs and does not reach.
template <class Normal, class Shear>
bool Evaluation::contactGeometry(const Contact& contact, ContactGeometry& g) const {
  const ParticleRow& a = particles_[contact.slot1];
  const OwnerRow& owner1 = owners_[layout_.ownerOfSlot[contact.slot1]];
  const OwnerRow& owner2 = owners_[layout_.ownerOfSlot[contact.slot2]];
  const Vector3 x1(a.x, a.y, a.z);
  const SurfaceRow* surface =
      contact.slot2 < layout_.particleCount ? nullptr : &surfaces_[contact.slot2 - layout_.particleCount];
  const ExactSphere* ball = surface ? std::get_if<ExactSphere>(surface->shape) : nullptr;
  const bool isRound = !surface || ball;
  Vector3 x2 = Vector3::Zero();
  double distance = 0.0;  // of the centres of two round ones
  if (isRound) {
    double radius2;
    if (ball) {
      x2 = surface->point;
      radius2 = ball->radius;
    } else {
      const ParticleRow& b = particles_[contact.slot2];
      x2 = {b.x, b.y, b.z};
      radius2 = b.radius;
    }
    distance = (x2 - x1).norm();
    g.xi = a.radius + radius2 - distance;                                  // eq. 1
    g.N = distance > 0.0 ? Vector3((x2 - x1) / distance) : kAnyDirection;  // eq. 2
    g.point = x1 + (a.radius - 0.5 * g.xi) * g.N;
  } else {
    const SurfaceDistance near = surface->distance(x1);
    g.xi = a.radius - near.distance;
    g.N = -near.normal;
    g.point = x1 + near.distance * g.N;
    g.share = near.slope;  // the force is the slope of an energy, also where the distance is interpolated
  }
  if constexpr (Normal::kByArea) {
    if (!foundationGeometry(contact, x1, g)) return false;
  } else if (!(g.xi > 0.0)) {
    return false;
  }
  g.V = owner1.velocity + owner1.angularVelocity.cross(g.point - owner1.center) - owner2.velocity -
        owner2.angularVelocity.cross(g.point - owner2.center);  // eq. 3
  if constexpr (Shear::kHasMemory) {
    // The contact's frame turns with its normal, and about it as the two owners do on average.
    const double twist = 0.5 * (owner1.angularVelocity + owner2.angularVelocity).dot(g.N);
    Vector3 swing = isRound ? Vector3(Vector3::Zero()) : owner2.angularVelocity;
    if (distance > 0.0) {
      const Vector3 centers = owner2.velocity + owner2.angularVelocity.cross(x2 - owner2.center) -
                              owner1.velocity - owner1.angularVelocity.cross(x1 - owner1.center);
      swing = g.N.cross(centers) / distance;
    }
    g.turning = swing - swing.dot(g.N) * g.N + twist * g.N;
  }
  return true;
}

/// The force of one contact.
template <class Normal, class Shear>
void Evaluation::forceOf(std::int32_t n, const Moment& at, const double* y, double* rate,
                         Extremes& extremes) {
  const Contact& contact = contacts_[n];
  ContactGeometry g;
  if (!contactGeometry<Normal, Shear>(contact, g)) {
    forces_[n] = {Vector3::Zero(), g.point, 0.0, 0.0};
    if constexpr (Shear::kHasMemory) contactMemory_[n] = {};
    return;
  }
  const PairLaw& law = pairLaw(contact);
  const double xiDot = g.V.dot(g.N);
  Vector3 D = Vector3::Zero();
  ContactMemory* memory = nullptr;
  std::int32_t entry = -1;
  if constexpr (Shear::kHasMemory) {
    memory = &contactMemory_[n];
    entry = memoryOfCandidate_[contact.candidate];
    if (entry >= 0) {
      D = Eigen::Map<const Vector3>(y + stateSize() + 3 * entry);
      g.slides = memory_[entry].slides;
      g.stiffnessBefore = memory_[entry].stiffness;
      g.memoryStep = at.memoryStep;
    } else if (g.isNew = true;
               xiDot > 0.0) {  // begun within this trial: it has slid since its overlap was zero
      D = std::min(g.xi / xiDot, at.sinceTrial) / (1.0 + stiffnessPower<Normal>(law.shear)) *
          (g.V - xiDot * g.N);
    }
  }
  const ContactResult result = contactResult<Normal, Shear>(law.normal, law.shear, g, D, memory);
  if constexpr (Shear::kHasMemory) {
    if (entry >= 0) Eigen::Map<Vector3>(rate + stateSize() + 3 * entry) = memory->rate;
  }
  forces_[n] = {result.force, g.point, result.dissipation, g.xi};
  ++extremes.contacts;
  extremes.pushing += result.normalForce != 0.0;
  extremes.urgency = std::max(extremes.urgency, Normal::urgency(law.normal, g.xi, xiDot));
  extremes.overlap = std::max(extremes.overlap, relativeOverlap(contact, g.xi));
}

/// The forces of up to kPackSize contacts between particles at once, under laws without memory.
template <class Normal, class Shear>
void Evaluation::forcesOfPack(std::span<const std::int32_t> which, Extremes& extremes) {
  ContactRows rows;
  for (int lane = 0; lane < kPackSize; ++lane) {  // lanes to spare do the last contact again
    const Contact& contact = contacts_[which[std::min<std::size_t>(lane, which.size() - 1)]];
    rows.particle1[lane] = &particles_[contact.slot1];
    rows.particle2[lane] = &particles_[contact.slot2];
    rows.owner1[lane] = &owners_[layout_.ownerOfSlot[contact.slot1]];
    rows.owner2[lane] = &owners_[layout_.ownerOfSlot[contact.slot2]];
    rows.law[lane] = &pairLaw(contact);
  }
  const ContactGeometryPack g = geometryOf(rows);
  const NormalConstantsOf<Pack> normal = normalConstantsOf(rows);
  const auto result =
      resultWithoutMemory<Normal, Shear, Pack>(normal, shearConstantsOf(rows), g.xi, g.N, g.V);
  const Pack urgency = Normal::urgency(normal, g.xi, Pack(g.V.dot(g.N)));
  const Pack overlap = g.xi / g.smallerRadius;
  for (int lane = 0; lane < static_cast<int>(which.size()); ++lane) {
    const auto vector = [lane](const Vector3Of<Pack>& v) {
      return Vector3(v.x()[lane], v.y()[lane], v.z()[lane]);
    };
    ContactForce& out = forces_[which[lane]];
    if (!(g.xi[lane] > 0.0)) {  // the test of findContacts and the exact overlap disagree by rounding
      out = {Vector3::Zero(), vector(g.point), 0.0, 0.0};
      continue;
    }
    out = {vector(result.force), vector(g.point), result.dissipation[lane], g.xi[lane]};
    ++extremes.contacts;
    extremes.pushing += result.normalForce[lane] != 0.0;
    extremes.urgency = std::max<double>(extremes.urgency, urgency[lane]);
    extremes.overlap = std::max<double>(extremes.overlap, overlap[lane]);
  }
}

/// Contacts [begin, end), all under these two laws.
template <class Normal, class Shear>
void Evaluation::forcesOfRun(std::int32_t begin, std::int32_t end, const Moment& at, const double* y,
                             double* rate, Extremes& extremes) {
  if constexpr (Shear::kHasMemory || Normal::kByArea) {
    for (std::int32_t n = begin; n < end; ++n) forceOf<Normal, Shear>(n, at, y, rate, extremes);
  } else {
    std::array<std::int32_t, kPackSize> pack;
    std::size_t count = 0;
    for (std::int32_t n = begin; n < end; ++n) {
      if (contacts_[n].slot2 >= layout_.particleCount) {  // on an exact surface
        forceOf<Normal, Shear>(n, at, y, rate, extremes);
        continue;
      }
      pack[count++] = n;
      if (count < pack.size()) continue;
      forcesOfPack<Normal, Shear>(pack, extremes);
      count = 0;
    }
    if (count > 0) forcesOfPack<Normal, Shear>(std::span(pack).first(count), extremes);
  }
}

void Evaluation::computeContactForces(const Moment& at, const std::vector<double>& y,
                                      std::vector<double>& rate) {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::ComputeContactForces)]);
  const auto pieces = static_cast<std::int32_t>(contactsInPiece_.size());
  extremesInPiece_.assign(pieces, {});
  if (hasMemory_) std::fill(rate.begin() + stateSize(), rate.end(), 0.0);
  executor_.forPieces(pieces, [&](std::int32_t piece) {
    std::int32_t begin = list_.rowStart()[piece * kRowsPerPiece];
    const std::int32_t end = begin + contactsInPiece_[piece];
    Extremes extremes;
    while (begin < end) {  // runs of one pair of laws, compiled for just these two
      const PairLaw& law = pairLaw(contacts_[begin]);
      std::int32_t stop = oneKernel_ ? end : begin + 1;
      while (stop < end && pairLaw(contacts_[stop]).sameKernel(law)) ++stop;
      withNormalLaw(law.normalLaw, [&]<class Normal>(Normal) {
        withShearLaw(law.shearLaw, [&]<class Shear>(Shear) {
          forcesOfRun<Normal, Shear>(begin, stop, at, y.data(), rate.data(), extremes);
        });
      });
      begin = stop;
    }
    extremesInPiece_[piece] = extremes;
  });
  summary_.urgency = summary_.largestOverlap = 0.0;
  summary_.contacts = summary_.pushing = 0;
  for (const Extremes& extremes : extremesInPiece_) {
    summary_.urgency = std::max(summary_.urgency, extremes.urgency);
    summary_.largestOverlap = std::max(summary_.largestOverlap, extremes.overlap);
    summary_.contacts += extremes.contacts;
    summary_.pushing += extremes.pushing;
  }
}

double Evaluation::relativeOverlap(const Contact& contact, double overlap) const {
  const double radius1 = particles_[contact.slot1].radius;
  if (contact.slot2 >= layout_.particleCount) return overlap / radius1;
  return overlap / std::min(radius1, particles_[contact.slot2].radius);
}

double Evaluation::elasticEnergy(const Contact& contact, const ContactForce& force) const {
  const PairLaw& law = pairLaw(contact);
  return withNormalLaw(law.normalLaw, [&]<class Normal>(Normal) {
    if constexpr (!Normal::kByArea) return Normal::elasticEnergy(law.normal, force.overlap);
    ContactGeometry g;
    if (!contactGeometry<Normal, RegularisedCoulomb>(contact, g)) return 0.0;
    return g.share * Normal::elasticEnergy(law.normal, std::sqrt(g.meanSquareOverlap));
  });
}

double Evaluation::referenceContactTime() const {
  double shortest = std::numeric_limits<double>::infinity();
  const auto consider = [&](const PairLaw& law) {
    shortest = std::min(shortest, withNormalLaw(law.normalLaw, [&]<class Normal>(Normal) {
                          return contactTimeOfUrgency(Normal::urgency(law.normal, 0.0, 1.0));
                        }));
  };
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(layout_.kinds.size()); ++k) {
    if (layout_.kinds[k].inverseMass > 0.0 && layout_.kinds[k].inverseRadius > 0.0) consider(makeLaw(k, k));
  }
  return shortest;
}

}  // namespace granular::detail
