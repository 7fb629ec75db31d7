// SPDX-License-Identifier: MIT
#include "granular/system/detail/evaluation.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace granular::detail {
namespace {

// How much is handed to a thread at a time. Fixed, so that pieces are the same for any number of threads.
constexpr std::int32_t kOwnersPerPiece = 256;
constexpr std::int32_t kRowsPerPiece = 512;
constexpr std::int32_t kPatchesPerPiece = 256;

// Skin of the candidate list in smallest radii: more candidates to test against fewer rebuilds.
constexpr double kSkin = 0.3;
// Up to this many kinds of particles the pair laws are a table over pairs of kinds (512 kB).
constexpr std::size_t kKindsInTable = 64;
// List rebuilds between two sortings of the slots by cell: grains travel a few radii in that time.
constexpr std::int64_t kRebuildsPerSort = 200;

class StageTimer {
 public:
  explicit StageTimer(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~StageTimer() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  StageTimer(const StageTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

double maximum(const std::vector<double>& values, std::int32_t count) {
  double largest = 0.0;
  for (std::int32_t i = 0; i < count; ++i) largest = std::max(largest, values[i]);
  return largest;
}

Eigen::Map<const Vector3> vectorAt(const double* y, int place) {
  return Eigen::Map<const Vector3>(y + place);
}
Eigen::Map<Vector3> vectorAt(double* y, int place) {
  return Eigen::Map<Vector3>(y + place);
}

Quaternion orientationAt(const double* y) {
  const double* q = y + state::kOrientation;
  return Quaternion(q[0], q[1], q[2], q[3]).normalized();
}

/// omega = R I^-1 R^T L, with locked axes left out.
Vector3 angularVelocity(const Owner& owner, const Quaternion& orientation, const Vector3& angularMomentum) {
  if (owner.isotropic && !owner.isLocked) return owner.inverseInertia.x() * angularMomentum;
  const Vector3 own = orientation.conjugate() * angularMomentum;
  const Vector3 world = orientation * owner.inverseInertia.cwiseProduct(own);
  return owner.isLocked ? Vector3(owner.angularFactor.cwiseProduct(world)) : world;
}

/// Line of centres for two particles in one place: any direction does, as long as it is always the same.
const Vector3 kAnyDirection = Vector3::UnitY();

}  // namespace

void Evaluation::reset(const std::vector<MaterialPair>& materialPairs,
                       const std::vector<MaterialDef>& materials) {
  materialPairs_ = materialPairs;
  materials_ = materials;
  owners_.assign(layout_.owners.size(), OwnerRow{});
  particles_.assign(layout_.particleCount, ParticleRow{});
  patchWrenches_.assign(layout_.patchCount, PatchWrench{});
  list_.reset(layout_.particleCount, layout_.largestRadius, kSkin * layout_.smallestRadius);
  listIsCurrent_ = false;
  rebuildsSinceSort_ = kRebuildsPerSort;
  lawsByKind_ = layout_.kinds.size() <= kKindsInTable;
  if (lawsByKind_) makePairLaws();
  placeFixed();
}

void Evaluation::placeFixed() {
  for (std::int32_t b = 0; b < static_cast<std::int32_t>(surroundings_.fixed.size()); ++b) {
    const std::int32_t o = layout_.movingCount() + b;
    owners_[o].velocity.setZero();
    owners_[o].angularVelocity.setZero();
    placeOwner(o, surroundings_.fixed[b].pose.position, surroundings_.fixed[b].pose.orientation);
  }
  listIsCurrent_ = false;
}

void Evaluation::evaluate(double t, const std::vector<double>& y, std::vector<double>& rate) {
  ++evaluations;
  placeParticles(t, y);    // pose -> particle positions, x + R s_i                            sec. 3.1
  updateCandidates();      // only when something has moved half a skin                        sec. 3.2
  findContacts();          // candidates -> pairs with overlap > 0                             eq. 1
  computeContactForces();  // relative velocity, normal law, shear law                         eqs. 2-18
  sumWrenches();           // by rank -> force and torque per grain and moving body            sec. 3.1
  computeAccelerations(y, rate);  // gravity, loads, rigid-body equations of motion                   sec. 3.4
}

void Evaluation::placeOwner(std::int32_t o, const Vector3& position, const Quaternion& orientation) {
  const Owner& owner = layout_.owners[o];
  owners_[o].center = position;
  const Matrix3 rotation = owner.scale * orientation.toRotationMatrix();
  ParticleRow* row = particles_.data() + owner.firstSlot;
  for (const ShapeParticle& particle : owner.particles) {
    const Vector3 p = position + rotation * particle.position;
    *row++ = {p.x(), p.y(), p.z(), owner.scale * particle.radius};
  }
}

void Evaluation::placeParticles(double t, const std::vector<double>& y) {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::PlaceParticles)]);
  const std::int32_t dynamic = layout_.dynamicCount();
  const std::int32_t moving = layout_.movingCount();
  const std::int32_t pieces = Executor::pieceCount(moving, kOwnersPerPiece);
  pieceMaximum_.assign(pieces, 0.0);
  pieceMaximum2_.assign(pieces, 0.0);
  const bool compare = listIsCurrent_;
  executor_.forPieces(pieces, [&](std::int32_t piece) {
    double move = 0.0, speed = 0.0;
    const std::int32_t end = std::min(moving, (piece + 1) * kOwnersPerPiece);
    for (std::int32_t n = piece * kOwnersPerPiece; n < end; ++n) {
      const std::int32_t o = n < dynamic ? layout_.slotOrder[n] : n;
      const Owner& owner = layout_.owners[o];
      OwnerRow& row = owners_[o];
      if (o < dynamic) {
        const double* own = y.data() + o * state::kSize;
        const Quaternion orientation = orientationAt(own);
        placeOwner(o, vectorAt(own, state::kPosition), orientation);
        row.velocity = vectorAt(own, state::kVelocity);
        row.angularVelocity = angularVelocity(owner, orientation, vectorAt(own, state::kAngularMomentum));
      } else {
        const RigidMotion& start = surroundings_.kinematic[o - dynamic];
        const RigidMotion now = advanced(start, t);
        placeOwner(o, now.pose.position, now.pose.orientation);
        row.velocity = now.velocity;
        row.angularVelocity = now.angularVelocity;
      }
      speed = std::max(speed, row.velocity.norm() + row.angularVelocity.norm() * owner.reach);
      if (!compare) continue;
      const auto count = static_cast<std::int32_t>(owner.particles.size());
      for (std::int32_t slot = owner.firstSlot; slot < owner.firstSlot + count; ++slot) {
        const ParticleRow &a = particles_[slot], &b = listedParticles_[slot];
        const double dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
        move = std::max(move, dx * dx + dy * dy + dz * dz);
      }
    }
    pieceMaximum_[piece] = move;
    pieceMaximum2_[piece] = speed;
  });
  largestMoveSquared_ = maximum(pieceMaximum_, pieces);
  summary_.largestSpeed = maximum(pieceMaximum2_, pieces);
}

void Evaluation::updateCandidates() {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::UpdateCandidates)]);
  const double halfSkin = 0.5 * list_.skin();
  if (listIsCurrent_ && largestMoveSquared_ <= halfSkin * halfSkin) return;
  if (++rebuildsSinceSort_ > kRebuildsPerSort) sortSlots();
  rebuildCandidates();
}

void Evaluation::sortSlots() {
  rebuildsSinceSort_ = 0;
  const std::int32_t dynamic = layout_.dynamicCount();
  // Cells of a few grains, walked in Z-order (Morton 1966): neighbours in space become neighbours in memory.
  const double edge = 4.0 * layout_.largestRadius;
  const auto spread = [](std::uint64_t v) {  // 21 bits, two zero bits between each
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    return (v | v << 2) & 0x1249249249249249;
  };
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed(dynamic);
  for (std::int32_t o = 0; o < dynamic; ++o) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double cell =
          std::clamp(std::floor(owners_[o].center[axis] / edge) + 0x100000, 0.0, double{0x1fffff});
      key |= spread(static_cast<std::uint64_t>(cell)) << axis;
    }
    keyed[o] = {key, o};
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::int32_t> order(dynamic);
  std::transform(keyed.begin(), keyed.end(), order.begin(), [](const auto& k) { return k.second; });

  const std::vector<ParticleRow> before = particles_;
  const std::vector<std::int32_t> slotBefore = layout_.slotOfRank;
  layout_.assignSlots(std::move(order));
  for (std::int32_t rank = 0; rank < layout_.particleCount; ++rank) {
    particles_[layout_.slotOfRank[rank]] = before[slotBefore[rank]];
  }
  list_.reset(layout_.particleCount, layout_.largestRadius, list_.skin());
}

void Evaluation::rebuildCandidates() {
  ++listRebuilds;
  const SearchInput input{.particles = particles_,
                          .owner = layout_.ownerOfSlot,
                          .rank = layout_.rankOfSlot,
                          .slotOfRank = layout_.slotOfRank,
                          .dynamicCount = layout_.dynamicParticles,
                          .rules = &layout_.rules};
  list_.rebuild(input, executor_);
  incidence_.rebuild(list_, input, layout_.patchOfSlot, layout_.patchCount);
  listedParticles_ = particles_;
  listIsCurrent_ = true;
  contacts_.resize(list_.size());
  forces_.resize(list_.size());
  contactOfCandidate_.resize(list_.size());
  if (!lawsByKind_) makePairLaws();
}

PairLaw Evaluation::makeLaw(std::int32_t kindA, std::int32_t kindB) const {
  const auto side = [&](const ParticleKind& kind) {
    const MaterialDef& material = materials_[kind.material];
    return ContactSide{kind.inverseMass, 1.0 / kind.radius, material.youngsModulus, material.poissonRatio};
  };
  const ParticleKind &a = layout_.kinds[kindA], &b = layout_.kinds[kindB];
  return makePairLaw(materialPairs_[a.material * materials_.size() + b.material], side(a), side(b));
}

void Evaluation::makePairLaws() {
  if (lawsByKind_) {
    const auto kinds = static_cast<std::int32_t>(layout_.kinds.size());
    pairLaws_.resize(layout_.kinds.size() * layout_.kinds.size());
    for (std::int32_t a = 0; a < kinds; ++a) {
      for (std::int32_t b = 0; b < kinds; ++b) pairLaws_[a * kinds + b] = makeLaw(a, b);
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
      for (std::int32_t c = rowStart[i]; c < rowStart[i + 1]; ++c) {
        const ParticleRow& b = particles_[partner[c]];
        const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z, reach = a.radius + b.radius;
        const bool touches = dx * dx + dy * dy + dz * dz < reach * reach;
        contactOfCandidate_[c] = touches ? n : -1;
        contacts_[n] = {i, partner[c], c};  // overwritten by the next one unless it counts: n <= c always
        n += touches;
      }
    }
    contactsInPiece_[piece] = n - rowStart[begin];
  });
}

ContactForce Evaluation::contactForce(const Contact& contact, double& urgency) const {
  const ParticleRow &a = particles_[contact.slot1], &b = particles_[contact.slot2];
  const OwnerRow& owner1 = owners_[layout_.ownerOfSlot[contact.slot1]];
  const OwnerRow& owner2 = owners_[layout_.ownerOfSlot[contact.slot2]];
  const PairLaw& law = pairLaw(contact);

  const Vector3 x1(a.x, a.y, a.z), x2(b.x, b.y, b.z);
  const double distance = (x2 - x1).norm();
  const double xi = a.radius + b.radius - distance;                                  // eq. 1
  const Vector3 N = distance > 0.0 ? Vector3((x2 - x1) / distance) : kAnyDirection;  // eq. 2
  const Vector3 p = x1 + (a.radius - 0.5 * xi) * N;
  const Vector3 V = owner1.velocity + owner1.angularVelocity.cross(p - owner1.center) -  // eq. 3
                    owner2.velocity - owner2.angularVelocity.cross(p - owner2.center);
  const double xiDot = V.dot(N);     // eq. 4
  const Vector3 Vt = V - xiDot * N;  // eq. 5
  if (!(xi > 0.0))
    return {Vector3::Zero(), p, 0.0, 0.0};  // rounding: touching by the test, apart by the root

  const double fn = law.normal.force(xi, xiDot);      // eqs. 6-7
  const double kt = law.shear.factor(fn, Vt.norm());  // eq. 18
  urgency = std::max(urgency, law.urgency(xi, xiDot));
  return {.force = -fn * N - kt * Vt,
          .point = p,
          .dissipation = (fn - law.normal.elasticForce(xi)) * xiDot + kt * Vt.squaredNorm(),
          .overlap = xi};
}

void Evaluation::computeContactForces() {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::ComputeContactForces)]);
  const auto pieces = static_cast<std::int32_t>(contactsInPiece_.size());
  pieceMaximum_.assign(pieces, 0.0);
  pieceMaximum2_.assign(pieces, 0.0);
  executor_.forPieces(pieces, [&](std::int32_t piece) {
    const std::int32_t begin = list_.rowStart()[piece * kRowsPerPiece];
    double urgency = 0.0, overlap = 0.0;
    for (std::int32_t n = begin; n < begin + contactsInPiece_[piece]; ++n) {
      forces_[n] = contactForce(contacts_[n], urgency);
      const double smaller =
          std::min(particles_[contacts_[n].slot1].radius, particles_[contacts_[n].slot2].radius);
      overlap = std::max(overlap, forces_[n].overlap / smaller);
    }
    pieceMaximum_[piece] = urgency;
    pieceMaximum2_[piece] = overlap;
  });
  summary_.urgency = maximum(pieceMaximum_, pieces);
  summary_.largestOverlap = maximum(pieceMaximum2_, pieces);
  summary_.contacts = 0;
  for (const std::int32_t count : contactsInPiece_) summary_.contacts += count;
}

void Evaluation::sumWrenches() {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::SumWrenches)]);
  executor_.forRanges(layout_.patchCount, kPatchesPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t patch = begin; patch < end; ++patch) {
      const Vector3 center = owners_[layout_.ownerOfPatch[patch]].center;
      PatchWrench sum;
      for (const std::int32_t entry : incidence_.of(static_cast<std::int32_t>(patch))) {
        const std::int32_t n = contactOfCandidate_[entry >> 1];
        if (n < 0) continue;
        const ContactForce& contact = forces_[n];
        const Vector3 force = entry & 1 ? Vector3(-contact.force) : contact.force;
        sum.force += force;
        sum.torque += (contact.point - center).cross(force);
        if (!(entry & 1)) sum.dissipation += contact.dissipation;
      }
      patchWrenches_[patch] = sum;
    }
  });
}

void Evaluation::computeAccelerations(const std::vector<double>& y, std::vector<double>& rate) {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::ComputeAccelerations)]);
  const std::int32_t dynamic = layout_.dynamicCount();
  const std::int32_t moving = layout_.movingCount();
  const std::int32_t pieces = Executor::pieceCount(moving, kOwnersPerPiece);
  pieceSum_.assign(pieces, 0.0);
  executor_.forPieces(pieces, [&](std::int32_t piece) {
    const std::int32_t end = std::min(moving, (piece + 1) * kOwnersPerPiece);
    for (std::int32_t o = piece * kOwnersPerPiece; o < end; ++o) {
      const Owner& owner = layout_.owners[o];
      const OwnerRow& row = owners_[o];
      PatchWrench contact;
      for (std::int32_t patch = owner.firstPatch; patch < owner.firstPatch + owner.patchCount; ++patch) {
        contact.force += patchWrenches_[patch].force;
        contact.torque += patchWrenches_[patch].torque;
        contact.dissipation += patchWrenches_[patch].dissipation;
      }
      pieceSum_[piece] += contact.dissipation;

      const std::int32_t body = o - layout_.dynamicGrains;  // negative for grains
      Wrench load;
      Vector3 gravity = surroundings_.gravity;
      if (body >= 0 && o < dynamic) {
        load = surroundings_.bodyLoad[body];
        gravity = surroundings_.bodyGravity[body];
      }
      if (body >= 0) {
        double* tally = rate.data() + tallyAt(body);
        vectorAt(tally, state::kImpulse) = contact.force;
        vectorAt(tally, state::kAngularImpulse) = contact.torque;
        tally[state::kWork] =
            o < dynamic ? load.force.dot(row.velocity) + load.torque.dot(row.angularVelocity)
                        : -contact.force.dot(row.velocity) - contact.torque.dot(row.angularVelocity);
      }
      if (o >= dynamic) continue;

      const double* own = y.data() + o * state::kSize;
      double* out = rate.data() + o * state::kSize;
      vectorAt(out, state::kPosition) = row.velocity;
      const double* q = own + state::kOrientation;
      const Quaternion spin =
          Quaternion(0.0, row.angularVelocity.x(), row.angularVelocity.y(), row.angularVelocity.z()) *
          Quaternion(q[0], q[1], q[2], q[3]);
      double* qDot = out + state::kOrientation;
      qDot[0] = 0.5 * spin.w(), qDot[1] = 0.5 * spin.x(), qDot[2] = 0.5 * spin.y(), qDot[3] = 0.5 * spin.z();
      const Vector3 acceleration = owner.inverseMass * contact.force + gravity;
      vectorAt(out, state::kVelocity) =
          owner.linearFactor.cwiseProduct(acceleration) + owner.inverseMass * load.force;
      vectorAt(out, state::kAngularMomentum) = owner.angularFactor.cwiseProduct(contact.torque) + load.torque;
    }
  });
  double heat = 0.0;
  for (std::int32_t piece = 0; piece < pieces; ++piece) heat += pieceSum_[piece];
  rate[stateSize() - 1] = heat;
}

}  // namespace granular::detail
