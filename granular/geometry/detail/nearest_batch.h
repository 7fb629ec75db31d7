// SPDX-License-Identifier: MIT
// Many fixed points that ask again and again for the nearest of a set that changes: where holes are looked
// for, where an envelope is measured. Those that ask are sorted into cells once, and what may be near is
// gathered once a cell instead of once a point.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "granular/base/parallel.h"
#include "granular/geometry/detail/point_grid.h"

namespace granular::detail {

class NearestBatch {
 public:
  struct Answer {
    double distance = 0.0;    ///< m
    std::int32_t index = -1;  ///< of the nearest point, the smallest where several are; -1 beyond the limit
  };

  /// @param cell  edge of a cell, m; about the distance at which neighbours of the changing set lie
  NearestBatch(std::span<const Vector3> asking, double cell);

  std::size_t size() const { return asking_; }

  /// The nearest of `points` to each of those that ask, by their index; {farthest, -1} where none is nearer.
  ///
  /// @param usual  m; answers up to this are cheap
  std::vector<Answer> nearest(std::span<const Vector3> points, double usual, double farthest,
                              const Executor& executor) const;

 private:
  PointGrid grid_;
  std::size_t asking_;
};

}  // namespace granular::detail
