// SPDX-License-Identifier: MIT
// One evaluation: from a state to the rate of the state (Bell 2005, secs. 2 and 3), as a list of stages. A
// pure function of the state: what it keeps between calls (hash, candidate list, buffers) may change its
// speed only.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/contact/contact_kernel.h"
#include "granular/contact/pair_law.h"
#include "granular/dynamics/equations.h"
#include "granular/dynamics/integrator.h"
#include "granular/search/candidate_blocks.h"
#include "granular/search/candidate_list.h"
#include "granular/system/detail/contact_kernels.h"
#include "granular/system/detail/contact_rows.h"
#include "granular/system/detail/layout.h"
#include "granular/system/detail/stage_tools.h"
#include "granular/system/step_report.h"

namespace granular::detail {

/// Things outside the state that move or push: constant during a step.
struct Surroundings {
  Vector3 gravity = Vector3::Zero();
  std::vector<Vector3> bodyGravity;    ///< [dynamic body]
  std::vector<Wrench> bodyLoad;        ///< [dynamic body]
  std::vector<RigidMotion> kinematic;  ///< [kinematic body], at time 0 of the step
  std::vector<RigidMotion> fixed;      ///< [static body]
  std::vector<Pose> asleep;            ///< [sleeper]: constant while the layout is
};

/// What step control wants to know of an evaluation.
struct EvaluationSummary {
  std::int64_t contacts = 0;
  std::int64_t pushing = 0;     ///< contacts whose normal force is not zero
  double largestOverlap = 0.0;  ///< in smaller radii of the pair
  double urgency = 0.0;         ///< largest PairLaw::urgency; 0 without contacts
  double largestSpeed = 0.0;    ///< of any point of any moving owner, at most, m/s
};

/// Sums over the contacts in the row of a particle.
struct ContactTotals {
  double elastic = 0.0;  ///< energy of normal springs, J
  double overlap = 0.0;  ///< in smaller radii of the pairs
};

/// Contacts that were found in a block, those in rows of other blocks among them, and what a thread needs to
/// work on them. Where they are kept, contacts and memory, and positions and forces, lie with the block, else
/// in the thread's own room: positions and forces of a chunk only.
struct BlockContacts {
  std::int32_t count = 0;
  Contact* contacts = nullptr;
  std::int32_t* position = nullptr;  ///< of a contact's force
  ContactForce* forces = nullptr;
  SettledMemory* memory = nullptr;  ///< where some remember
  VectorRow* nextRates = nullptr;   ///< the same, with Moment::memoryRates
  std::vector<Contact> ownContacts;
  std::vector<std::int32_t> ownPositions;
  std::vector<ContactForce> ownForces;
  /// Of contacts on surfaces, then of the chunk at hand.
  std::vector<VectorRow> torques;
  std::vector<std::int32_t> rounds, onSurfaces;  ///< which contacts are of two particles, which on surfaces
  std::vector<SurfaceMeeting> surfaces;          ///< of those on surfaces
  std::vector<PatchWrench> sums;                 ///< by patch, and one more
};

class Evaluation {
 public:
  Evaluation(int threads, HostExecutor* host)
      : executor_(threads, host), kernels_(&contactKernels()), forceKernels_(kernels_->forces) {}

  /// What forces are worked out in from the next evaluation on.
  void usePrecision(ContactPrecision precision) {
    forceKernels_ = precision == ContactPrecision::Mixed ? kernels_->mixedForces : kernels_->forces;
    lawRowsAreCurrent_ = false;
  }

  /// Takes a new layout. Everything kept is thrown away.
  void reset(const std::vector<MaterialPair>& materialPairs, const std::vector<MaterialDef>& materials);
  /// Static bodies stand elsewhere than before, or sleepers are new.
  void placeFixed();

  Layout& layout() { return layout_; }
  const Layout& layout() const { return layout_; }
  Surroundings& surroundings() { return surroundings_; }
  const Surroundings& surroundings() const { return surroundings_; }
  const Executor& executor() const { return executor_; }
  const ContactKernels& kernels() const { return *kernels_; }

  /// Without the memory of contacts, which comes last.
  std::size_t stateSize() const {
    return layout_.dynamicCount() * state::kSize + layout_.movingBodies() * state::kTallySize + 1;
  }
  std::size_t heatAt() const { return stateSize() - 1; }
  std::size_t tallyAt(std::int32_t movingBody) const {
    return layout_.dynamicCount() * state::kSize + movingBody * state::kTallySize;
  }

  /// The rate of y. A contact without memory is taken to have begun at most `sinceTrial` ago, its
  /// displacement to have grown since then; the displacements of others are moved on by `memoryStep` before
  /// they pull.
  void evaluate(const Moment& at, const std::vector<double>& y, std::vector<double>& rate);

  /// Whether owners have moved so far from where their rows lie that a new order pays.
  bool isSortDue() const;
  /// Places of dynamic owners follow the cells that the state y says. Returns, for every place, which one its
  /// owner had before: y and what goes with it lie in that order still.
  std::vector<std::int32_t> sortPlaces(const std::vector<double>& y);

  /// After the first evaluation of an accepted state: contacts that began are remembered from now on, those
  /// that ended are forgotten, springs give way to the Coulomb limit. Grows or shrinks y and its rate.
  /// Nothing without laws 17, 19.
  void settleMemory(std::vector<double>& y, std::vector<double>& rate);
  /// Whether there are springs of friction (eqs. 17 and 19).
  bool hasSprings() const { return hasMemory_; }
  /// Energy in them at the last accepted state, J.
  double memoryEnergy();
  /// Carries memory from one layout to the next; contacts of owners that are gone are forgotten.
  std::vector<RememberedContact> exportMemory(const std::vector<double>& y) const;
  void importMemory(const std::vector<RememberedContact>& memory, std::vector<double>& y);

  /// Time over which an error of velocity counts as one of position: the shortest contact time at 1 m/s, s.
  double referenceContactTime() const;

  /// Largest rate at which viscosities and dashpots that the user gave may damp sliding, 1/s, in the contacts
  /// of the last evaluation; 0 where none was given. No mode is damped faster: of C, the damping of all
  /// contacts, and M, the masses and moments of inertia of all owners, it is a bound on the eigenvalues of
  /// M^-1 C (Gershgorin), exact where one contact damps. Contacts between bodies, whose constants belong to
  /// all of a face, are left out.
  double shearRate(const std::vector<double>& y);

  /// How fast contacts without memory damp the motion of the dynamic owner in this place against what it
  /// touches, 1/s, at the last evaluation. As if in every direction at once: an estimate from above, by and
  /// large.
  double dampingRate(std::int32_t place) const { return dampingRates_[place] * leverage(place); }

  // Where things were at the last evaluation: also those that do not move.
  Vector3 center(std::int32_t owner) const {
    const ParticleRow& ball = ballAt(layout_.placeOfOwner[owner]);
    return {ball.x, ball.y, ball.z};
  }
  const Matrix3& rotation(std::int32_t body) const { return rotationOf(body); }
  /// Rows of particles by place, where all that moves are single spheres.
  const ParticleRow* spheres() const { return particles_.data(); }
  /// Farthest particle surface from the centre of the owner in this place, m.
  double reachAt(std::int32_t place) const { return ballAt(place).radius; }
  std::span<const ParticleRow> particlesOf(const Owner& owner) const {
    return std::span(particles_).subspan(owner.firstSlot, owner.particles.size());
  }
  std::span<const SurfaceRow> surfaces() const { return surfaces_; }
  /// Who touches whom, and what of it is remembered at the accepted state y. Returns whether anything is.
  bool describe(const Contact& contact, const std::vector<double>& y, RememberedContact& description) const;

  /// Whether the evaluations that follow keep their contacts and what they do.
  void keepContacts(bool keep) { keepsContacts_ = keep; }
  /// Whether the evaluations that follow measure their contacts.
  void measureContacts(bool measure) { measuresContacts_ = measure; }
  /// Of the contacts of the last evaluation, by rank of particle 1: works them out once more where they were
  /// not measured. y: the state it was of; where contacts remember, settled.
  std::span<const ContactTotals> contactTotals(const std::vector<double>& y);
  /// Contacts of the last evaluation are there: works them out once more where they were not kept. For all
  /// that reads contacts. y: as above.
  void listContacts(const std::vector<double>& y);

  // What the last evaluation found.
  const EvaluationSummary& summary() const { return summary_; }
  std::int64_t candidateCount() const { return list_.size(); }
  double relativeOverlap(const Contact& contact, double overlap) const;  ///< in smaller radii of the pair
  double elasticEnergy(const Contact& contact, const ContactForce& force) const;  ///< of the normal spring, J
  Vector3 pointOf(const Contact& contact, const ContactForce& force) const;       ///< where it acts, m, world
  /// body(contact, its force) for every contact, by rank of particle 1, then of particle 2.
  template <class Body>
  void forEachContact(Body&& body) const {
    forContactsOf(0, layout_.dynamicParticles, body);
  }
  /// The same for particles 1 of ranks [begin, end).
  template <class Body>
  void forContactsOf(std::int32_t begin, std::int32_t end, Body&& body) const;

  // Counts and wall times since they were last cleared.
  std::int64_t evaluations = 0;
  std::int64_t listRebuilds = 0;
  StageSeconds stageSeconds{};

 private:
  void placeParticles(double t, const std::vector<double>& y);
  void updateCandidates();
  void workOnBlocks(const ContactArrays& arrays, const std::vector<double>& y, std::vector<double>& rate);
  const PatchWrench* workOutContacts(std::int32_t block, const ContactArrays& arrays, PieceClock& clock);
  void findContacts(std::int32_t block, const ContactArrays& arrays, BlockContacts& found);
  void findSurfaceContact(std::int32_t candidate, BlockContacts& found);
  void computeContactForces(std::int32_t block, std::span<const std::int32_t> which, bool onSurfaces,
                            std::int32_t to, std::int32_t torquesTo, const ContactArrays& arrays,
                            BlockContacts& found, Extremes& extremes);
  void makeRoomForContacts();
  void layOut(std::int32_t block, BlockContacts& found);
  void layOutForces(std::int32_t block, BlockContacts& found);
  void listContactsOf(std::int32_t block);
  void measureContactsOf(std::int32_t block, const ContactChunk& chunk);
  void workOutAgain(const std::vector<double>& y);
  bool isOwn(std::int32_t block, const Contact& contact) const {
    return contact.slot1 >= firstSlotOfBlock_[block] && contact.slot1 < firstSlotOfBlock_[block + 1];
  }
  void sumUpExtremes();
  void computeAccelerations(std::int32_t begin, std::int32_t end, const PatchWrench* wrench,
                            const std::vector<double>& y, bool poseRates, std::vector<double>& rate);
  /// Runs body(piece, clock) for every piece; what the clocks say is shared out to the stages.
  template <class Body>
  void forTimedPieces(std::int32_t pieces, Body&& body);

  void layRows();
  void layBlocks();
  void placeOwner(std::int32_t o, const Vector3& position, const Quaternion& orientation);
  double placeMoving(std::int32_t place, double t, const std::vector<double>& y);
  void accelerate(std::int32_t place, const PatchWrench& contact, const std::vector<double>& y,
                  bool poseRates, std::vector<double>& rate) const;
  double leverage(std::int32_t place) const;
  void tally(std::int32_t body, const PatchWrench& contact, double* to) const;
  void adaptMargin();
  void rebuildCandidates();
  ContactArrays contactArrays();
  std::int32_t blockCount() const { return static_cast<std::int32_t>(firstPlaceOfBlock_.size()) - 1; }
  void makePairLaws();
  /// Where an owner's row is.
  const Matrix3& rotationOf(std::int32_t body) const { return rotations_[body - layout_.dynamicGrains]; }
  OwnerRow& rowOf(std::int32_t o) { return owners_[layout_.placeOfOwner[o]]; }
  const OwnerRow& rowOf(std::int32_t o) const { return owners_[layout_.placeOfOwner[o]]; }
  /// Single spheres are their own ball.
  const ParticleRow& ballAt(std::int32_t place) const {
    const std::int32_t first = layout_.firstBall();
    return place < first ? particles_[layout_.slotOfPlace[place]] : balls_[place - first];
  }
  /// How fast any point of the owner in this place may be, at most, m/s.
  double fastestPoint(std::int32_t place) const {
    const OwnerRow& row = owners_[place];
    return row.velocity.norm() + row.angularVelocity.norm() * ballAt(place).radius;
  }
  PairLaw pairLaw(const Contact& contact) const;
  double givenDamping(const Contact& contact) const;
  PairLaw makeLaw(const ParticleKind& a, const ParticleKind& b) const;
  void noteLaws();
  void placeSurface(std::int32_t s);
  double surfaceMove(std::int32_t s) const;
  void chooseMargins();
  void rememberList();
  void rememberEntry(std::int32_t m);
  bool remembers(const Contact& contact) const;
  template <class Body>
  void forRemembered(std::int32_t block, Body&& body) const;
  void settleBlock(std::int32_t block, std::vector<double>& y, std::vector<double>& rate);

  /// Whether contact n is one: findContacts may also offer pairs that turn out to be apart.
  bool touches(std::int32_t n) const { return forceOf(n).overlap > 0.0; }
  const ContactForce& forceOf(std::int32_t n) const { return forces_[positions_[n]]; }
  /// Of Evaluation's memory; -1: none.
  std::int32_t entryOf(const Contact& contact) const {
    return memoryOfCandidate_[blocks_.index()[contact.candidate]];
  }
  /// Where contacts of a block are kept: with room to write more than there are.
  std::int32_t firstKept(std::int32_t block) const {
    return blocks_.starts()[block] + block * kContactsPerPack;
  }

  template <class Normal, class Shear>
  void forceOf(std::int32_t n, const ContactArrays& arrays, const ContactRun& run, Extremes& extremes);
  template <class Normal>
  NormalConstants normalConstants(const Contact& contact, NormalRequest& request) const;
  /// What decides the constants of a contact beside sizes and masses.
  struct PairRule {
    const MaterialPair* pair;
    bool ofBodies;
    friend bool operator==(const PairRule&, const PairRule&) = default;
  };
  PairRule ruleOf(const Contact& contact) const;
  PairRule ruleBetween(std::int32_t material1, std::int32_t material2, bool ofBodies) const;
  template <class Body>
  void forRuns(std::int32_t block, const Contact* contacts, std::span<const std::int32_t> which,
               bool onSurfaces, Body&& body) const;
  void updateLawRows();
  void forcesOfRun(const ContactRun& run, const ContactArrays& arrays, Extremes& extremes);
  bool contactGeometry(const Contact& contact, ContactGeometry& geometry) const;
  RememberedContact endsOf(std::int32_t rank1, std::int32_t rank2) const;
  RememberedContact remembered(std::int32_t m, const std::vector<double>& y) const;
  bool foundationGeometry(const Contact& contact, const Vector3& center, ContactGeometry& geometry) const;

  Layout layout_;
  Surroundings surroundings_;
  Executor executor_;
  const ContactKernels* kernels_;
  const ForceKernels* forceKernels_;
  std::vector<MaterialPair> materialPairs_;
  std::vector<MaterialDef> materials_;

  std::vector<OwnerRow> owners_;    // by place
  std::vector<ParticleRow> balls_;  // about centres, holding the owners; by place from firstBall() on
  std::vector<Matrix3> rotations_;  // of bodies; body owner o is at o - layout_.dynamicGrains
  std::vector<ParticleRow> particles_;
  std::vector<ListedRow> listedParticles_;  // of those that move
  std::vector<SurfaceRow> surfaces_, listedSurfaces_;
  std::vector<double> surfaceInverseRadius_;      // 1/m; 0: no sphere, counts as flat
  std::vector<double> margins_, surfaceMargins_;  // as in SearchInput
  double listedExtent_ = 0.0;                     // of all dynamic particles when the list was made, m
  CandidateList list_;
  CandidateBlocks blocks_;
  // Blocks are of owners in consecutive places; one entry more than blocks. Slots: of dynamic owners.
  std::vector<std::int32_t> firstPlaceOfBlock_, firstSlotOfBlock_, blockOfPatch_;
  bool listIsCurrent_ = false;
  std::int64_t rebuildsSinceSort_ = 0;
  std::int64_t evaluationsAtRebuild_ = 0;
  bool listIsOld_ = false;
  double margin_ = 0.15;  // mean of margins_, in smallest radii; it adapts

  std::vector<PairLaw> pairLaws_;  // of any two kinds; none where there are many: made where one is asked for
  std::vector<double> lawRows_;    // by candidate of blocks_, as ContactArrays::lawRows
  bool lawRowsAreCurrent_ = false;
  bool isUniform_ = false;  // all grains, all of one material: one rule
  bool hasMemory_ = false;  // some pair remembers: otherwise nothing is stored for it

  // Contacts that are kept, as each block found them, those in rows of other blocks among them.
  bool keepsContacts_ = false;
  // Of the last evaluation: who touches and what is remembered of it; what they do; where they are of a row.
  bool contactsAreKept_ = false, forcesAreKept_ = false, contactsAreListed_ = false;
  std::vector<Contact> contacts_;
  std::vector<std::int32_t> positions_;  // of a contact's force
  std::vector<ContactForce> forces_;
  std::vector<SettledMemory> contactMemory_;
  std::vector<VectorRow> nextRates_;
  bool memoryHasRates_ = false;  // the last evaluation worked them out
  std::vector<std::int32_t> foundInBlock_;
  bool measuresContacts_ = false, contactsAreMeasured_ = false;
  std::vector<ContactTotals> contactTotals_;  // by rank
  std::vector<ContactRange> contactsOfRow_;   // by slot of particle 1; once they are listed
  std::vector<Extremes> extremesInBlock_;
  std::vector<StageSeconds> secondsInPiece_;

  std::vector<MemoryEntry> memory_;           // as contacts lie; entry m is at stateSize() + 3 m of y
  std::vector<MemoryEntry> memoryBefore_;     // of the sub-step before
  std::vector<std::uint8_t> livesOn_;         // of those
  std::vector<std::int32_t> entriesInBlock_;  // of memory_, before each block
  struct Settled {
    double heat = 0.0, heating = 0.0;  // J, W: as ContactMemory's loss and heating
  };
  std::vector<Settled> sumOfRank_;  // summed by rank, in which no re-sorting changes anything
  std::vector<std::int32_t> memoryOfCandidate_, memoryOfCandidateBefore_;  // -1: none
  std::vector<double> pieceMaximum_, pieceMaximum2_;
  bool isDampingGiven_ = false;         // of sliding, by the user, between any two materials that are there
  std::vector<double> dampingOfOwner_;  // 1/s: as shearRate()
  std::vector<double> dampingRates_;    // [place of a dynamic owner] 1/s: as dampingRate(), of a sphere
  std::vector<double> heatOfOwner_;     // W, of the contacts in the rows of an owner's particles
  EvaluationSummary summary_;
};

template <class Body>
void Evaluation::forTimedPieces(std::int32_t pieces, Body&& body) {
  double wall = 0.0;
  {
    const StageTimer timer(wall);
    secondsInPiece_.assign(pieces, {});
    executor_.forPieces(pieces, [&](std::int32_t piece) {
      PieceClock clock(secondsInPiece_[piece]);
      body(piece, clock);
    });
  }
  StageSeconds sum{};
  double all = 0.0;
  for (const StageSeconds& seconds : secondsInPiece_) {
    for (int s = 0; s < kStageCount; ++s) {
      sum[s] += seconds[s];
      all += seconds[s];
    }
  }
  for (int s = 0; s < kStageCount && all > 0.0; ++s) stageSeconds[s] += sum[s] * (wall / all);
}

template <class Body>
void Evaluation::forContactsOf(std::int32_t begin, std::int32_t end, Body&& body) const {
  for (std::int32_t rank = begin; rank < end; ++rank) {
    const ContactRange range = contactsOfRow_[layout_.slotOfRank[rank]];
    for (std::int32_t n = range.first; n < range.last; ++n) {
      if (touches(n)) body(contacts_[n], forceOf(n));
    }
  }
}

}  // namespace granular::detail
