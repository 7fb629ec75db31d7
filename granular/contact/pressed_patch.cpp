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

/// What is below of a triangle of projected area `area`.
void addTriangle(double area, const std::array<Corner, 3>& corner, Integrals& sum, double& slope) {
  int below = 0, alone = 0;
  for (const Corner& c : corner) below += c.depth > 0.0;
  if (below == 0) return;
  if (below == 3) {
    sum.add(area, corner[0], corner[1], corner[2]);
    return;
  }
  while ((corner[alone].depth > 0.0) != (below == 1)) ++alone;
  addCut(area, corner[alone], corner[(alone + 1) % 3], corner[(alone + 2) % 3], sum, slope);
}

/// A triangle cut by four lines has at most seven corners.
struct Polygon {
  std::array<Corner, 8> corner;
  int count = 0;
  void push(const Corner& c) { corner[count++] = c; }
};

/// What of it lies where outside(corner) <= 0, a linear function.
template <class Outside>
Polygon cut(const Polygon& polygon, Outside outside) {
  Polygon kept;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner &from = polygon.corner[i], &to = polygon.corner[(i + 1) % polygon.count];
    const double a = outside(from), b = outside(to);
    if (a <= 0.0) kept.push(from);
    if ((a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0)) {
      const double s = a / (a - b);
      kept.push({from.point + s * (to.point - from.point), from.depth + s * (to.depth - from.depth)});
    }
  }
  return kept;
}

/// What of a triangle is above the face.
Polygon cutToFace(const std::array<Corner, 3>& triangle, const Face& face) {
  Polygon polygon;
  for (const Corner& c : triangle) polygon.push(c);
  for (int k = 0; k < 2; ++k) {
    for (const double sign : {-1.0, 1.0}) {
      polygon = cut(polygon, [&](const Corner& c) {
        return sign * face.along[k].dot(c.point - face.center) - face.half[k];
      });
    }
  }
  return polygon;
}

bool isAbove(const Face& face, const Vector3& p) {
  return std::abs(face.along[0].dot(p - face.center)) <= face.half[0] &&
         std::abs(face.along[1].dot(p - face.center)) <= face.half[1];
}

}  // namespace

Face faceOf(const ExactBox& box, const Vector3& p) {
  int axis = 0;
  const Vector3 outside = p.cwiseAbs() - box.halfSize;
  outside.maxCoeff(&axis);
  Face face;
  face.normal = (p[axis] < 0.0 ? -1.0 : 1.0) * Vector3::Unit(axis);
  face.center = box.halfSize[axis] * face.normal;
  for (int k = 0; k < 2; ++k) {
    const int other = (axis + 1 + k) % 3;
    face.along[k] = Vector3::Unit(other);
    face.half[k] = box.halfSize[other];
  }
  return face;
}

PressedPatch pressedPatch(std::span<const SurfacePiece> pieces, const Vector3& from, double distance,
                          const Vector3& N, const Face* face) {
  Integrals sum;
  PressedPatch patch;
  for (const SurfacePiece& piece : pieces) {
    const double area = N.dot(piece.areaVector());
    if (area <= 0.0) continue;
    std::array<Corner, 3> corner;
    bool isWhole = true;
    for (int k = 0; k < 3; ++k) {
      corner[k] = {piece.corners[k], N.dot(piece.corners[k] - from) - distance};
      isWhole &= face == nullptr || isAbove(*face, piece.corners[k]);
    }
    if (isWhole) {
      addTriangle(area, corner, sum, patch.areaSlope);
      continue;
    }
    const Polygon rest = cutToFace(corner, *face);
    for (int k = 2; k < rest.count; ++k) {
      const std::array<Corner, 3> part{rest.corner[0], rest.corner[k - 1], rest.corner[k]};
      const Vector3 across = (part[1].point - part[0].point).cross(part[2].point - part[0].point);
      addTriangle(0.5 * N.dot(across), part, sum, patch.areaSlope);
    }
  }
  if (!(sum.depth > 0.0 && sum.one > 0.0)) return {};
  patch.area = sum.one;
  patch.depth = sum.depth / sum.one;
  patch.meanSquareDepth = sum.square / sum.one;
  patch.center = sum.moment / sum.depth;
  return patch;
}

}  // namespace granular
