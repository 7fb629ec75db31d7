// SPDX-License-Identifier: MIT
// The sides of all triangles of a mesh, sorted so that those of one edge follow one another.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace granular::detail {

/// The side of a triangle that runs from its corner `corner` to the next, by the vertices at its ends.
struct MeshSide {
  std::int32_t low, high;
  std::int32_t triangle;
  std::int8_t corner;
  bool isForward;  // from low to high
};

/// Sides of no length are left out; those of one edge come in the order of the triangles.
inline std::vector<MeshSide> sortedSides(const std::vector<std::array<std::int32_t, 3>>& triangles) {
  std::vector<MeshSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::int8_t k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      if (a != b) sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), k, a < b});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const MeshSide& x, const MeshSide& y) {
    return x.low != y.low ? x.low < y.low : x.high < y.high;
  });
  return sides;
}

/// visit(first, last): sides[first] up to sides[last] are those of one edge.
template <class Visit>
void forEachEdge(const std::vector<MeshSide>& sides, Visit&& visit) {
  for (std::size_t first = 0, last; first < sides.size(); first = last) {
    for (last = first + 1; last < sides.size() && sides[last].low == sides[first].low &&
                           sides[last].high == sides[first].high;) {
      ++last;
    }
    visit(first, last);
  }
}

}  // namespace granular::detail
