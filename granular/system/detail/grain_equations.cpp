// SPDX-License-Identifier: MIT
#include "granular/system/detail/grain_equations.h"

#include <algorithm>
#include <array>

#include "granular/dynamics/free_rotation.h"
#include "granular/system/detail/stage_tools.h"

namespace granular::detail {
namespace {

constexpr std::int64_t kOwnersPerPiece = 512, kNumbersPerPiece = 8192;  // handed to a thread at a time

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
  const StageTimer timer(evaluation_.stageSeconds[static_cast<int>(Stage::AdvanceState)]);
  const Layout& layout = evaluation_.layout();
  const std::size_t lacking = lackingOf(rate, y);
  const auto driftOwner = [&](std::int32_t place) {
    const auto own = layout.numbersAt(place, y.data());
    const auto change = layout.ratesAt(place, rate.data(), lacking);
    const auto out = layout.numbersAt(place, to.data());
    out.position() = own.position() + drift.time * (own.velocity() + drift.poseKick * change.velocity());
    const Vector3 L = own.angularMomentum() + drift.poseKick * change.angularMomentum();
    out.setOrientation(turned(layout.owners[layout.ownerOfPlace[place]], own.orientation(), L, drift.time));
    out.velocity() = own.velocity() + drift.kick * change.velocity();
    out.angularMomentum() = own.angularMomentum() + drift.kick * change.angularMomentum();
  };
  const std::size_t firstMomentum = layout.firstMomentum();
  const DriftArrays arrays{.drift = drift,
                           .poses = y.data(),
                           .momenta = y.data() + firstMomentum,
                           .rates = rate.data() + (firstMomentum - lacking),
                           .posesTo = to.data(),
                           .momentaTo = to.data() + firstMomentum,
                           .inverseInertia = layout.isotropicInverseInertia.data(),
                           .turns = turnsSpheres_ || !layout.movesOnlySpheres};
  executor().forRanges(layout.dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    std::array<std::int32_t, kOwnersPerPiece + 1> left;
    const std::int32_t count = evaluation_.kernels().drift(arrays, static_cast<std::int32_t>(begin),
                                                           static_cast<std::int32_t>(end), left.data());
    for (std::int32_t k = 0; k < count; ++k) driftOwner(left[k]);
  });
  const std::size_t memory = evaluation_.stateSize();
  executor().forRanges(static_cast<std::int64_t>(y.size() - memory), kNumbersPerPiece,
                       [&](std::int64_t begin, std::int64_t end) {
                         const std::size_t first = memory + begin, last = memory + end;
                         if (drift.memory == 0.0) {
                           std::copy(y.begin() + first, y.begin() + last, to.begin() + first);
                           return;
                         }
                         for (std::size_t i = first; i < last; ++i) {
                           to[i] = y[i] + drift.memory * rate[i - lacking];
                         }
                       });
}

void GrainEquations::kick(const std::vector<double>& y, std::span<const RateTerm> terms,
                          std::vector<double>& to) {
  const StageTimer timer(evaluation_.stageSeconds[static_cast<int>(Stage::AdvanceState)]);
  const std::size_t from = evaluation_.layout().firstMomentum();
  const std::size_t lacking = lackingOf(*terms[0].rate, y);  // all are of one stepper
  const auto rateOf = [&](std::size_t term) { return terms[term].rate->data() - lacking; };
  const double w0 = terms[0].weight, w1 = terms[1].weight, w2 = terms.size() > 2 ? terms[2].weight : 0.0;
  const double *r0 = rateOf(0), *r1 = rateOf(1), *r2 = terms.size() > 2 ? rateOf(2) : nullptr;
  executor().forRanges(static_cast<std::int64_t>(evaluation_.stateSize() - from), kNumbersPerPiece,
                       [&](std::int64_t begin, std::int64_t end) {
                         const std::size_t last = from + end;
                         if (r2 == nullptr) {
                           for (std::size_t i = from + begin; i < last; ++i)
                             to[i] = y[i] + w0 * r0[i] + w1 * r1[i];
                         } else {
                           for (std::size_t i = from + begin; i < last; ++i) {
                             to[i] = y[i] + w0 * r0[i] + w1 * r1[i] + w2 * r2[i];
                           }
                         }
                       });
}

void GrainEquations::predict(const Prediction& prediction, const std::vector<double>& y,
                             std::vector<double>& to) {
  const StageTimer timer(evaluation_.stageSeconds[static_cast<int>(Stage::AdvanceState)]);
  const std::size_t first = evaluation_.layout().firstMomentum();
  // A tenth more than is known, as modes that are damped by more than is taken for them grow. Of products
  // with the step beyond 4 that is so of those that are damped by little (from the roots of the scheme).
  constexpr double kOfKnown = 1.1, kLargest = 4.0;
  const double h = prediction.h, ratio = prediction.ratio;
  using Momenta = Eigen::Matrix<double, state::kMomentaSize, 1>;
  executor().forRanges(
      evaluation_.layout().dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t place = begin; place < end; ++place) {
          const auto of = [&](const double* numbers) {
            return Eigen::Map<const Momenta>(numbers + place * state::kMomentaSize);
          };
          const auto a = of(prediction.rate->data()), aBefore = of(prediction.rateBefore->data());
          const auto p = of(prediction.momenta->data()), pBefore = of(prediction.momentaBefore->data());
          const auto v = of(y.data() + first);
          const double damping = evaluation_.dampingRate(static_cast<std::int32_t>(place));
          const double x = 0.5 * std::min(kLargest, kOfKnown * h * damping);
          const double share = 1.0 / (1.0 + x);
          Eigen::Map<Momenta>(to.data() + first + place * state::kMomentaSize) =
              v + share * (h * a + 0.5 * h * ratio * (a - aBefore) + x * (p - v + ratio * (p - pBefore)));
        }
      });
}

void GrainEquations::carry(std::span<const RateTerm> terms, std::vector<double>& to) {
  const StageTimer timer(evaluation_.stageSeconds[static_cast<int>(Stage::AdvanceState)]);
  const Layout& layout = evaluation_.layout();
  const std::size_t lacking = lackingOf(*terms[0].rate, to);
  CarryArrays arrays{.weights = {}, .rates = {}, .poses = to.data()};
  for (int k = 0; k < 3; ++k) {
    arrays.weights[k] = terms[k].weight;
    arrays.rates[k] = terms[k].rate->data() + (layout.firstMomentum() - lacking);
  }
  executor().forRanges(layout.dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    evaluation_.kernels().carry(arrays, static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end));
    if (layout.movesOnlySpheres) return;
    for (std::int64_t place = begin; place < end; ++place) {
      if (layout.isSphere[place]) continue;  // its orientation places nothing
      Vector3 kick = Vector3::Zero();
      for (const RateTerm& term : terms) {
        kick += term.weight * layout.ratesAt(place, term.rate->data(), lacking).angularMomentum();
      }
      const auto out = layout.numbersAt(place, to.data());
      const Quaternion orientation = out.orientation();
      const Vector3 angle = angularVelocityOf(layout.owners[layout.ownerOfPlace[place]], orientation, kick);
      out.setOrientation((turnBy(angle) * orientation).normalized());
    }
  });
}

void GrainEquations::finish(const std::vector<double>& y, double h, std::vector<double>& to) {
  const StageTimer timer(evaluation_.stageSeconds[static_cast<int>(Stage::AdvanceState)]);
  const Layout& layout = evaluation_.layout();
  executor().forRanges(layout.dynamicCount(), kOwnersPerPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t place = begin; place < end; ++place) {
      const Owner& owner = layout.owners[layout.ownerOfPlace[place]];
      const auto own = layout.numbersAt(place, y.data());
      const auto out = layout.numbersAt(place, to.data());
      const Vector3 L = own.angularMomentum();
      const bool isFree = owner.isotropic && !owner.isLocked && L == out.angularMomentum();
      out.setOrientation(isFree ? freelyTurned(own.orientation(), L, owner.inverseInertia, h)
                                : out.orientation().normalized());
    }
  });
}

}  // namespace granular::detail
