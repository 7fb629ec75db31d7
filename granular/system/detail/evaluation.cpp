// SPDX-License-Identifier: MIT
// The stages that turn states into positions and forces into rates.
#include "granular/system/detail/evaluation.h"

#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

// How much is handed to a thread at a time. Fixed, so that pieces are the same for any number of threads.
constexpr std::int32_t kOwnersPerPiece = 256;
constexpr std::int32_t kPatchesPerPiece = 256;

// Skin of the first candidate list in smallest radii; it adapts.
constexpr double kFirstSkin = 0.3;
// Up to this many kinds of particles the pair laws are a table over pairs of kinds (1 MB).
constexpr std::size_t kKindsInTable = 64;

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

}  // namespace

void Evaluation::reset(const std::vector<MaterialPair>& materialPairs,
                       const std::vector<MaterialDef>& materials) {
  materialPairs_ = materialPairs;
  materials_ = materials;
  owners_.assign(layout_.owners.size(), OwnerRow{});
  particles_.assign(layout_.particleCount, ParticleRow{});
  rotations_.assign(layout_.owners.size(), Matrix3::Identity());
  surfaces_.assign(layout_.surfaceCount(), SurfaceRow{});
  memory_.clear();
  patchWrenches_.assign(layout_.patchCount, PatchWrench{});
  list_.reset(layout_.particleCount, layout_.largestRadius, kFirstSkin * layout_.smallestRadius);
  listIsCurrent_ = false;
  slotsAreSorted_ = false;
  lawsByKind_ = layout_.kinds.size() <= kKindsInTable;
  noteLaws();
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
  for (std::int32_t s = 0; s < layout_.surfaceCount(); ++s) {
    if (layout_.ownerOfSurface[s] >= layout_.movingCount()) placeSurface(s);
  }
  listIsCurrent_ = false;
}

void Evaluation::evaluate(const Moment& at, const std::vector<double>& y, std::vector<double>& rate) {
  ++evaluations;
  placeParticles(at.time, y);         // pose -> particle positions, x + R s_i              sec. 3.1
  updateCandidates();                 // only when something has moved half a skin          sec. 3.2
  findContacts();                     // candidates -> pairs with overlap > 0               eq. 1
  computeContactForces(at, y, rate);  // relative velocity, normal law, shear law           eqs. 2-19
  sumWrenches();                      // by rank -> wrench of each grain and moving body    sec. 3.1
  computeAccelerations(y, rate);      // gravity, loads, rigid-body equations of motion     sec. 3.4
}

void Evaluation::placeOwner(std::int32_t o, const Vector3& position, const Quaternion& orientation) {
  const Owner& owner = layout_.owners[o];
  owners_[o].center = position;
  if (owner.isSphere) {
    particles_[owner.firstSlot] = {position.x(), position.y(), position.z(),
                                   owner.scale * owner.particles.front().radius};
    return;
  }
  const Matrix3 rotation = owner.scale * orientation.toRotationMatrix();
  if (owner.kind == OwnerKind::Body) rotations_[o] = rotation;
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
        row.angularVelocity = angularVelocityOf(owner, orientation, vectorAt(own, state::kAngularMomentum));
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
  for (std::int32_t s = 0; s < layout_.surfaceCount(); ++s) {
    if (layout_.ownerOfSurface[s] >= moving) continue;
    placeSurface(s);
    if (compare) largestMoveSquared_ = std::max(largestMoveSquared_, surfaceMove(s) * surfaceMove(s));
  }
  summary_.largestSpeed = maximum(pieceMaximum2_, pieces);
}

/// What touches the patch: first the contacts in its own rows, then those in the rows of others.
PatchWrench Evaluation::wrenchOfPatch(std::int32_t patch) const {
  const Vector3 center = owners_[layout_.ownerOfPatch[patch]].center;
  PatchWrench sum;
  const auto [firstSlot, lastSlot] = layout_.slotsOfPatch(patch);
  for (std::int32_t slot = firstSlot; slot < std::min(lastSlot, layout_.dynamicParticles); ++slot) {
    const auto [first, last] = contactsOfRow_[slot];
    for (std::int32_t n = first; n < last; ++n) {
      const ContactForce& contact = forces_[n];
      sum.force += contact.force;
      sum.torque += (contact.point - center).cross(contact.force);
      sum.dissipation += contact.dissipation;
    }
  }
  for (const std::int32_t candidate : incidence_.of(patch)) {
    const std::int32_t n = contactOfCandidate_[candidate];
    if (n < 0) continue;
    const ContactForce& contact = forces_[n];
    sum.force -= contact.force;
    sum.torque -= (contact.point - center).cross(contact.force);
  }
  return sum;
}

void Evaluation::sumWrenches() {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::SumWrenches)]);
  executor_.forRanges(layout_.patchCount, kPatchesPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t patch = begin; patch < end; ++patch) {
      patchWrenches_[patch] = wrenchOfPatch(static_cast<std::int32_t>(patch));
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
  rate[heatAt()] = heat;
}

}  // namespace granular::detail
