// SPDX-License-Identifier: MIT
#include "granular/geometry/mesh_distance.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "granular/geometry/detail/mesh_sides.h"

namespace granular {
namespace {

constexpr std::int32_t kLeafTriangles =
    4;  // more: fewer boxes but more triangles to try; 2 to 8 are about as fast

// A box is skipped only if it is farther than the best triangle by more than the rounding of both distances:
// then the order of the search cannot change which triangle wins.
constexpr double kSkipMargin = 1.0 + 1e-12;

double angleBetween(const Vector3& a, const Vector3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Vector3 unitOrZero(const Vector3& v) {
  const double length = v.norm();
  return length > 0.0 ? Vector3(v / length) : Vector3::Zero();
}

bool hasNoArea(const std::array<Vector3, 3>& c, const Vector3& areaVector) {
  const double longest =
      std::max({(c[1] - c[0]).squaredNorm(), (c[2] - c[1]).squaredNorm(), (c[0] - c[2]).squaredNorm()});
  return !(areaVector.norm() > 1e-12 * longest);
}

}  // namespace

MeshDistance::MeshDistance(const TriangleMesh& mesh, MeshSign sign) : bounds_(boundingBox(mesh)) {
  const MeshReport report = checkMesh(mesh);
  if (!report.isReadable()) throw std::invalid_argument("MeshDistance cannot use the mesh: " + report.text());
  triangles_.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    for (int k = 0; k < 3; ++k) triangles_[t].corner[k] = mesh.vertices[mesh.triangles[t][k]];
    triangles_[t].index = static_cast<std::int32_t>(t);
    triangles_[t].flat = hasNoArea(triangles_[t].corner, doubleAreaVector(mesh, mesh.triangles[t]));
  }
  computeNormals(mesh);
  if (sign == MeshSign::WindingNumber) winding_.emplace(mesh);
  nodes_.reserve(2 * triangles_.size() / kLeafTriangles + 1);
  buildTree(0, static_cast<std::int32_t>(triangles_.size()));
  slotOfTriangle_.resize(triangles_.size());
  for (std::size_t slot = 0; slot < triangles_.size(); ++slot) {
    slotOfTriangle_[triangles_[slot].index] = static_cast<std::int32_t>(slot);
  }
}

/// Faces: their normals. Edges: sum of the normals of the faces that meet there. Corners: sum of the normals
/// of the faces around, each times its angle at the corner (Baerentzen & Aanaes 2002, sec. 3).
void MeshDistance::computeNormals(const TriangleMesh& mesh) {
  std::vector<Vector3> ofVertex(mesh.vertices.size(), Vector3::Zero());
  normals_.resize(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corner = mesh.triangles[t];
    const auto& x = triangles_[t].corner;
    const Vector3 normal = triangles_[t].flat ? Vector3::Zero() : unitOrZero(doubleAreaVector(mesh, corner));
    normals_[t][kFace] = normal;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, last = (k + 2) % 3;
      ofVertex[corner[k]] += angleBetween(x[next] - x[k], x[last] - x[k]) * normal;
    }
  }
  const std::vector<detail::MeshSide> sides = detail::sortedSides(mesh.triangles);
  detail::forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    Vector3 sum = Vector3::Zero();
    for (std::size_t i = first; i < last; ++i) sum += normals_[sides[i].triangle][kFace];
    for (std::size_t i = first; i < last; ++i)
      normals_[sides[i].triangle][kEdge0 + sides[i].corner] = unitOrZero(sum);
  });
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) normals_[t][kCorner0 + k] = unitOrZero(ofVertex[mesh.triangles[t][k]]);
  }
}

/// Splits at the median along the longest side of the box of the centroids (here three times as far out).
std::int32_t MeshDistance::buildTree(std::int32_t first, std::int32_t last) {
  const auto self = static_cast<std::int32_t>(nodes_.size());
  TreeNode node;
  node.lower = Vector3::Constant(std::numeric_limits<double>::infinity());
  node.upper = -node.lower;
  Vector3 lowest = node.lower, highest = node.upper;
  const auto centroid = [](const Triangle& t) { return Vector3(t.corner[0] + t.corner[1] + t.corner[2]); };
  for (std::int32_t s = first; s < last; ++s) {
    for (const Vector3& c : triangles_[s].corner) {
      node.lower = node.lower.cwiseMin(c);
      node.upper = node.upper.cwiseMax(c);
    }
    lowest = lowest.cwiseMin(centroid(triangles_[s]));
    highest = highest.cwiseMax(centroid(triangles_[s]));
  }
  nodes_.push_back(node);
  if (last - first <= kLeafTriangles) {
    nodes_[self].first = first;
    nodes_[self].count = last - first;
    return self;
  }
  int axis = 0;
  (highest - lowest).maxCoeff(&axis);
  const std::int32_t middle = first + (last - first) / 2;
  std::nth_element(triangles_.begin() + first, triangles_.begin() + middle, triangles_.begin() + last,
                   [axis](const Triangle& a, const Triangle& b) {
                     const double x = a.corner[0][axis] + a.corner[1][axis] + a.corner[2][axis];
                     const double y = b.corner[0][axis] + b.corner[1][axis] + b.corner[2][axis];
                     return x != y ? x < y : a.index < b.index;
                   });
  buildTree(first, middle);
  nodes_[self].first = buildTree(middle, last);
  return self;
}

/// Nearest point of a triangle. First the inside of the face, where all three barycentric weights of the foot
/// point are positive; otherwise the nearest of the edges beyond which it lies, each with its two ends. (It
/// is never on another edge: a point nearest to one lies beyond it.)
MeshDistance::Candidate MeshDistance::nearestOnTriangle(const Triangle& t, const Vector3& p) {
  const Vector3 u = t.corner[1] - t.corner[0], v = t.corner[2] - t.corner[0], w = p - t.corner[0];
  std::array<bool, 3> isBeyond = {true, true, true};  // edge k
  if (!t.flat) {
    const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), wu = w.dot(u), wv = w.dot(v);
    const double scale = uu * vv - uv * uv;
    const double b = vv * wu - uv * wv, c = uu * wv - uv * wu;
    isBeyond = {!(c > 0.0), !(b + c < scale), !(b > 0.0)};
    if (!isBeyond[0] && !isBeyond[1] && !isBeyond[2]) {
      const Vector3 normal = u.cross(v);
      const double height = w.dot(normal);
      const double squaredNormal = normal.squaredNorm();
      return {height * height / squaredNormal, p - height / squaredNormal * normal, -1, kFace};
    }
  }
  Candidate best{std::numeric_limits<double>::infinity(), Vector3::Zero(), -1, kFace};
  for (int k = 0; k < 3; ++k) {
    if (!isBeyond[k]) continue;
    const Vector3& from = t.corner[k];
    const Vector3 along = t.corner[(k + 1) % 3] - from;
    const double length = along.squaredNorm();
    const double s = (p - from).dot(along);
    Vector3 q;
    Feature feature;
    if (s <= 0.0) {
      q = from;
      feature = static_cast<Feature>(kCorner0 + k);
    } else if (s >= length) {
      q = t.corner[(k + 1) % 3];
      feature = static_cast<Feature>(kCorner0 + (k + 1) % 3);
    } else {
      q = from + s / length * along;
      feature = static_cast<Feature>(kEdge0 + k);
    }
    const double d = (p - q).squaredNorm();
    if (d < best.squaredDistance) best = {d, q, -1, feature};
  }
  return best;
}

double MeshDistance::squaredDistanceToBox(const TreeNode& node, const Vector3& p) {
  return (node.lower - p).cwiseMax(p - node.upper).cwiseMax(0.0).squaredNorm();
}

/// Keeps the nearer one; of two equally near ones that with the lower mesh index.
void MeshDistance::consider(std::int32_t slot, const Vector3& p, Candidate& best) const {
  Candidate c = nearestOnTriangle(triangles_[slot], p);
  c.slot = slot;
  const bool nearer = c.squaredDistance < best.squaredDistance;
  const bool tie = c.squaredDistance == best.squaredDistance && best.slot >= 0 &&
                   triangles_[slot].index < triangles_[best.slot].index;
  if (nearer || tie) best = c;
}

std::optional<NearestPoint> MeshDistance::nearestWithin(const Vector3& p, double distance,
                                                        std::int32_t hint) const {
  Candidate best{distance * distance, Vector3::Zero(), -1, kFace};
  if (hint >= 0) consider(slotOfTriangle_[hint], p, best);

  struct Visit {
    std::int32_t node;
    double squaredDistance;
  };
  std::array<Visit, 64> stack;  // twice the depth of a tree of 2^31 triangles
  int depth = 0;
  stack[depth++] = {0, squaredDistanceToBox(nodes_[0], p)};
  while (depth > 0) {
    const Visit visit = stack[--depth];
    if (visit.squaredDistance > best.squaredDistance * kSkipMargin) continue;
    const TreeNode& node = nodes_[visit.node];
    if (node.count > 0) {
      for (std::int32_t s = node.first; s < node.first + node.count; ++s) consider(s, p, best);
      continue;
    }
    Visit nearChild{visit.node + 1, squaredDistanceToBox(nodes_[visit.node + 1], p)};
    Visit farChild{node.first, squaredDistanceToBox(nodes_[node.first], p)};
    if (farChild.squaredDistance < nearChild.squaredDistance) std::swap(nearChild, farChild);
    stack[depth++] = farChild;
    stack[depth++] = nearChild;
  }
  if (best.slot < 0) return std::nullopt;
  return finish(best, p);
}

NearestPoint MeshDistance::nearest(const Vector3& p, std::int32_t hint) const {
  return *nearestWithin(p, std::numeric_limits<double>::infinity(), hint);
}

NearestPoint MeshDistance::finish(const Candidate& best, const Vector3& p) const {
  NearestPoint result;
  result.point = best.point;
  result.triangle = triangles_[best.slot].index;
  result.normal = normals_[result.triangle][best.feature];
  const double distance = std::sqrt(best.squaredDistance);
  if (winding_) {
    result.signedDistance = winding_->isInside(p) ? -distance : distance;
  } else {
    result.signedDistance = std::copysign(distance, (p - best.point).dot(result.normal));
  }
  return result;
}

}  // namespace granular
