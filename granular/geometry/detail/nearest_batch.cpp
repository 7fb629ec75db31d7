// SPDX-License-Identifier: MIT
#include "granular/geometry/detail/nearest_batch.h"

namespace granular::detail {
namespace {

constexpr std::int64_t kCellsAPiece = 64;  // of parallel work

NearestBatch::Answer nearestOf(std::span<const PointGrid::Entry> points, const Vector3& p, double farthest) {
  NearestBatch::Answer best;
  double least = farthest * farthest;
  for (const PointGrid::Entry& point : points) {
    const double squared = (point.point - p).squaredNorm();
    if (squared < least || (squared == least && point.index < best.index)) {
      least = squared;
      best.index = point.index;
    }
  }
  best.distance = best.index < 0 ? farthest : std::sqrt(least);
  return best;
}

}  // namespace

NearestBatch::NearestBatch(std::span<const Vector3> asking, double cell)
    : grid_(asking, cell), asking_(asking.size()) {}

std::vector<NearestBatch::Answer> NearestBatch::nearest(std::span<const Vector3> points, double usual,
                                                        double farthest, const Executor& executor) const {
  std::vector<Answer> answers(asking_);
  const double near = std::min(usual, farthest);
  const PointGrid grid(points, near);
  executor.forRanges(grid_.cellCount(), kCellsAPiece, [&](std::int64_t begin, std::int64_t end) {
    std::vector<PointGrid::Entry> found;
    for (auto c = static_cast<std::int32_t>(begin); c < end; ++c) {
      const std::span<const PointGrid::Entry> own = grid_.cell(c);
      grid.gatherNear(boxAround(own), near, found);
      for (const auto& e : own) {
        Answer& answer = answers[e.index];
        answer = nearestOf(found, e.point, near);
        if (answer.index >= 0 || near == farthest) continue;
        answer.index = grid.nearestIndex(e.point, farthest);
        answer.distance = answer.index < 0 ? farthest : (points[answer.index] - e.point).norm();
      }
    }
  });
  return answers;
}

}  // namespace granular::detail
