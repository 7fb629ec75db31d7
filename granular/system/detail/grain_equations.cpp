// SPDX-License-Identifier: MIT
#include "granular/system/detail/grain_equations.h"

#include <algorithm>

#include "granular/dynamics/free_rotation.h"

namespace granular::detail {
namespace {

constexpr std::int64_t kOwnersPerPiece = 512, kNumbersPerPiece = 8192;  // handed to a thread at a time

Eigen::Map<const Vector3> vectorAt(const double* own, int place) {
  return Eigen::Map<const Vector3>(own + place);
}
Eigen::Map<Vector3> vectorAt(double* own, int place) {
  return Eigen::Map<Vector3>(own + place);
}

Quaternion readQuaternion(const double* own) {
  const double* q = own + state::kOrientation;
  return {q[0], q[1], q[2], q[3]};
}
void writeQuaternion(const Quaternion& q, double* own) {
  double* out = own + state::kOrientation;
  out[0] = q.w(), out[1] = q.x(), out[2] = q.y(), out[3] = q.z();
}

/// Orientation after t seconds in which nothing turns the owner.
Quaternion turned(const Owner& owner, const Quaternion& orientation, const Vector3& angularMomentum,
                  double t) {
  if (!owner.isLocked) return freelyTurned(orientation, angularMomentum, owner.inverseInertia, t);
  // Held about some axis it is no free top: the midpoint rule.
  const Vector3 start = angularVelocityOf(owner, orientation, angularMomentum);
  const Quaternion middle = turnBy(0.5 * t * start) * orientation;
  return (turnBy(t * angularVelocityOf(owner, middle, angularMomentum)) * orientation).normalized();
}

}  // namespace

void GrainEquations::evaluate(const Moment& at, const std::vector<double>& y, std::vector<double>& rate) {
  evaluation_.evaluate(at, y, rate);
  const EvaluationSummary& now = evaluation_.summary();
  seen_.urgency = std::max(seen_.urgency, now.urgency);
  seen_.contacts = std::max(seen_.contacts, now.contacts);
  hasEvent_ |= now.pushing != pushingAtStart_;
}

void GrainEquations::beginTrial(const EvaluationSummary& start) {
  seen_ = start;
  pushingAtStart_ = start.pushing;
  hasEvent_ = false;
}

void GrainEquations::drift(const Drift& drift, const std::vector<double>& y, const std::vector<double>& rate,
                           std::vector<double>& to) {
  const Layout& layout = evaluation_.layout();
  executor().forRanges(layout.dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t place = begin; place < end; ++place) {
      const double *own = y.data() + place * state::kSize, *change = rate.data() + place * state::kSize;
      double* out = to.data() + place * state::kSize;
      const auto momentum = [&](int at, double kick) -> Vector3 {
        return vectorAt(own, at) + kick * vectorAt(change, at);
      };
      vectorAt(out, state::kPosition) =
          vectorAt(own, state::kPosition) + drift.time * momentum(state::kVelocity, drift.poseKick);
      const Vector3 L = momentum(state::kAngularMomentum, drift.poseKick);
      const double ofSphere = layout.sphereInverseInertia[place];
      writeQuaternion(ofSphere > 0.0 ? (turnBy(drift.time * ofSphere * L) * readQuaternion(own)).normalized()
                                     : turned(layout.owners[layout.ownerOfPlace[place]], readQuaternion(own),
                                              L, drift.time),
                      out);
      vectorAt(out, state::kVelocity) = momentum(state::kVelocity, drift.kick);
      vectorAt(out, state::kAngularMomentum) = momentum(state::kAngularMomentum, drift.kick);
    }
  });
  const std::size_t memory = evaluation_.stateSize();
  executor().forRanges(static_cast<std::int64_t>(y.size() - memory), kNumbersPerPiece,
                       [&](std::int64_t begin, std::int64_t end) {
                         for (std::size_t i = memory + begin; i < memory + end; ++i) {
                           to[i] = y[i] + drift.memory * rate[i];
                         }
                       });
}

void GrainEquations::kick(const std::vector<double>& y, double first, const std::vector<double>& rate0,
                          double second, const std::vector<double>& rate1, std::vector<double>& to) {
  const auto sum = [&](std::size_t i) { to[i] = y[i] + first * rate0[i] + second * rate1[i]; };
  const std::size_t owners = evaluation_.layout().dynamicCount();
  executor().forRanges(owners, kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    static_assert(state::kAngularMomentum == state::kVelocity + 3);
    for (std::int64_t place = begin; place < end; ++place) {
      const std::size_t at = place * state::kSize + state::kVelocity;
      for (std::size_t i = at; i < at + 6; ++i) sum(i);
    }
  });
  for (std::size_t i = owners * state::kSize; i < evaluation_.stateSize(); ++i) sum(i);
}

void GrainEquations::finish(const std::vector<double>& y, double h, std::vector<double>& to) {
  const Layout& layout = evaluation_.layout();
  executor().forRanges(layout.dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t place = begin; place < end; ++place) {
      const Owner& owner = layout.owners[layout.ownerOfPlace[place]];
      const double* own = y.data() + place * state::kSize;
      double* out = to.data() + place * state::kSize;
      const Vector3 L = vectorAt(own, state::kAngularMomentum);
      if (owner.isotropic && !owner.isLocked && L == vectorAt(out, state::kAngularMomentum)) {
        writeQuaternion(freelyTurned(readQuaternion(own), L, owner.inverseInertia, h), out);
      } else {
        Eigen::Map<Eigen::Vector4d>(out + state::kOrientation).normalize();
      }
    }
  });
}

}  // namespace granular::detail
