// SPDX-License-Identifier: MIT
// The stages that find contacts and work out their forces: where two particles meet,
// and runs of contacts through the kernel compiled for their two laws.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <variant>

#include "granular/base/room.h"
#include "granular/contact/law_list.h"
#include "granular/contact/pressed_patch.h"
#include "granular/contact/shear_constants.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

/// Line of centres for two particles in one place: any direction does, as long as it is always the same.
const Vector3 kAnyDirection = Vector3::UnitY();

constexpr std::int32_t kContactsPerChunk = 256;  // whose forces are worked out before they are added
constexpr std::size_t kOpenRuns = 8;

/// [begin, end) behind what is there.
void appendNumbers(std::int32_t begin, std::int32_t end, std::vector<std::int32_t>& to) {
  const std::size_t size = to.size();
  to.resize(size + (end - begin));
  std::iota(to.begin() + size, to.end(), begin);
}

/// All of them, and behind them the last one again, as ContactRun::which has it.
std::span<const std::int32_t> runOf(std::vector<std::int32_t>& which) {
  const std::size_t count = which.size();
  if (count > 0) which.resize(count + kContactsPerPack, which.back());
  return std::span(which).first(count);
}

}  // namespace

/// Candidates of a block that overlap.
void Evaluation::findContacts(std::int32_t block, const ContactArrays& arrays, BlockContacts& found) {
  const std::int32_t begin = blocks_.starts()[block], end = blocks_.starts()[block + 1];
  const CandidateSpan candidates{.row = blocks_.row().data(), .partner = blocks_.partner().data()};
  found.count = 0;
  for (std::int32_t c = begin; c < end;) {
    const std::int32_t before = found.count;
    c = kernels_->findContacts(arrays, candidates, c, end, found.contacts, found.count);
    appendNumbers(before, found.count, found.rounds);
    for (; c < end && blocks_.partner()[c] >= layout_.particleCount; ++c) {
      findSurfaceContact(c, found);
    }
  }
}

/// Of a candidate on an exact surface: where they meet, if they do, is kept beside it.
void Evaluation::findSurfaceContact(std::int32_t candidate, BlockContacts& found) {
  const std::int32_t i = blocks_.row()[candidate], slot = blocks_.partner()[candidate];
  const ParticleRow& a = particles_[i];
  const double reach = a.radius + layout_.overhangOf(layout_.ownerOfSlot[i]);
  const Vector3 center(a.x, a.y, a.z);
  const SurfaceDistance near = surfaces_[slot - layout_.particleCount].distance(center);
  if (!(near.distance < reach)) return;
  // Times the slope: the force is that of an energy, also where the distance is interpolated.
  found.onSurfaces.push_back(found.count);
  found.contacts[found.count++] = {i, slot, candidate, static_cast<std::int32_t>(found.surfaces.size())};
  found.surfaces.push_back(
      {-near.normal, near.slope, center - near.distance * near.normal, a.radius - near.distance});
}

/// What bodies press with. Of a particle against an exact surface: its pieces, where they are below it. Of
/// two particles: the areas they show, as springs one behind the other, as deep as the particles overlap.
/// `center`: of particle 1. In: xi and N of the particles. False if nothing presses.
bool Evaluation::foundationGeometry(const Contact& contact, const Vector3& center, ContactGeometry& g) const {
  const auto areaOf = [&](std::int32_t slot, const Vector3& N) {
    const std::int32_t o = layout_.ownerOfSlot[slot];
    const Owner& owner = layout_.owners[o];
    return Layout::areaAlong(owner, layout_.rankOfSlot[slot] - owner.firstRank,
                             rotationOf(o).transpose() * N);
  };
  const std::int32_t o = layout_.ownerOfSlot[contact.slot1];
  const Owner& owner = layout_.owners[o];
  const bool onSurface = contact.slot2 >= layout_.particleCount;
  const std::int32_t other = layout_.ownerOfSlot[contact.slot2];
  // Bodies that meet both ways, the particles of each on the surface of the other, share the stiffness.
  const bool bothWays = layout_.rules.onSurface(o, other) && layout_.rules.onSurface(other, o);
  const double weight = bothWays ? 0.5 : 1.0;
  if (!onSurface || owner.body->pieces.empty()) {
    if (!(g.xi > 0.0)) return false;
    const double first = areaOf(contact.slot1, g.N), second = onSurface ? 0.0 : areaOf(contact.slot2, -g.N);
    g.share = onSurface ? weight * first : first * second > 0.0 ? first * second / (first + second) : 0.0;
    g.meanSquareOverlap = g.xi * g.xi;
    return g.share > 0.0;
  }
  const Matrix3& rotation = rotationOf(o);
  const std::int32_t local = layout_.rankOfSlot[contact.slot1] - owner.firstRank;
  double distance = particles_[contact.slot1].radius - g.xi;
  Face face;
  const SurfaceRow& surface = surfaces_[contact.slot2 - layout_.particleCount];
  const ExactBox* box = std::get_if<ExactBox>(surface.shape);
  if (box) {  // a box is pressed on one of its faces, as far as that goes
    face = faceOf(*box, surface.rotation.transpose() * (center - surface.point));
    const Matrix3 toPieces = rotation.transpose() * surface.rotation;
    face.center = rotation.transpose() * (surface.point + surface.rotation * face.center - this->center(o));
    face.normal = toPieces * face.normal;
    for (Vector3& along : face.along) along = toPieces * along;
    distance = face.distance(owner.particles[local].position);
    g.N = -(rotation * face.normal);
  }
  const PressedPatch patch = pressedPatch(owner.body->piecesOf(local), owner.particles[local].position,
                                          distance, rotation.transpose() * g.N, box ? &face : nullptr);
  if (!(patch.area > 0.0)) return false;
  g.xi = patch.depth;
  g.share = weight * patch.area;
  g.shareGrowth = patch.areaSlope / patch.area;
  g.meanSquareOverlap = patch.meanSquareDepth;
  const Vector3 point = this->center(o) + rotation * patch.center;
  g.point = point - (g.N.dot(point - center) - distance) * g.N;
  return true;
}

/// Of a contact under a law by area. False where nothing presses after all: by rounding, or as one overhangs
/// and does not reach.
bool Evaluation::contactGeometry(const Contact& contact, ContactGeometry& g) const {
  const ParticleRow& a = particles_[contact.slot1];
  const OwnerRow& owner1 = owners_[layout_.placeOfSlot[contact.slot1]];
  const OwnerRow& owner2 = owners_[layout_.placeOfSlot[contact.slot2]];
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
  }
  if (!foundationGeometry(contact, x1, g)) return false;
  const Vector3 center1 = center(layout_.ownerOfSlot[contact.slot1]);
  const Vector3 center2 = center(layout_.ownerOfSlot[contact.slot2]);
  g.V = owner1.velocity + owner1.angularVelocity.cross(g.point - center1) - owner2.velocity -
        owner2.angularVelocity.cross(g.point - center2);  // eq. 3
  // The contact's frame turns with its normal, and about it as the two owners do on average.
  const double twist = 0.5 * (owner1.angularVelocity + owner2.angularVelocity).dot(g.N);
  Vector3 swing = isRound ? Vector3(Vector3::Zero()) : owner2.angularVelocity;
  if (distance > 0.0) {
    const Vector3 centers = owner2.velocity + owner2.angularVelocity.cross(x2 - center2) - owner1.velocity -
                            owner1.angularVelocity.cross(x1 - center1);
    swing = g.N.cross(centers) / distance;
  }
  g.turning = swing - swing.dot(g.N) * g.N + twist * g.N;
  return true;
}

Vector3 Evaluation::pointOf(const Contact& contact, const ContactForce& force) const {
  const PairRule rule = ruleOf(contact);
  const ParticleRow& a = particles_[contact.slot1];
  const Vector3 x1(a.x, a.y, a.z);
  ContactGeometry g;
  if (withNormalLaw(rule.pair->normalOf(rule.ofBodies).law, []<class Law>(Law) { return Law::kByArea; })) {
    contactGeometry(contact, g);
    return g.point;
  }
  if (contact.slot2 >= layout_.particleCount) {
    const SurfaceDistance near = surfaces_[contact.slot2 - layout_.particleCount].distance(x1);
    return x1 - near.distance * near.normal;
  }
  const ParticleRow& b = particles_[contact.slot2];
  const Vector3 way = Vector3(b.x, b.y, b.z) - x1;
  const double distance = way.norm();
  return x1 + (a.radius - 0.5 * force.overlap) * (distance > 0.0 ? Vector3(way / distance) : kAnyDirection);
}

/// The constants of the normal law for one contact.
template <class Normal>
NormalConstants Evaluation::normalConstants(const Contact& contact, NormalRequest& request) const {
  if constexpr (Normal::kByArea) {
    return pairLaw(contact).normal;
  } else {
    const bool onSurface = contact.slot2 >= layout_.particleCount;
    const double inverseRadius2 = onSurface ? surfaceInverseRadius_[contact.slot2 - layout_.particleCount]
                                            : 1.0 / particles_[contact.slot2].radius;
    const double inverseMass = owners_[layout_.placeOfSlot[contact.slot1]].inverseMass +
                               owners_[layout_.placeOfSlot[contact.slot2]].inverseMass;
    request.contact.mass = inverseMass > 0.0 ? 1.0 / inverseMass : 1.0;
    request.contact.radius = 1.0 / (1.0 / particles_[contact.slot1].radius + inverseRadius2);
    return Normal::template constants<double>(request);
  }
}

/// The force of one contact under a law by area.
template <class Normal, class Shear>
void Evaluation::forceOf(std::int32_t n, const ContactArrays& arrays, const ContactRun& run,
                         Extremes& extremes) {
  const std::int32_t which = run.which[n];
  const Contact& contact = run.contacts[which];
  ContactForce& force = run.forces[n];
  VectorRow& torque = run.torques[n];
  ContactGeometry g;
  if (!contactGeometry(contact, g)) {
    force = {Vector3::Zero(), 0.0, Vector3::Zero(), 0.0};
    torque = {};
    if constexpr (Shear::kHasMemory) run.memory[which] = {};
    return;
  }
  const PairLaw law = pairLaw(contact);
  const double xiDot = g.V.dot(g.N);
  Vector3 D = Vector3::Zero();
  ContactMemory memory;
  std::int32_t entry = -1;
  if constexpr (Shear::kHasMemory) {
    entry = entryOf(contact);
    if (entry >= 0) {
      D = Eigen::Map<const Vector3>(arrays.displacements + 3 * entry);
      g.slides = memory_[entry].slides != 0.0;
      g.stiffnessBefore = memory_[entry].stiffness;
      g.memoryStep = arrays.at.memoryStep;
    } else if (g.isNew = true;
               xiDot > 0.0) {  // begun within this trial: it has slid since its overlap was zero
      D = std::min(g.xi / xiDot, arrays.at.sinceTrial) / (1.0 + stiffnessPower<Normal, double>(law.shear)) *
          (g.V - xiDot * g.N);
    }
  }
  const ContactResult result = contactResult<Normal, Shear>(law.normal, law.shear, g, D, &memory);
  if constexpr (Shear::kHasMemory) {
    run.memory[which] = {.displacement = memory.displacement,
                         .stiffness = memory.stiffness,
                         .loss = memory.loss,
                         .heating = memory.heating,
                         .slides = memory.slides ? 1.0 : 0.0,
                         .touches = 1.0};
    if (arrays.at.memoryRates) run.nextRates[which].vector = memory.nextRate;
    if (entry >= 0 && arrays.at.memoryRates && run.isOwn(contact)) {
      Eigen::Map<Vector3>(arrays.displacementRates + 3 * entry) = memory.rate;
    }
  }
  const auto torqueAbout = [&](std::int32_t slot) {
    return (g.point - center(layout_.ownerOfSlot[slot])).cross(result.force);
  };
  force = {result.force, result.dissipation, torqueAbout(contact.slot2), g.xi};
  torque = {torqueAbout(contact.slot1), result.damping};
  extremes.contacts += run.isOwn(contact);
  extremes.pushing += run.isOwn(contact) && result.normalForce != 0.0;
  extremes.urgency = std::max(extremes.urgency, Normal::urgency(law.normal, g.xi, xiDot));
  extremes.overlap = std::max(extremes.overlap, relativeOverlap(contact, g.xi));
}

/// These contacts, all under this rule: by a kernel where there is one for the laws.
void Evaluation::forcesOfRun(const ContactRun& run, const ContactArrays& arrays, Extremes& extremes) {
  if (run.which.empty()) return;
  const NormalLaw normal = run.pair->normalOf(run.ofBodies).law;
  const ShearLaw shear = run.pair->def.shear.law;
  if (const auto kernel = forceKernels_->forces[static_cast<int>(normal)][static_cast<int>(shear)]) {
    return kernel(arrays, run, extremes);
  }
  withNormalLaw(normal, [&]<class Normal>(Normal) {
    if constexpr (Normal::kByArea) {
      withShearLaw(shear, [&]<class Shear>(Shear) {
        for (std::int32_t n = 0; n < std::ssize(run.which); ++n) {
          forceOf<Normal, Shear>(n, arrays, run, extremes);
        }
      });
    }
  });
}

/// body(run) for some of these contacts of the block, all on surfaces or none, in runs under one rule.
/// Several runs are open at a time, as contacts under different rules lie mixed and a kernel works on many or
/// in vain. which: kContactsPerChunk at most, and behind them as ContactRun has it.
template <class Body>
void Evaluation::forRuns(std::int32_t block, const Contact* contacts, std::span<const std::int32_t> which,
                         bool onSurfaces, Body&& body) const {
  struct Run {
    PairRule rule{};
    std::int32_t count = 0;
    std::array<std::int32_t, kContactsPerChunk> which;
  };
  static_assert(kContactsPerChunk % kContactsPerPack == 0);
  if (which.empty()) return;
  const auto finish = [&](const PairRule& rule, std::span<const std::int32_t> ofRule) {
    body(ContactRun{.pair = rule.pair,
                    .ofBodies = rule.ofBodies,
                    .onSurfaces = onSurfaces,
                    .firstSlot = firstSlotOfBlock_[block],
                    .endSlot = firstSlotOfBlock_[block + 1],
                    .which = ofRule,
                    .contacts = contacts});
  };
  if (isUniform_) return finish(ruleOf(contacts[which[0]]), which);
  std::array<Run, kOpenRuns> runs;
  const auto finishRun = [&](Run& run) {
    const std::int32_t count = std::exchange(run.count, 0);
    for (std::int32_t k = count; k % kContactsPerPack != 0; ++k) run.which[k] = run.which[count - 1];
    finish(run.rule, std::span(run.which).first(count));
  };
  std::size_t open = 0, current = 0, oldest = 0;
  const auto runFor = [&](const PairRule& rule) -> Run& {
    const auto fits = [&](const Run& run) { return run.rule == rule; };
    if (open > 0 && fits(runs[current])) return runs[current];
    current = std::find_if(runs.begin(), runs.begin() + open, fits) - runs.begin();
    if (current < open) return runs[current];
    if (open < kOpenRuns) {
      ++open;
    } else {
      current = oldest++ % kOpenRuns;
      finishRun(runs[current]);
    }
    runs[current].rule = rule;
    return runs[current];
  };
  for (const std::int32_t n : which) {
    Run& run = runFor(ruleOf(contacts[n]));
    run.which[run.count++] = n;
  }
  for (std::size_t k = 0; k < open; ++k) {
    if (runs[k].count > 0) finishRun(runs[k]);
  }
}

/// Forces of some contacts of a block, kContactsPerChunk at most, which are written from force `to` on, and
/// their torques from torque `torquesTo` on.
void Evaluation::computeContactForces(std::int32_t block, std::span<const std::int32_t> which,
                                      bool onSurfaces, std::int32_t to, std::int32_t torquesTo,
                                      const ContactArrays& arrays, BlockContacts& found, Extremes& extremes) {
  forRuns(block, found.contacts, which, onSurfaces, [&](ContactRun run) {
    const auto count = static_cast<std::int32_t>(run.which.size());
    for (std::int32_t k = 0; k < count; ++k) found.position[run.which[k]] = to + k;
    run.surfaces = found.surfaces.data();
    run.memory = found.memory;
    run.nextRates = found.nextRates;
    run.forces = found.forces + to;
    run.torques = found.torques.data() + torquesTo;
    forcesOfRun(run, arrays, extremes);
    to += count;
    torquesTo += count;
  });
}

/// What the laws take from the sizes and masses of all candidates: a list lasts longer than it takes to work
/// that out at every contact.
void Evaluation::updateLawRows() {
  if (lawRowsAreCurrent_) return;
  lawRowsAreCurrent_ = true;
  resizeAnew(lawRows_, blocks_.row().size() * forceKernels_->lawRowSize / sizeof(double));
  const ContactArrays arrays = contactArrays();
  executor_.forPieces(blockCount(), [&](std::int32_t block) {
    std::array<Contact, kContactsPerChunk> candidates;
    std::vector<std::int32_t> which[2];  // of two particles; on surfaces
    const std::int32_t end = blocks_.starts()[block + 1];
    for (std::int32_t c = blocks_.starts()[block]; c < end;) {
      for (std::vector<std::int32_t>& ofKind : which) ofKind.clear();
      for (std::size_t n = 0; c < end && n < candidates.size(); ++n, ++c) {
        candidates[n] = {blocks_.row()[c], blocks_.partner()[c], c};
        which[blocks_.partner()[c] >= layout_.particleCount].push_back(static_cast<std::int32_t>(n));
      }
      for (const bool onSurfaces : {false, true}) {
        const std::span<const std::int32_t> all = runOf(which[onSurfaces]);
        forRuns(block, candidates.data(), all, onSurfaces, [&](const ContactRun& run) {
          const NormalLaw normal = run.pair->normalOf(run.ofBodies).law;
          const ShearLaw shear = run.pair->def.shear.law;
          const auto kernel = forceKernels_->laws[static_cast<int>(normal)][static_cast<int>(shear)];
          if (kernel) kernel(arrays, run);
        });
      }
    }
  });
}

/// The contacts of a block, and what they do to its patches, one after the other; the thread's own until its
/// next block.
const PatchWrench* Evaluation::workOutContacts(std::int32_t block, const ContactArrays& arrays,
                                               PieceClock& clock) {
  thread_local BlockContacts found;
  layOut(block, found);
  findContacts(block, arrays, found);  // candidates -> pairs with overlap > 0                      eq. 1
  layOutForces(block, found);
  clock.done(Stage::FindContacts);
  const std::int32_t firstPatch = layout_.patchOfPlace[firstPlaceOfBlock_[block]];
  const std::int32_t patches = layout_.patchOfPlace[firstPlaceOfBlock_[block + 1]] - firstPatch;
  found.sums.assign(patches + 1, PatchWrench{});
  Extremes extremes;
  const std::span<const std::int32_t> rounds = runOf(found.rounds), onSurfaces = runOf(found.onSurfaces);
  const auto surfaceCount = static_cast<std::int32_t>(onSurfaces.size());
  const auto roundCount = static_cast<std::int32_t>(rounds.size());
  // Those on surfaces are few and lie between the others: all of a block at once, that packs are full.
  for (std::int32_t k = 0; k < surfaceCount; k += kContactsPerChunk) {
    const std::int32_t count = std::min(kContactsPerChunk, surfaceCount - k);
    computeContactForces(block, onSurfaces.subspan(k, count), true, k, k, arrays, found, extremes);
  }
  std::int32_t first = 0;
  for (std::int32_t k = 0; first < found.count; k += kContactsPerChunk) {
    const std::int32_t count = std::min(kContactsPerChunk, roundCount - k);
    const std::int32_t shift = forcesAreKept_ ? k : 0;
    if (count > 0) {
      computeContactForces(block, rounds.subspan(k, count), false, surfaceCount + shift, surfaceCount, arrays,
                           found, extremes);  // eqs. 2-19
    }
    clock.done(Stage::ComputeContactForces);
    const std::int32_t end = k + count < roundCount ? rounds[k + count] : found.count;
    const ContactChunk chunk{.count = end - first,
                             .contacts = found.contacts + first,
                             .position = found.position + first,
                             .forces = found.forces,
                             .torques = found.torques.data(),
                             .surfaceCount = surfaceCount,
                             .shift = shift};
    kernels_->addWrenches(arrays, chunk, firstPatch, patches, found.sums.data());
    clock.done(Stage::SumWrenches);
    if (contactsAreMeasured_) measureContactsOf(block, chunk);
    first = end;
  }
  extremesInBlock_[block] = extremes;
  if (contactsAreKept_) foundInBlock_[block] = found.count;
  if (forcesAreKept_) {
    for (std::int32_t n = 0; n < found.count; ++n) found.position[n] += firstKept(block);
  }
  return found.sums.data();
}

void Evaluation::makeRoomForContacts() {
  const auto most = static_cast<std::size_t>(firstKept(blockCount()));
  if (contacts_.size() != most) resizeAnew(contacts_, most);
  if (forcesAreKept_ && forces_.size() != most) {
    resizeAnew(positions_, most);
    resizeAnew(forces_, most);
  }
  if (hasMemory_ && contactMemory_.size() != most) resizeAnew(contactMemory_, most);
  if (memoryHasRates_ && nextRates_.size() != most) resizeAnew(nextRates_, most);
  foundInBlock_.resize(blockCount());
}

/// Room for what may be found in a block; kernels write up to a pack more than there is.
void Evaluation::layOut(std::int32_t block, BlockContacts& found) {
  found.count = 0;
  found.surfaces.clear();
  found.rounds.clear();
  found.onSurfaces.clear();
  const std::int32_t firstOfBlock = firstKept(block);
  const auto most =
      static_cast<std::size_t>(blocks_.starts()[block + 1] - blocks_.starts()[block] + kContactsPerPack);
  if (contactsAreKept_) {
    found.contacts = contacts_.data() + firstOfBlock;
    if (hasMemory_) {
      found.memory = contactMemory_.data() + firstOfBlock;
      found.nextRates = memoryHasRates_ ? nextRates_.data() + firstOfBlock : nullptr;
    }
  } else {
    if (found.ownContacts.size() < most) found.ownContacts.resize(most);
    found.contacts = found.ownContacts.data();
  }
  if (forcesAreKept_) {
    found.position = positions_.data() + firstOfBlock;
  } else {
    if (found.ownPositions.size() < most) found.ownPositions.resize(most);
    found.position = found.ownPositions.data();
  }
}

/// Room for what the contacts found do.
void Evaluation::layOutForces(std::int32_t block, BlockContacts& found) {
  const std::size_t most = found.surfaces.size() + kContactsPerChunk + kContactsPerPack;
  if (found.torques.size() < most) found.torques.resize(most);
  if (forcesAreKept_) {
    found.forces = forces_.data() + firstKept(block);
  } else {
    if (found.ownForces.size() < most) found.ownForces.resize(most);
    found.forces = found.ownForces.data();
  }
}

/// Which kept contacts are those of the block's own rows.
void Evaluation::listContactsOf(std::int32_t block) {
  std::fill(contactsOfRow_.begin() + firstSlotOfBlock_[block],
            contactsOfRow_.begin() + firstSlotOfBlock_[block + 1], ContactRange{0, 0});
  const std::int32_t first = firstKept(block), end = first + foundInBlock_[block];
  for (std::int32_t n = first; n < end; ++n) {
    if (!isOwn(block, contacts_[n])) continue;
    ContactRange& range = contactsOfRow_[contacts_[n].slot1];
    if (range.first == range.last) range.first = n;
    range.last = n + 1;
  }
}

/// Adds contacts of the block's own rows to their totals.
void Evaluation::measureContactsOf(std::int32_t block, const ContactChunk& chunk) {
  for (std::int32_t n = 0; n < chunk.count; ++n) {
    const Contact& contact = chunk.contacts[n];
    const ContactForce& force = chunk.forces[chunk.position[n]];
    if (!isOwn(block, contact) || !(force.overlap > 0.0)) continue;
    ContactTotals& totals = contactTotals_[layout_.rankOfSlot[contact.slot1]];
    totals.elastic += elasticEnergy(contact, force);
    totals.overlap += relativeOverlap(contact, force.overlap);
  }
}

void Evaluation::sumUpExtremes() {
  summary_.urgency = summary_.largestOverlap = 0.0;
  summary_.contacts = summary_.pushing = 0;
  for (const Extremes& extremes : extremesInBlock_) {
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
  const PairRule rule = ruleOf(contact);
  NormalRequest request = requestOf<double>(*rule.pair, rule.ofBodies);
  return withNormalLaw(request.def.law, [&]<class Normal>(Normal) {
    const NormalConstants constants = normalConstants<Normal>(contact, request);
    if constexpr (!Normal::kByArea) return Normal::elasticEnergy(constants, force.overlap);
    ContactGeometry g;
    if (!contactGeometry(contact, g)) return 0.0;
    return g.share * Normal::elasticEnergy(constants, std::sqrt(g.meanSquareOverlap));
  });
}

}  // namespace granular::detail
