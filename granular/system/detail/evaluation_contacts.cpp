// SPDX-License-Identifier: MIT
// The stages that find contacts and work out their forces: where two particles meet,
// and runs of contacts through the kernel compiled for their two laws.
#include <algorithm>
#include <cmath>
#include <variant>

#include "granular/contact/law_list.h"
#include "granular/contact/pressed_patch.h"
#include "granular/contact/shear_constants.h"
#include "granular/system/detail/evaluation.h"
#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

/// Line of centres for two particles in one place: any direction does, as long as it is always the same.
const Vector3 kAnyDirection = Vector3::UnitY();

constexpr std::int32_t kContactsPerRun = 256;  // handed to a kernel at a time, at most
constexpr std::size_t kOpenRuns = 8;

}  // namespace

/// Candidates of a piece of rows that overlap.
void Evaluation::findContacts(std::int32_t piece, const ContactArrays& arrays) {
  const std::int32_t begin = piece * kRowsPerPiece;
  const std::int32_t end = std::min(layout_.dynamicParticles, begin + kRowsPerPiece);
  std::int32_t n = list_.rowStart()[begin];
  for (std::int32_t row = begin; row < end;) {
    row = kernels_->findContacts(arrays, row, end, n);
    n = findSurfaceContacts(row - 1, n);
  }
  contactsInPiece_[piece] = n - list_.rowStart()[begin];
}

/// Contacts of slot i on exact surfaces, numbered from n on: where they meet is left in the rows of their
/// forces. Returns the number behind them.
std::int32_t Evaluation::findSurfaceContacts(std::int32_t i, std::int32_t n) {
  const std::int32_t* partner = list_.partner().data();
  const std::int32_t end = list_.rowStart()[i + 1];
  std::int32_t c = end;  // they come last in a row
  while (c > list_.rowStart()[i] && partner[c - 1] >= layout_.particleCount) --c;
  for (; c < end; ++c) {
    const ParticleRow& a = particles_[i];
    const double reach = a.radius + layout_.overhangOf(layout_.ownerOfSlot[i]);
    const SurfaceRow& surface = surfaces_[partner[c] - layout_.particleCount];
    const Vector3 center(a.x, a.y, a.z);
    const SurfaceDistance near = surface.distance(center);
    const bool touches = near.distance < reach;
    contactOfCandidate_[c] = touches ? n : -1;
    if (!touches) continue;
    // Times the slope: the force is that of an energy, also where the distance is interpolated.
    forces_[n] = surfaceMeeting(-near.normal, near.slope, center - near.distance * near.normal,
                                a.radius - near.distance);
    contacts_[n++] = {i, partner[c], c};
  }
  contactsOfRow_[i].last = n;
  return n;
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
void Evaluation::forceOf(std::int32_t n, const ContactArrays& arrays, Extremes& extremes) {
  const Contact& contact = contacts_[n];
  ContactGeometry g;
  if (!contactGeometry(contact, g)) {
    forces_[n] = {Vector3::Zero(), 0.0, g.point, 0.0};
    if constexpr (Shear::kHasMemory) contactMemory_[n] = {};
    return;
  }
  const PairLaw law = pairLaw(contact);
  const double xiDot = g.V.dot(g.N);
  Vector3 D = Vector3::Zero();
  ContactMemory memory;
  std::int32_t entry = -1;
  if constexpr (Shear::kHasMemory) {
    entry = memoryOfCandidate_[contact.candidate];
    if (entry >= 0) {
      D = Eigen::Map<const Vector3>(arrays.displacements + 3 * entry);
      g.slides = memory_[entry].slides;
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
    contactMemory_[n] = {.displacement = memory.displacement,
                         .stiffness = memory.stiffness,
                         .nextRate = memory.nextRate,
                         .loss = memory.loss,
                         .heating = memory.heating,
                         .slides = memory.slides,
                         .touches = true};
    if (entry >= 0 && arrays.at.poseRates) {
      Eigen::Map<Vector3>(arrays.displacementRates + 3 * entry) = memory.rate;
    }
  }
  forces_[n] = {result.force, result.dissipation, g.point, g.xi};
  ++extremes.contacts;
  extremes.pushing += result.normalForce != 0.0;
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
        for (const std::int32_t n : run.which) forceOf<Normal, Shear>(n, arrays, extremes);
      });
    }
  });
}

/// What the laws want to know of the contacts of a piece of rows, side by side; the thread's own until its
/// next piece.
const MeetingRow* Evaluation::gatherMeetings(std::int32_t piece, const ContactArrays& arrays) {
  thread_local std::vector<MeetingRow> meetings;
  const std::size_t most = MeetingRow::kMost * static_cast<std::size_t>(contactsInPiece_[piece]);
  if (meetings.size() < most) meetings.resize(most);
  const std::int32_t begin = piece * kRowsPerPiece;
  forceKernels_->gather(arrays, begin, std::min(layout_.dynamicParticles, begin + kRowsPerPiece),
                        meetings.data());
  return meetings.data();
}

/// Forces of the contacts of a piece of rows, in runs under one rule; on surfaces in runs of their own.
/// Several runs are open at a time, as contacts under different rules lie mixed and a kernel works on many or
/// in vain.
void Evaluation::computeContactForces(std::int32_t piece, const ContactArrays& arrays) {
  struct Run {
    PairRule rule{};
    bool onSurfaces = false;
    std::int32_t count = 0;
    std::array<std::int32_t, kContactsPerRun> which;
  };
  static_assert(kContactsPerRun % kContactsPerPack == 0);
  const MeetingRow* meetings = gatherMeetings(piece, arrays);
  const ContactRange range = contactsOfPiece(piece);
  Extremes& extremes = extremesInPiece_[piece];
  extremes = {};
  std::array<Run, kOpenRuns> runs;
  const auto finish = [&](Run& run) {
    for (std::int32_t k = run.count; k % kContactsPerPack != 0; ++k) run.which[k] = run.which[run.count - 1];
    forcesOfRun({.pair = run.rule.pair,
                 .ofBodies = run.rule.ofBodies,
                 .onSurfaces = run.onSurfaces,
                 .which = std::span(run.which).first(run.count),
                 .meetings = meetings,
                 .firstMeeting = range.first},
                arrays, extremes);
    run.count = 0;
  };
  std::size_t open = 0, current = 0, oldest = 0;
  const auto runFor = [&](const PairRule& rule, bool onSurfaces) -> Run& {
    const auto fits = [&](const Run& run) { return run.onSurfaces == onSurfaces && run.rule == rule; };
    if (open > 0 && fits(runs[current])) return runs[current];
    current = std::find_if(runs.begin(), runs.begin() + open, fits) - runs.begin();
    if (current < open) return runs[current];
    if (open < kOpenRuns) {
      ++open;
    } else {
      current = oldest++ % kOpenRuns;
      finish(runs[current]);
    }
    runs[current].rule = rule;
    runs[current].onSurfaces = onSurfaces;
    return runs[current];
  };
  if (isUniform_ && range.first < range.last) {
    const PairRule rule = ruleOf(contacts_[range.first]);
    Run &round = runFor(rule, false), &onSurfaces = runFor(rule, true);
    for (std::int32_t n = range.first; n < range.last;) {
      const std::int32_t begin = n, end = std::min(range.last, n + kContactsPerRun);
      std::int32_t count = 0;
      for (; n < end; ++n) {  // written to both, counted for one
        const bool isRound = contacts_[n].slot2 < layout_.particleCount;
        round.which[count] = onSurfaces.which[n - begin - count] = n;
        count += isRound;
      }
      round.count = count;
      onSurfaces.count = end - begin - count;
      finish(round);
      finish(onSurfaces);
    }
    return;
  }
  for (std::int32_t n = range.first; n < range.last; ++n) {
    Run& run = runFor(ruleOf(contacts_[n]), contacts_[n].slot2 >= layout_.particleCount);
    run.which[run.count++] = n;
    if (run.count == kContactsPerRun) finish(run);
  }
  for (std::size_t k = 0; k < open; ++k) finish(runs[k]);
}

void Evaluation::sumUpExtremes() {
  summary_.urgency = summary_.largestOverlap = 0.0;
  summary_.contacts = summary_.pushing = 0;
  for (const Extremes& extremes : extremesInPiece_) {
    summary_.urgency = std::max(summary_.urgency, extremes.urgency);
    summary_.largestOverlap = std::max(summary_.largestOverlap, extremes.overlap);
    summary_.contacts += extremes.contacts;
    summary_.pushing += extremes.pushing;
  }
}

/// By pieces of rows, so that what one stage leaves is near when the next one wants it.
void Evaluation::workOutContacts(const ContactArrays& arrays, const std::vector<double>& y,
                                 std::vector<double>& rate) {
  if (hasMemory_ && arrays.at.poseRates)
    std::fill(rate.begin() + (stateSize() - lackingOf(rate, y)), rate.end(), 0.0);
  const std::int32_t rows = layout_.dynamicParticles;
  const std::int32_t pieces = Executor::pieceCount(rows, kRowsPerPiece);
  contactsInPiece_.resize(pieces);
  extremesInPiece_.resize(pieces);
  forTimedPieces(pieces, [&](std::int32_t piece, PieceClock& clock) {
    findContacts(piece, arrays);  // candidates -> pairs with overlap > 0                  eq. 1
    clock.done(Stage::FindContacts);
    computeContactForces(piece, arrays);  // the laws                                       eqs. 2-19
    clock.done(Stage::ComputeContactForces);
  });
  sumUpExtremes();
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
