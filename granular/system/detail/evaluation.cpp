// SPDX-License-Identifier: MIT
#include "granular/system/detail/evaluation.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <variant>

#include "granular/contact/law_list.h"

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
  return owner.isLocked ? Vector3(owner.freeAxes.cwiseProduct(world)) : world;
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
  rotations_.assign(layout_.owners.size(), Matrix3::Identity());
  surfaces_.assign(layout_.surfaceCount(), SurfaceRow{});
  memory_.clear();
  patchWrenches_.assign(layout_.patchCount, PatchWrench{});
  list_.reset(layout_.particleCount, layout_.largestRadius, kSkin * layout_.smallestRadius);
  listIsCurrent_ = false;
  rebuildsSinceSort_ = kRebuildsPerSort;
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

void Evaluation::evaluate(double t, const std::vector<double>& y, std::vector<double>& rate,
                          double onsetWindow) {
  ++evaluations;
  placeParticles(t, y);                        // pose -> particle positions, x + R s_i              sec. 3.1
  updateCandidates();                          // only when something has moved half a skin          sec. 3.2
  findContacts();                              // candidates -> pairs with overlap > 0               eq. 1
  computeContactForces(y, rate, onsetWindow);  // relative velocity, normal law, shear law           eqs. 2-19
  sumWrenches();                               // by rank -> wrench of each grain and moving body    sec. 3.1
  computeAccelerations(y, rate);               // gravity, loads, rigid-body equations of motion     sec. 3.4
}

void Evaluation::placeOwner(std::int32_t o, const Vector3& position, const Quaternion& orientation) {
  const Owner& owner = layout_.owners[o];
  owners_[o].center = position;
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
  for (std::int32_t s = 0; s < layout_.surfaceCount(); ++s) {
    if (layout_.ownerOfSurface[s] >= moving) continue;
    placeSurface(s);
    if (compare) largestMoveSquared_ = std::max(largestMoveSquared_, surfaceMove(s) * surfaceMove(s));
  }
  summary_.largestSpeed = maximum(pieceMaximum2_, pieces);
}

void Evaluation::placeSurface(std::int32_t s) {
  const std::int32_t o = layout_.ownerOfSurface[s];
  surfaces_[s].point = owners_[o].center;
  if (const auto* ball = std::get_if<ExactSphere>(layout_.owners[o].exact)) {
    surfaces_[s].radius = ball->radius;
  } else {
    surfaces_[s].normal = rotations_[o].col(1);
  }
}

/// How far any point of the surface near a particle has moved since the list was made, at most, m.
double Evaluation::surfaceMove(std::int32_t s) const {
  const SurfaceRow &now = surfaces_[s], &then = listedSurfaces_[s];
  if (now.radius > 0.0) return (now.point - then.point).norm();
  return std::abs(now.normal.dot(now.point) - then.normal.dot(then.point)) +
         (now.normal - then.normal).norm() * listedExtent_;
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
                          .surfaces = surfaces_,
                          .owner = layout_.ownerOfSlot,
                          .rank = layout_.rankOfSlot,
                          .slotOfRank = layout_.slotOfRank,
                          .dynamicCount = layout_.dynamicParticles,
                          .rules = &layout_.rules};
  list_.rebuild(input, executor_);
  incidence_.rebuild(list_, input, layout_.patchOfSlot, layout_.patchCount);
  rememberList();
  contacts_.resize(list_.size());
  forces_.resize(list_.size());
  contactOfCandidate_.resize(list_.size());
  if (!lawsByKind_) makePairLaws();
}

/// What the list was made for, and which of its candidates have a memory.
void Evaluation::rememberList() {
  listedParticles_ = particles_;
  listedSurfaces_ = surfaces_;
  listIsCurrent_ = true;
  listedExtent_ = 0.0;
  if (!surfaces_.empty()) {
    for (const ParticleRow& row : particles_) {
      listedExtent_ = std::max(listedExtent_, Vector3(row.x, row.y, row.z).norm());
    }
  }
  if (!hasMemory_) return;
  memoryOfCandidate_.assign(list_.size(), -1);
  contactMemory_.resize(list_.size());
  for (std::int32_t m = 0; m < static_cast<std::int32_t>(memory_.size()); ++m) {
    const std::int32_t slot = layout_.slotOfRank[memory_[m].rank1];
    const auto begin = list_.partner().begin() + list_.rowStart()[slot];
    const auto end = list_.partner().begin() + list_.rowStart()[slot + 1];
    const auto found = std::lower_bound(
        begin, end, memory_[m].rank2,
        [&](std::int32_t partner, std::int32_t rank) { return layout_.rankOfSlot[partner] < rank; });
    // A contact that is no longer even near has ended; settleMemory drops it.
    if (found != end && layout_.rankOfSlot[*found] == memory_[m].rank2) {
      memoryOfCandidate_[found - list_.partner().begin()] = m;
    }
  }
}

PairLaw Evaluation::makeLaw(std::int32_t kindA, std::int32_t kindB) const {
  const auto side = [&](const ParticleKind& kind) {
    const MaterialDef& material = materials_[kind.material];
    return PairSide{
        .contact = {kind.inverseMass, kind.inverseRadius, material.youngsModulus, material.poissonRatio},
        .isBody = kind.isBody,
        .bodyLength = kind.bodyLength,
        .bodyArea = kind.bodyArea};
  };
  const ParticleKind &a = layout_.kinds[kindA], &b = layout_.kinds[kindB];
  return makePairLaw(materialPairs_[a.material * materials_.size() + b.material], side(a), side(b));
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
  bool anyBody = false, anyGrain = false;
  for (const ParticleKind& kind : layout_.kinds) (kind.isBody ? anyBody : anyGrain) = true;
  const MaterialPairDef& first = materialPairs_.empty() ? MaterialPairDef{} : materialPairs_.front().def;
  for (const MaterialPair& pair : materialPairs_) {
    const ShearLaw shear = pair.def.shear.law;
    hasMemory_ |= withShearLaw(shear, []<class Law>(Law) { return Law::kHasMemory; });
    oneKernel_ &= shear == first.shear.law && pair.def.normal.law == first.normal.law;
    // Bodies meet under bodyNormal, at least one of them moving.
    oneKernel_ &= !(anyBody && layout_.dynamicBodies > 0) || pair.def.bodyNormal.law == first.normal.law;
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
      for (std::int32_t c = rowStart[i]; c < rowStart[i + 1]; ++c) {
        bool touches;
        if (partner[c] < layout_.particleCount) {
          const ParticleRow& b = particles_[partner[c]];
          const double dx = b.x - a.x, dy = b.y - a.y, dz = b.z - a.z, reach = a.radius + b.radius;
          touches = dx * dx + dy * dy + dz * dz < reach * reach;
        } else {
          touches = surfaces_[partner[c] - layout_.particleCount].distance({a.x, a.y, a.z}) < a.radius;
        }
        contactOfCandidate_[c] = touches ? n : -1;
        contacts_[n] = {i, partner[c], c};  // overwritten by the next one unless it counts: n <= c always
        n += touches;
      }
    }
    contactsInPiece_[piece] = n - rowStart[begin];
  });
}

/// The area, m^2, that a contact of bodies stands for: what its particle shows along N; of two particles,
/// what both together do as springs one behind the other.
double Evaluation::contactArea(const Contact& contact, const Vector3& N) const {
  const auto areaOf = [&](std::int32_t slot) {
    const std::int32_t o = layout_.ownerOfSlot[slot];
    const Owner& owner = layout_.owners[o];
    return Layout::areaAlong(owner, layout_.rankOfSlot[slot] - owner.firstRank,
                             rotations_[o].transpose() * N);
  };
  const double first = areaOf(contact.slot1);
  if (contact.slot2 >= layout_.particleCount) return first;
  const double second = areaOf(contact.slot2);
  return first * second / (first + second);
}

/// False where the test of findContacts and the exact overlap disagree by rounding.
template <class Normal, class Shear>
bool Evaluation::contactGeometry(const Contact& contact, ContactGeometry& g) const {
  const ParticleRow& a = particles_[contact.slot1];
  const OwnerRow& owner1 = owners_[layout_.ownerOfSlot[contact.slot1]];
  const OwnerRow& owner2 = owners_[layout_.ownerOfSlot[contact.slot2]];
  const Vector3 x1(a.x, a.y, a.z);
  const bool isPlane = contact.slot2 >= layout_.particleCount &&
                       surfaces_[contact.slot2 - layout_.particleCount].radius == 0.0;
  Vector3 x2 = Vector3::Zero();
  double distance = 0.0;
  if (isPlane) {
    const SurfaceRow& plane = surfaces_[contact.slot2 - layout_.particleCount];
    g.xi = a.radius - plane.distance(x1);
    g.N = -plane.normal;
    g.point = x1 + (a.radius - g.xi) * g.N;
  } else {
    double radius2;
    if (contact.slot2 < layout_.particleCount) {
      const ParticleRow& b = particles_[contact.slot2];
      x2 = {b.x, b.y, b.z};
      radius2 = b.radius;
    } else {
      x2 = surfaces_[contact.slot2 - layout_.particleCount].point;
      radius2 = surfaces_[contact.slot2 - layout_.particleCount].radius;
    }
    distance = (x2 - x1).norm();
    g.xi = a.radius + radius2 - distance;                                  // eq. 1
    g.N = distance > 0.0 ? Vector3((x2 - x1) / distance) : kAnyDirection;  // eq. 2
    g.point = x1 + (a.radius - 0.5 * g.xi) * g.N;
  }
  if (!(g.xi > 0.0)) return false;
  g.V = owner1.velocity + owner1.angularVelocity.cross(g.point - owner1.center) - owner2.velocity -
        owner2.angularVelocity.cross(g.point - owner2.center);  // eq. 3
  if constexpr (Normal::kByArea) g.share = contactArea(contact, g.N);
  if constexpr (Shear::kHasMemory) {
    // The contact's frame turns with its normal, and about it as the two owners do on average.
    const double twist = 0.5 * (owner1.angularVelocity + owner2.angularVelocity).dot(g.N);
    Vector3 swing = isPlane ? owner2.angularVelocity : Vector3(Vector3::Zero());
    if (!isPlane && distance > 0.0) {
      const Vector3 centers = owner2.velocity + owner2.angularVelocity.cross(x2 - owner2.center) -
                              owner1.velocity - owner1.angularVelocity.cross(x1 - owner1.center);
      swing = g.N.cross(centers) / distance;
    }
    g.turning = swing - swing.dot(g.N) * g.N + twist * g.N;
  }
  return true;
}

template <class Normal, class Shear>
void Evaluation::forcesOfRun(std::int32_t begin, std::int32_t end, const double* y, double* rate,
                             double onsetWindow, Extremes& extremes) {
  for (std::int32_t n = begin; n < end; ++n) {
    const Contact& contact = contacts_[n];
    ContactGeometry g;
    if (!contactGeometry<Normal, Shear>(contact, g)) {
      forces_[n] = {Vector3::Zero(), g.point, 0.0, 0.0};
      if constexpr (Shear::kHasMemory) contactMemory_[n] = {};
      continue;
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
      } else if (xiDot > 0.0) {  // begun within this trial: it has slid since its overlap was zero
        D = std::min(g.xi / xiDot, onsetWindow) * (g.V - xiDot * g.N);
      }
    }
    const ContactResult result = contactResult<Normal, Shear>(law.normal, law.shear, g, D, memory);
    if constexpr (Shear::kHasMemory) {
      if (entry >= 0) Eigen::Map<Vector3>(rate + stateSize() + 3 * entry) = memory->rate;
    }
    forces_[n] = {result.force, g.point, result.dissipation, g.xi};
    extremes.urgency = std::max(extremes.urgency, Normal::urgency(law.normal, g.xi, xiDot));
    extremes.overlap = std::max(extremes.overlap, relativeOverlap(contact, g.xi));
  }
}

void Evaluation::computeContactForces(const std::vector<double>& y, std::vector<double>& rate,
                                      double onsetWindow) {
  const StageTimer timer(stageSeconds[static_cast<int>(Stage::ComputeContactForces)]);
  const auto pieces = static_cast<std::int32_t>(contactsInPiece_.size());
  pieceMaximum_.assign(pieces, 0.0);
  pieceMaximum2_.assign(pieces, 0.0);
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
          forcesOfRun<Normal, Shear>(begin, stop, y.data(), rate.data(), onsetWindow, extremes);
        });
      });
      begin = stop;
    }
    pieceMaximum_[piece] = extremes.urgency;
    pieceMaximum2_[piece] = extremes.overlap;
  });
  summary_.urgency = maximum(pieceMaximum_, pieces);
  summary_.largestOverlap = maximum(pieceMaximum2_, pieces);
  summary_.contacts = 0;
  for (const std::int32_t count : contactsInPiece_) summary_.contacts += count;
}

double Evaluation::relativeOverlap(const Contact& contact, double overlap) const {
  const double radius1 = particles_[contact.slot1].radius;
  if (contact.slot2 >= layout_.particleCount) return overlap / radius1;
  return overlap / std::min(radius1, particles_[contact.slot2].radius);
}

double Evaluation::elasticEnergy(const Contact& contact, const ContactForce& force) const {
  const PairLaw& law = pairLaw(contact);
  return withNormalLaw(law.normalLaw, [&]<class Normal>(Normal) {
    const double energy = Normal::elasticEnergy(law.normal, force.overlap);
    if constexpr (!Normal::kByArea) return energy;
    ContactGeometry g;
    return contactGeometry<Normal, RegularisedCoulomb>(contact, g) ? g.share * energy : 0.0;
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

std::vector<RememberedContact> Evaluation::exportMemory(const std::vector<double>& y) const {
  std::vector<RememberedContact> memory;
  for (std::size_t m = 0; m < memory_.size(); ++m) {
    RememberedContact contact;
    const std::int32_t ranks[2] = {memory_[m].rank1, memory_[m].rank2};
    for (int side = 0; side < 2; ++side) {
      const std::int32_t slot = layout_.slotOfRank[ranks[side]];
      const Owner& owner = layout_.owners[layout_.ownerOfSlot[slot]];
      contact.kind[side] = owner.kind;
      contact.index[side] = owner.index;
      contact.local[side] = slot < layout_.particleCount ? ranks[side] - owner.firstRank : -1;
    }
    contact.displacement = Eigen::Map<const Vector3>(y.data() + stateSize() + 3 * m);
    contact.energy = memory_[m].energy;
    memory.push_back(contact);
  }
  return memory;
}

void Evaluation::importMemory(const std::vector<RememberedContact>& memory, std::vector<double>& y) {
  if (!hasMemory_ || memory.empty()) return;
  std::map<std::pair<OwnerKind, std::int32_t>, std::int32_t> ownerNow;
  for (std::int32_t o = 0; o < static_cast<std::int32_t>(layout_.owners.size()); ++o) {
    ownerNow[{layout_.owners[o].kind, layout_.owners[o].index}] = o;
  }
  const auto rankNow = [&](OwnerKind kind, std::int32_t index, std::int32_t local) -> std::int32_t {
    const auto found = ownerNow.find({kind, index});
    if (found == ownerNow.end()) return -1;
    const Owner& owner = layout_.owners[found->second];
    if (local >= 0)
      return local < static_cast<std::int32_t>(owner.particles.size()) ? owner.firstRank + local : -1;
    const auto surface =
        std::find(layout_.ownerOfSurface.begin(), layout_.ownerOfSurface.end(), found->second);
    if (surface == layout_.ownerOfSurface.end()) return -1;
    return layout_.particleCount + static_cast<std::int32_t>(surface - layout_.ownerOfSurface.begin());
  };
  std::vector<std::pair<MemoryEntry, Vector3>> known;
  for (const RememberedContact& contact : memory) {
    const std::int32_t rank1 = rankNow(contact.kind[0], contact.index[0], contact.local[0]);
    const std::int32_t rank2 = rankNow(contact.kind[1], contact.index[1], contact.local[1]);
    // Seen from the other side where the two have changed places in the order: D turns with the point of
    // view.
    if (rank1 < 0 || rank2 < 0) continue;
    const bool swapped = rank2 < rank1;
    known.push_back({{std::min(rank1, rank2), std::max(rank1, rank2), contact.energy},
                     swapped ? Vector3(-contact.displacement) : contact.displacement});
  }
  std::sort(known.begin(), known.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.rank1, a.first.rank2) < std::pair(b.first.rank1, b.first.rank2);
  });
  for (const auto& [entry, displacement] : known) {
    memory_.push_back(entry);
    y.insert(y.end(), displacement.data(), displacement.data() + 3);
  }
}

void Evaluation::settleMemory(std::vector<double>& y, std::vector<double>& rate) {
  if (!hasMemory_) return;
  double heat = 0.0, heating = 0.0;
  std::vector<MemoryEntry> kept;
  std::vector<double> displacements, displacementRates;
  std::vector<bool> lives(memory_.size(), false);
  for (std::int32_t rank = 0; rank < layout_.dynamicParticles; ++rank) {
    const std::int32_t slot = layout_.slotOfRank[rank];
    for (std::int32_t c = list_.rowStart()[slot]; c < list_.rowStart()[slot + 1]; ++c) {
      const std::int32_t n = contactOfCandidate_[c];
      if (n < 0) {
        memoryOfCandidate_[c] = -1;
        continue;
      }
      const ShearLaw shear = pairLaw(contacts_[n]).shearLaw;
      if (!withShearLaw(shear, []<class Law>(Law) { return Law::kHasMemory; })) continue;
      const ContactMemory& memory = contactMemory_[n];
      const std::int32_t before = memoryOfCandidate_[c];
      if (before >= 0) lives[before] = true;
      heat += memory.loss;
      heating += memory.heating;
      memoryOfCandidate_[c] = static_cast<std::int32_t>(kept.size());
      kept.push_back({rank, layout_.rankOfSlot[contacts_[n].slot2], memory.energy});
      for (int k = 0; k < 3; ++k) {
        displacements.push_back(memory.displacement[k]);
        displacementRates.push_back(memory.rate[k]);
      }
    }
  }
  for (std::size_t m = 0; m < memory_.size(); ++m) {
    if (!lives[m]) heat += memory_[m].energy;
  }
  memory_ = std::move(kept);
  y.resize(stateSize());
  y.insert(y.end(), displacements.begin(), displacements.end());
  y[heatAt()] += heat;
  rate.resize(stateSize());
  rate[heatAt()] += heating;
  rate.insert(rate.end(), displacementRates.begin(), displacementRates.end());
}

double Evaluation::memoryEnergy() const {
  double energy = 0.0;
  for (const MemoryEntry& entry : memory_) energy += entry.energy;
  return energy;
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
  rate[heatAt()] = heat;
}

}  // namespace granular::detail
