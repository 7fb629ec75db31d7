// SPDX-License-Identifier: MIT
// The stages that turn states into positions and forces into rates.
#include "granular/system/detail/evaluation.h"

#include <variant>

#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

// How much is handed to a thread at a time. Fixed, so that pieces are the same for any number of threads.
constexpr std::int32_t kOwnersPerPiece = 256;

}  // namespace

void Evaluation::reset(const std::vector<MaterialPair>& materialPairs,
                       const std::vector<MaterialDef>& materials) {
  materialPairs_ = materialPairs;
  materials_ = materials;
  layRows();
  layBlocks();
  rotations_.assign(layout_.owners.size() - layout_.dynamicGrains, Matrix3::Identity());
  surfaces_.assign(layout_.surfaceCount(), SurfaceRow{});
  surfaceInverseRadius_.clear();
  for (const std::int32_t o : layout_.ownerOfSurface) {
    const auto* ball = std::get_if<ExactSphere>(layout_.owners[o].body->exact);
    surfaceInverseRadius_.push_back(ball ? 1.0 / ball->radius : 0.0);
  }
  memory_.clear();
  list_.reset();
  listIsCurrent_ = false;
  rebuildsSinceSort_ = 0;
  noteLaws();
  makePairLaws();
  placeFixed();
}

/// Places in blocks: so few rows that what they need stays in the nearest caches, so many that few contacts
/// are between two blocks. Contacts between bodies cost most by far: one thread does not do them twice. Sums
/// do not depend on it.
void Evaluation::layBlocks() {
  constexpr std::int32_t kRows = 1024;
  const std::int32_t bodyRows = executor_.isParallel() ? kRows : 8 * kRows;
  const std::int32_t moving = layout_.movingCount();
  firstPlaceOfBlock_ = {0};
  firstSlotOfBlock_ = {0};
  blockOfPatch_.resize(layout_.patchCount);
  std::int32_t grainRows = 0, rows = 0;
  for (std::int32_t place = 0; place < moving; ++place) {
    const std::int32_t block = blockCount(), end = layout_.slotOfPlace[place + 1];
    std::fill(blockOfPatch_.begin() + layout_.patchOfPlace[place],
              blockOfPatch_.begin() + layout_.patchOfPlace[place + 1], block);
    const std::int32_t count = end - layout_.slotOfPlace[place];
    rows += count;
    if (layout_.ownerOfPlace[place] < layout_.dynamicGrains) grainRows += count;
    if (grainRows < kRows && rows < bodyRows && place + 1 < moving) continue;
    firstPlaceOfBlock_.push_back(place + 1);
    firstSlotOfBlock_.push_back(std::min(end, layout_.dynamicParticles));
    grainRows = rows = 0;
  }
}

/// All of the rows that time does not change.
void Evaluation::layRows() {
  owners_.assign(layout_.owners.size(), OwnerRow{});
  balls_.assign(layout_.owners.size() - layout_.firstBall(), ParticleRow{});
  particles_.assign(layout_.particleCount, ParticleRow{});
  heatOfOwner_.assign(layout_.owners.size(), 0.0);
  dampingRates_.assign(layout_.dynamicCount(), 0.0);
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(layout_.owners.size()); ++o) {
    const Owner& owner = layout_.owners[o];
    OwnerRow& row = rowOf(o);
    row.inverseMass = owner.inverseMass;
    const std::int32_t ball = layout_.placeOfOwner[o] - layout_.firstBall();
    if (ball >= 0) balls_[ball].radius = owner.reach;
    row.material = owner.material;
    row.isBody = owner.kind == OwnerKind::Body;
    for (std::size_t k = 0; k < owner.particles.size(); ++k) {
      particles_[owner.firstSlot + k].radius = owner.scale * owner.particles[k].radius;
    }
  }
}

void Evaluation::placeFixed() {
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(surroundings_.fixed.size()); ++b) {
    const std::int32_t o = layout_.movingCount() + b;
    rowOf(o).velocity.setZero();
    rowOf(o).angularVelocity.setZero();
    placeOwner(o, surroundings_.fixed[b].pose.position, surroundings_.fixed[b].pose.orientation);
  }
  for (std::int32_t s = 0; s < layout_.sleeperCount(); ++s) {
    const std::int32_t o = layout_.firstSleeper + s;
    rowOf(o).velocity.setZero();
    rowOf(o).angularVelocity.setZero();
    placeOwner(o, surroundings_.asleep[s].position, surroundings_.asleep[s].orientation);
  }
  for (std::int32_t s = 0; s < layout_.surfaceCount(); ++s) {
    if (layout_.ownerOfSurface[s] >= layout_.movingCount()) placeSurface(s);
  }
  listIsCurrent_ = false;
  list_.fixedMoved();
}

void Evaluation::evaluate(const Moment& at, const std::vector<double>& y, std::vector<double>& rate) {
  ++evaluations;
  placeParticles(at.time, y);  // pose -> particle positions, x + R s_i                     sec. 3.1
  updateCandidates();          // only when something has moved too far                     sec. 3.2
  updateLawRows();
  ContactArrays arrays = contactArrays();
  arrays.displacements = y.data() + stateSize();
  arrays.displacementRates = rate.data() + (stateSize() - lackingOf(rate, y));
  arrays.at = at;
  workOnBlocks(arrays, y, rate);  // contacts, forces, wrenches, motion        eqs. 1-19, secs. 3.1, 3.4
}

/// What the kernels read and fill, but for what is known of a moment.
ContactArrays Evaluation::contactArrays() {
  return {.particleCount = layout_.particleCount,
          .dynamicParticles = layout_.dynamicParticles,
          .particles = particles_.data(),
          .owners = owners_.data(),
          .balls = balls_.data(),
          .firstBall = layout_.firstBall(),
          .movesOnlySpheres = layout_.movesOnlySpheres,
          .placeOfSlot = layout_.placeOfSlot.data(),
          .surfaceInverseRadius = surfaceInverseRadius_.data(),
          .patchOfSlot = layout_.patchOfSlot.data(),
          .lawRows = lawRows_.data(),
          .indexOfCandidate = blocks_.index().data(),
          .memoryOfCandidate = memoryOfCandidate_.data(),
          .memory = memory_.data(),
          .displacements = nullptr,
          .displacementRates = nullptr,
          .at = {}};
}

void Evaluation::placeOwner(std::int32_t o, const Vector3& position, const Quaternion& orientation) {
  const Owner& owner = layout_.owners[o];
  ParticleRow& ball = balls_[layout_.placeOfOwner[o] - layout_.firstBall()];
  ball.x = position.x(), ball.y = position.y(), ball.z = position.z();
  const Matrix3 rotation = owner.scale * orientation.toRotationMatrix();
  if (owner.kind == OwnerKind::Body) rotations_[o - layout_.dynamicGrains] = rotation;
  ParticleRow* row = particles_.data() + owner.firstSlot;
  for (const ShapeParticle& particle : owner.particles) {
    const Vector3 p = position + rotation * particle.position;
    row->x = p.x(), row->y = p.y(), row->z = p.z();
    ++row;
  }
}

/// Rows of the owner in this place, and how fast its fastest point may be, m/s.
double Evaluation::placeMoving(std::int32_t place, double t, const std::vector<double>& y) {
  const std::int32_t o = layout_.ownerOfPlace[place];
  OwnerRow& row = owners_[place];
  if (o >= layout_.dynamicCount()) {
    const RigidMotion& start = surroundings_.kinematic[o - layout_.dynamicCount()];
    const RigidMotion now = advanced(start, t);
    placeOwner(o, now.pose.position, now.pose.orientation);
    row.velocity = now.velocity;
    row.angularVelocity = now.angularVelocity;
  } else {
    const auto own = layout_.numbersAt(place, y.data());
    row.velocity = own.velocity();
    if (layout_.isSphere[place]) {
      row.angularVelocity = layout_.isotropicInverseInertia[place] * own.angularMomentum();
      ParticleRow& particle = particles_[layout_.slotOfPlace[place]];
      particle.x = own.pose[0], particle.y = own.pose[1], particle.z = own.pose[2];
      balls_[place] = particle;
    } else {
      const Quaternion orientation = own.orientation().normalized();
      placeOwner(o, own.position(), orientation);
      row.angularVelocity = angularVelocityOf(layout_.owners[o], orientation, own.angularMomentum());
    }
  }
  return fastestPoint(place);
}

void Evaluation::placeParticles(double t, const std::vector<double>& y) {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::PlaceParticles)]);
  const std::int32_t moving = layout_.movingCount();
  const std::int32_t pieces = Executor::pieceCount(moving, kOwnersPerPiece);
  pieceMaximum_.assign(pieces, 0.0);
  pieceMaximum2_.assign(pieces, 0.0);
  const bool compare = listIsCurrent_;
  const PlaceArrays spheres{.poses = y.data(),
                            .momenta = y.data() + layout_.firstMomentum(),
                            .inverseInertia = layout_.isotropicInverseInertia.data(),
                            .particles = particles_.data(),
                            .owners = owners_.data(),
                            .listed = compare ? listedParticles_.data() : nullptr};
  executor_.forPieces(pieces, [&](std::int32_t piece) {
    const std::int32_t begin = piece * kOwnersPerPiece, end = std::min(moving, begin + kOwnersPerPiece);
    if (layout_.movesOnlySpheres) {
      const PlacedExtremes extremes = kernels_->placeSpheres(spheres, begin, end);
      pieceMaximum_[piece] = extremes.beyond;
      pieceMaximum2_[piece] = extremes.speed;
      return;
    }
    double beyond = 0.0, speed = 0.0;
    for (std::int32_t place = begin; place < end; ++place) speed = std::max(speed, placeMoving(place, t, y));
    if (compare) {
      const std::int32_t slots = layout_.slotOfPlace[end];
      for (std::int32_t slot = layout_.slotOfPlace[begin]; slot < slots; ++slot) {
        const ParticleRow& now = particles_[slot];
        const ListedRow& then = listedParticles_[slot];
        const double dx = now.x - then.x, dy = now.y - then.y, dz = now.z - then.z;
        beyond = std::max(beyond, dx * dx + dy * dy + dz * dz - then.marginSquared);
      }
    }
    pieceMaximum_[piece] = beyond;
    pieceMaximum2_[piece] = speed;
  });
  listIsOld_ = !compare || maximum(pieceMaximum_, pieces) > 0.0;
  for (std::int32_t s = 0; s < layout_.surfaceCount(); ++s) {
    if (layout_.ownerOfSurface[s] >= moving) continue;
    placeSurface(s);
    listIsOld_ = listIsOld_ || surfaceMove(s) > surfaceMargins_[s];
  }
  summary_.largestSpeed = maximum(pieceMaximum2_, pieces);
}

/// Rate of the owner in this place under what contacts do to it.
void Evaluation::accelerate(std::int32_t place, const PatchWrench& contact, const std::vector<double>& y,
                            bool poseRates, std::vector<double>& rate) const {
  const std::int32_t o = layout_.ownerOfPlace[place];
  const OwnerRow& row = owners_[place];
  const auto out = layout_.ratesAt(place, rate.data(), lackingOf(rate, y));
  if (poseRates) {
    out.position() = row.velocity;
    const Vector3 half = 0.5 * row.angularVelocity;
    out.setOrientation(Quaternion(0.0, half.x(), half.y(), half.z()) *
                       layout_.numbersAt(place, y.data()).orientation());
  }
  const std::int32_t body = o - layout_.dynamicGrains;  // negative for grains
  if (body < 0) {
    out.velocity() = row.inverseMass * contact.force + surroundings_.gravity;
    out.angularMomentum() = contact.torque;
    return;
  }
  const Owner& owner = layout_.owners[o];
  const Wrench& load = surroundings_.bodyLoad[body];
  const Vector3 acceleration = owner.inverseMass * contact.force + surroundings_.bodyGravity[body];
  out.velocity() = owner.body->linearFactor.cwiseProduct(acceleration) + owner.inverseMass * load.force;
  out.angularMomentum() = owner.body->angularFactor.cwiseProduct(contact.torque) + load.torque;
}

/// By how much more than of a solid sphere contacts can damp the turning of the owner in this place, which
/// reaches farther for its moments of inertia.
double Evaluation::leverage(std::int32_t place) const {
  if (layout_.isSphere[place]) return 1.0;
  const Owner& owner = layout_.owners[layout_.ownerOfPlace[place]];
  const double reach = reachAt(place), ofTurning = reach * reach * owner.inverseInertia.maxCoeff();
  return owner.inverseMass > 0.0 ? std::max(1.0, 0.4 * ofTurning / owner.inverseMass) : 1.0;
}

/// What contacts did to a moving body, and work: by its load, or by the body itself where the host moves it.
void Evaluation::tally(std::int32_t body, const PatchWrench& contact, double* to) const {
  const std::int32_t o = layout_.dynamicGrains + body;
  const OwnerRow& row = rowOf(o);
  Eigen::Map<Vector3>(to + state::kImpulse) = contact.force;
  Eigen::Map<Vector3>(to + state::kAngularImpulse) = contact.torque;
  if (o < layout_.dynamicCount()) {
    const Wrench& load = surroundings_.bodyLoad[body];
    to[state::kWork] = load.force.dot(row.velocity) + load.torque.dot(row.angularVelocity);
  } else {
    to[state::kWork] = -contact.force.dot(row.velocity) - contact.torque.dot(row.angularVelocity);
  }
}

/// Of the owners in places [begin, end): gravity, loads and what contacts do to their patches, one after the
/// other.
void Evaluation::computeAccelerations(std::int32_t begin, std::int32_t end, const PatchWrench* wrench,
                                      const std::vector<double>& y, bool poseRates,
                                      std::vector<double>& rate) {
  const std::size_t lacking = lackingOf(rate, y);
  if (layout_.movingBodies() == 0 && !poseRates) {  // every patch is a grain
    for (std::int32_t place = begin; place < end; ++place) {
      heatOfOwner_[layout_.ownerOfPlace[place]] = wrench[place - begin].dissipation;
    }
    kernels_->accelerateGrains(owners_.data(), wrench, surroundings_.gravity, begin, end,
                               rate.data() + (layout_.firstMomentum() - lacking), dampingRates_.data());
    return;
  }
  for (std::int32_t place = begin; place < end; ++place) {
    const std::int32_t o = layout_.ownerOfPlace[place];
    PatchWrench contact;
    for (std::int32_t k = layout_.patchOfPlace[place]; k < layout_.patchOfPlace[place + 1]; ++k, ++wrench) {
      contact.force += wrench->force;
      contact.torque += wrench->torque;
      contact.dissipation += wrench->dissipation;
      contact.damping += wrench->damping;
    }
    heatOfOwner_[o] = contact.dissipation;
    if (const std::int32_t body = o - layout_.dynamicGrains; body >= 0) {
      tally(body, contact, rate.data() + (tallyAt(body) - lacking));
    }
    if (o >= layout_.dynamicCount()) continue;
    dampingRates_[place] = owners_[place].inverseMass * contact.damping;
    accelerate(place, contact, y, poseRates, rate);
  }
}

/// Block by block: contacts, what they do to the owners of the block, and how that changes their motion. What
/// one stage leaves is near when the next one wants it.
void Evaluation::workOnBlocks(const ContactArrays& arrays, const std::vector<double>& y,
                              std::vector<double>& rate) {
  memoryHasRates_ = hasMemory_ && arrays.at.memoryRates;
  forcesAreKept_ = keepsContacts_ || isDampingGiven_;  // shearRate() asks for them before they are settled
  contactsAreKept_ = forcesAreKept_ || hasMemory_;
  if (memoryHasRates_) std::fill(rate.begin() + (stateSize() - lackingOf(rate, y)), rate.end(), 0.0);
  contactsAreListed_ = false;
  contactsAreMeasured_ = measuresContacts_;
  if (contactsAreKept_) makeRoomForContacts();
  if (contactsAreMeasured_) contactTotals_.assign(layout_.dynamicParticles, {});
  extremesInBlock_.resize(blockCount());
  forTimedPieces(blockCount(), [&](std::int32_t block, PieceClock& clock) {
    const PatchWrench* wrenches = workOutContacts(block, arrays, clock);
    computeAccelerations(firstPlaceOfBlock_[block], firstPlaceOfBlock_[block + 1], wrenches, y,
                         arrays.at.poseRates, rate);
    clock.done(Stage::ComputeAccelerations);
  });
  sumUpExtremes();
  double heat = 0.0;
  for (std::int32_t o = 0; o < layout_.movingCount(); ++o) heat += heatOfOwner_[o];
  rate[heatAt() - lackingOf(rate, y)] = heat;
}

/// The contacts of the last evaluation once more. What they remember is settled: nothing moves on.
void Evaluation::workOutAgain(const std::vector<double>& y) {
  ContactArrays arrays = contactArrays();
  arrays.displacements = y.data() + stateSize();
  arrays.at.memoryRates = memoryHasRates_ = false;
  if (contactsAreKept_) makeRoomForContacts();
  forTimedPieces(blockCount(),
                 [&](std::int32_t block, PieceClock& clock) { workOutContacts(block, arrays, clock); });
}

std::span<const ContactTotals> Evaluation::contactTotals(const std::vector<double>& y) {
  if (contactsAreMeasured_) return contactTotals_;
  contactsAreMeasured_ = true;
  contactTotals_.assign(layout_.dynamicParticles, {});
  if (forcesAreKept_) {
    executor_.forPieces(blockCount(), [&](std::int32_t block) {
      const std::int32_t first = firstKept(block);
      measureContactsOf(block, {.count = foundInBlock_[block],
                                .contacts = contacts_.data() + first,
                                .position = positions_.data() + first,
                                .forces = forces_.data()});
    });
  } else {
    workOutAgain(y);
  }
  return contactTotals_;
}

void Evaluation::listContacts(const std::vector<double>& y) {
  if (contactsAreListed_) return;
  contactsAreListed_ = true;
  if (!forcesAreKept_) {
    contactsAreKept_ = forcesAreKept_ = true;
    contactsAreMeasured_ = false;  // else they were added to their totals once more
    workOutAgain(y);
  }
  contactsOfRow_.resize(layout_.dynamicParticles);
  executor_.forPieces(blockCount(), [&](std::int32_t block) { listContactsOf(block); });
}

}  // namespace granular::detail
