// SPDX-License-Identifier: MIT
#include "granular/dynamics/rkf45.h"

namespace granular {

void Rkf45::combine(const Executor& executor, const std::vector<double>& y, double h, const double* weights,
                    int stages, std::vector<double>& out) const {
  executor.forRanges(static_cast<std::int64_t>(y.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) out[i] = 0.0;
    for (int s = 0; s < stages; ++s) {
      if (weights[s] == 0.0) continue;
      const double w = weights[s];
      const double* rate = rates_[s].data();
      for (std::int64_t i = begin; i < end; ++i) out[i] += w * rate[i];
    }
    for (std::int64_t i = begin; i < end; ++i) out[i] = y[i] + h * out[i];
  });
}

void Rkf45::estimateError(const Executor& executor, double h) {
  using T = Rkf45Table;
  executor.forRanges(static_cast<std::int64_t>(error_.size()), kGrain,
                     [&](std::int64_t begin, std::int64_t end) {
                       for (std::int64_t i = begin; i < end; ++i) error_[i] = 0.0;
                       for (int s = 0; s < T::kStages; ++s) {
                         const double w = h * (T::b5[s] - T::b4[s]);
                         if (w == 0.0) continue;
                         const double* rate = rates_[s].data();
                         for (std::int64_t i = begin; i < end; ++i) error_[i] += w * rate[i];
                       }
                     });
}

}  // namespace granular
