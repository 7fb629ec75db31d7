// SPDX-License-Identifier: MIT
#include "granular/geometry/marching_tetrahedra.h"

#include <algorithm>
#include <cmath>

#include "granular/base/require.h"

namespace granular {
namespace {

// A vertex keeps this far from the ends of its edge, as a part of its length: otherwise a surface through a
// node would give triangles without area. Larger makes such places rougher.
constexpr double kEndMargin = 1e-3;

// The six tetrahedra around the diagonal from corner 0 to corner 7 of a voxel; corner c is (c & 1, c >> 1 &
// 1, c >> 2). Each goes 0 -> one axis -> two axes -> 7; axes taken in an even order give a right-handed
// tetrahedron.
constexpr int kTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7},
                                   {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}};

class Marcher {
 public:
  Marcher(const SignedDistanceBand& band, double offset) : band_(band), offset_(offset) {}

  void voxel(int i, int j, int k, const std::array<double, 8>& values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    if (*low >= offset_ || *high < offset_) return;
    i_ = i, j_ = j, k_ = k;
    values_ = &values;
    for (const auto& corners : kTetrahedra) tetrahedron(corners);
  }

  TriangleMesh mesh;

 private:
  bool inside(int corner) const { return (*values_)[corner] < offset_; }

  /// One triangle if one corner is alone on its side, two if it is two against two. Swapping corners to bring
  /// the inside ones to the front turns the tetrahedron over when the number of swaps is odd.
  void tetrahedron(const int (&corners)[4]) {
    int c[4] = {corners[0], corners[1], corners[2], corners[3]};
    int insideCount = 0;
    bool turned = false;
    for (int n = 0; n < 4; ++n) {
      if (!inside(c[n])) continue;
      if (n != insideCount) {
        std::swap(c[n], c[insideCount]);
        turned = !turned;
      }
      ++insideCount;
    }
    if (insideCount == 1) triangle(vertex(c[0], c[1]), vertex(c[0], c[2]), vertex(c[0], c[3]), turned);
    if (insideCount == 2) {
      const std::int32_t a = vertex(c[0], c[2]), b = vertex(c[0], c[3]), d = vertex(c[1], c[3]),
                         e = vertex(c[1], c[2]);
      triangle(a, b, d, turned);
      triangle(a, d, e, turned);
    }
    if (insideCount == 3) triangle(vertex(c[3], c[0]), vertex(c[3], c[2]), vertex(c[3], c[1]), !turned);
  }

  void triangle(std::int32_t a, std::int32_t b, std::int32_t c, bool turned) {
    if (turned) std::swap(b, c);
    mesh.triangles.push_back({a, b, c});
  }

  /// The vertex on the edge between two corners. The key is the edge's lower node and its direction: all
  /// edges run from a corner to one whose bits include it.
  std::int32_t vertex(int a, int b) {
    const int from = std::min(a, b), to = std::max(a, b);
    const int i = i_ + (from & 1), j = j_ + (from >> 1 & 1), k = k_ + (from >> 2 & 1);
    const std::uint64_t key = detail::latticeKey(i, j, k) | static_cast<std::uint64_t>(to - from) << 60;
    const auto next = static_cast<std::int32_t>(mesh.vertices.size());
    const std::int32_t found = known_.findOrInsert(key, next);
    if (found == next) {
      const double low = (*values_)[from], high = (*values_)[to];
      const double t = std::clamp((offset_ - low) / (high - low), kEndMargin, 1.0 - kEndMargin);
      const int step = to - from;
      mesh.vertices.push_back(band_.nodePosition(i, j, k) +
                              t * band_.spacing() * Vector3(step & 1, step >> 1 & 1, step >> 2 & 1));
    }
    return found;
  }

  const SignedDistanceBand& band_;
  double offset_;
  int i_ = 0, j_ = 0, k_ = 0;
  const std::array<double, 8>* values_ = nullptr;
  detail::LatticeHash known_;
};

}  // namespace

TriangleMesh marchingTetrahedra(const SignedDistanceBand& band, double offset) {
  require(offset >= band.lower() && offset <= band.upper(), "marchingTetrahedra offset", offset, "m",
          "within the band, " + std::to_string(band.lower()) + " to " + std::to_string(band.upper()));
  Marcher marcher(band, offset);
  band.forEachVoxel(
      [&](int i, int j, int k, const std::array<double, 8>& values) { marcher.voxel(i, j, k, values); });
  return std::move(marcher.mesh);
}

}  // namespace granular
