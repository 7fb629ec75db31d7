// SPDX-License-Identifier: MIT
// Points sorted into the cells of a hashed grid, for the question "which are near here". Built once, then
// read only. Neighbours come in an order that depends on the points alone (cell by cell, by index), so sums
// over them are the same bits on any number of threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "granular/base/pose.h"
#include "granular/geometry/detail/lattice_hash.h"

namespace granular::detail {

class PointGrid {
 public:
  /// @param cell  edge of a cell, m; all points within kLatticeReach cells of the first one
  PointGrid(std::span<const Vector3> points, double cell) : cell_(cell), cells_(points.size() / 2) {
    if (!points.empty()) origin_ = points.front();
    std::vector<std::int32_t> cellOf(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Eigen::Vector3i c = cellAt(points[i]);
      cellOf[i] = cells_.findOrInsert(latticeKey(c[0], c[1], c[2]), static_cast<std::int32_t>(cells_.size()));
    }
    first_.assign(cells_.size() + 1, 0);
    for (std::int32_t c : cellOf) ++first_[c + 1];
    for (std::size_t c = 1; c < first_.size(); ++c) first_[c] += first_[c - 1];
    std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
    entries_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
      entries_[next[cellOf[i]]++] = {points[i], static_cast<std::int32_t>(i)};
  }

  /// visit(index, point) for every point nearer than `radius` to p, and some beyond.
  template <class Visit>
  void forEachNear(const Vector3& p, double radius, Visit&& visit) const {
    const Eigen::Vector3i low = cellAt(p - Vector3::Constant(radius)),
                          high = cellAt(p + Vector3::Constant(radius));
    for (int i = low[0]; i <= high[0]; ++i) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int k = low[2]; k <= high[2]; ++k) visitCell(i, j, k, visit);
      }
    }
  }

  /// True if a point is nearer to p than `distance`, m. Cheap where points are dense: it stops at the first
  /// one.
  bool hasPointNearer(const Vector3& p, double distance) const {
    const auto isNearIn = [&](const Eigen::Vector3i& c) {
      bool found = false;
      const auto look = [&](std::int32_t, const Vector3& q) {
        found = found || (q - p).squaredNorm() < distance * distance;
      };
      visitCell(c[0], c[1], c[2], look);
      return found;
    };
    const Eigen::Vector3i own = cellAt(p);
    if (isNearIn(own)) return true;
    const Eigen::Vector3i low = cellAt(p - Vector3::Constant(distance)),
                          high = cellAt(p + Vector3::Constant(distance));
    for (int i = low[0]; i <= high[0]; ++i) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int k = low[2]; k <= high[2]; ++k) {
          if (isNearIn({i, j, k})) return true;
        }
      }
    }
    return false;
  }

  /// Distance from p to the nearest point other than `except`, m; `farthest` if none is nearer than that.
  double nearestDistance(const Vector3& p, double farthest, std::int32_t except = -1) const {
    // A first look one cell around is nearly always enough; only lonely places pay for the wide one.
    const double close = nearestWithin(p, std::min(cell_, farthest), except);
    return close < cell_ || cell_ >= farthest ? close : nearestWithin(p, farthest, except);
  }

  /// Index of the point nearest to p, the smallest where several are; -1 if none is nearer than `farthest`,
  /// m.
  std::int32_t nearestIndex(const Vector3& p, double farthest) const {
    std::int32_t index = -1;
    double best = farthest * farthest;
    for (double radius = std::min(cell_, farthest); index < 0; radius = farthest) {
      best = radius * radius;
      forEachNear(p, radius, [&](std::int32_t i, const Vector3& q) {
        const double squared = (q - p).squaredNorm();
        if (squared < best || (squared == best && i < index)) best = squared, index = i;
      });
      if (radius == farthest) break;
    }
    return index;
  }

  struct Entry {
    Vector3 point;
    std::int32_t index;
  };

  std::int32_t cellCount() const { return static_cast<std::int32_t>(cells_.size()); }

  /// The points of a cell, by index.
  std::span<const Entry> cell(std::int32_t c) const {
    return {entries_.data() + first_[c], entries_.data() + first_[c + 1]};
  }

  /// Lists every point nearer than `reach` to a point of the box, and some beyond, in an order that depends
  /// on the points alone.
  void gatherNear(const Box& box, double reach, std::vector<Entry>& found) const {
    const Vector3 lower = box.lower - Vector3::Constant(reach), upper = box.upper + Vector3::Constant(reach);
    const Eigen::Vector3i low = cellAt(lower), high = cellAt(upper);
    found.clear();
    for (int i = low[0]; i <= high[0]; ++i) {
      for (int j = low[1]; j <= high[1]; ++j) {
        for (int k = low[2]; k <= high[2]; ++k) {
          const std::int32_t c = cells_.find(latticeKey(i, j, k));
          if (c < 0) continue;
          for (const Entry& e : cell(c)) {
            if ((e.point.array() >= lower.array()).all() && (e.point.array() <= upper.array()).all())
              found.push_back(e);
          }
        }
      }
    }
  }

 private:
  Eigen::Vector3i cellAt(const Vector3& p) const {
    return ((p - origin_) / cell_).array().floor().cast<int>();
  }

  template <class Visit>
  void visitCell(int i, int j, int k, Visit& visit) const {
    const std::int32_t c = cells_.find(latticeKey(i, j, k));
    if (c < 0) return;
    for (std::int32_t e = first_[c]; e < first_[c + 1]; ++e) visit(entries_[e].index, entries_[e].point);
  }

  double nearestWithin(const Vector3& p, double radius, std::int32_t except) const {
    double best = radius * radius;
    forEachNear(p, radius, [&](std::int32_t i, const Vector3& q) {
      if (i != except) best = std::min(best, (q - p).squaredNorm());
    });
    return std::sqrt(best);
  }

  double cell_;
  Vector3 origin_ = Vector3::Zero();
  LatticeHash cells_;
  std::vector<std::int32_t> first_;  // cell c holds entries first_[c] .. first_[c + 1]
  std::vector<Entry> entries_;
};

/// Smallest box round the points, at least one.
inline Box boxAround(std::span<const PointGrid::Entry> entries) {
  Box box{entries.front().point, entries.front().point};
  for (const PointGrid::Entry& e : entries) {
    box.lower = box.lower.cwiseMin(e.point);
    box.upper = box.upper.cwiseMax(e.point);
  }
  return box;
}

}  // namespace granular::detail
