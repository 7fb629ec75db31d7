// SPDX-License-Identifier: MIT
#include "granular/contact/pressed_patch.h"

#include <array>
#include <cmath>

namespace granular {
namespace {

/// A corner of what is left of a piece, and how deep it is, m.
struct Corner {
  Vector3 point = Vector3::Zero();
  double depth = 0.0;
};

/// Integrals over projected area.
struct Integrals {
  double one = 0.0, depth = 0.0, square = 0.0;
  Vector3 moment = Vector3::Zero();  // of depth times place

  /// A triangle of projected area `area`; exact, as the depth is linear.
  void add(double area, const Corner& a, const Corner& b, const Corner& c) {
    const double sum = a.depth + b.depth + c.depth;
    one += area;
    depth += area / 3.0 * sum;
    square += area / 12.0 * (a.depth * a.depth + b.depth * b.depth + c.depth * c.depth + sum * sum);
    moment +=
        area / 12.0 * ((a.depth + sum) * a.point + (b.depth + sum) * b.point + (c.depth + sum) * c.point);
  }
};

/// Where the line from one corner to the other meets depth 0: as a fraction, and as a corner.
double fractionTo(const Corner& from, const Corner& to) {
  return from.depth / (from.depth - to.depth);
}
Corner between(const Corner& from, const Corner& to, double s) {
  return {from.point + s * (to.point - from.point), 0.0};
}

/// What is below of a triangle that the surface cuts. `alone` is the corner that has its side to itself.
void addCut(double area, const Corner& alone, const Corner& b, const Corner& c, Integrals& sum,
            double& slope) {
  const double s = fractionTo(alone, b), t = fractionTo(alone, c);
  const Corner onB = between(alone, b, s), onC = between(alone, c, t);
  if (alone.depth > 0.0) {
    sum.add(s * t * area, alone, onB, onC);
    slope += 2.0 * s * t * area / alone.depth;  // both s and t grow in proportion to the depth
  } else {
    sum.add((1.0 - s) * area, onB, b, c);
    sum.add(s * (1.0 - t) * area, onB, c, onC);
    slope -= s * t * area * (2.0 / alone.depth);
  }
}

}  // namespace

PressedPatch pressedPatch(std::span<const SurfacePiece> pieces, const Vector3& from, double distance,
                          const Vector3& N) {
  Integrals sum;
  PressedPatch patch;
  for (const SurfacePiece& piece : pieces) {
    const double area = N.dot(piece.areaVector());
    if (area <= 0.0) continue;
    std::array<Corner, 3> corner;
    int below = 0, alone = 0;
    for (int k = 0; k < 3; ++k) {
      corner[k] = {piece.corners[k], N.dot(piece.corners[k] - from) - distance};
      below += corner[k].depth > 0.0;
    }
    if (below == 0) continue;
    if (below == 3) {
      sum.add(area, corner[0], corner[1], corner[2]);
      continue;
    }
    while ((corner[alone].depth > 0.0) != (below == 1)) ++alone;
    addCut(area, corner[alone], corner[(alone + 1) % 3], corner[(alone + 2) % 3], sum, patch.areaSlope);
  }
  if (!(sum.depth > 0.0 && sum.one > 0.0)) return {};
  patch.area = sum.one;
  patch.depth = sum.depth / sum.one;
  patch.meanSquareDepth = sum.square / sum.one;
  patch.center = sum.moment / sum.depth;
  return patch;
}

}  // namespace granular
