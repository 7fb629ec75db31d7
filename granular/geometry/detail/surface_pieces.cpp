// SPDX-License-Identifier: MIT
#include "granular/geometry/detail/surface_pieces.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "granular/geometry/detail/point_grid.h"
#include "granular/geometry/detail/surface_samples.h"

namespace granular::detail {
namespace {

constexpr double kLongPiece = 2.5;      // of r, longest side of a piece: some two or three a particle
constexpr double kSmallPiece = 0.3;     // of r^2: triangles smaller than this are gathered
constexpr double kSampleSpacing = 0.3;  // of r: some forty samples of them a particle
constexpr double kSamePiece = 0.85;     // cosine between normals that are gathered in one piece: 32 degrees
constexpr double kSlimmest = 0.2;  // short over long side of a gathered piece: slimmer comes of few samples
constexpr std::int64_t kItemsAPiece = 512;  // of parallel work

/// Samples of a surface that are about to become one piece of it.
struct PieceSum {
  double count = 0.0;
  Vector3 normal = Vector3::Zero(), point = Vector3::Zero();
  Matrix3 square = Matrix3::Zero();

  void add(const SurfacePoint& s) {
    count += 1.0;
    normal += s.normal;
    point += s.point;
    square += s.point * s.point.transpose();
  }

  /// The rectangle with the area of the samples and, as far as it is not too long, with their spread.
  void addTo(std::vector<SurfacePiece>& pieces, std::int32_t particle, double areaEach) const {
    const Vector3 n = normal.normalized(), middle = point / count;
    Eigen::Matrix<double, 3, 2> axes;
    axes.col(0) = n.unitOrthogonal();
    axes.col(1) = n.cross(axes.col(0));
    const Eigen::Matrix2d spread = axes.transpose() * (square / count - middle * middle.transpose()) * axes;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
    const Vector3 u = axes * solver.eigenvectors().col(0);  // the short side
    const Eigen::Vector2d variance = solver.eigenvalues().cwiseMax(0.0);
    const double aspect = variance[1] > 0.0 ? std::sqrt(variance[0] / variance[1]) : 1.0;
    const double half = 0.5 * std::sqrt(count * areaEach), stretch = std::sqrt(std::max(aspect, kSlimmest));
    const Vector3 halfU = half * stretch * u, halfV = half / stretch * n.cross(u);
    pieces.push_back({particle, {middle - halfU - halfV, middle + halfU - halfV, middle + halfU + halfV}});
    pieces.push_back({particle, {middle - halfU - halfV, middle + halfU + halfV, middle - halfU + halfV}});
  }
};

/// Halves of the longest side, until none is longer than `longest`, m.
void cutUp(const SurfacePiece& piece, double longest, std::vector<SurfacePiece>& pieces) {
  const auto& c = piece.corners;
  const auto side = [&](int k) { return (c[(k + 1) % 3] - c[k]).norm(); };
  int k = side(1) > side(0) ? 1 : 0;
  if (side(2) > side(k)) k = 2;
  if (side(k) <= longest) {
    pieces.push_back(piece);
    return;
  }
  const Vector3 &from = c[k], &to = c[(k + 1) % 3], &across = c[(k + 2) % 3];
  const Vector3 middle = 0.5 * (from + to);
  cutUp({.corners = {from, middle, across}}, longest, pieces);
  cutUp({.corners = {middle, to, across}}, longest, pieces);
}

/// Of each place; -1: none anywhere near.
std::vector<std::int32_t> nearestParticles(const std::vector<Vector3>& places, const CoveringLayer& layer,
                                           const Executor& executor) {
  std::vector<std::int32_t> nearest(places.size());
  const PointGrid grid(layer.positions, 2.0 * layer.radius);
  double depth = 0.0;
  for (const double offset : layer.offsets) depth = std::max(depth, std::abs(offset));
  const double farthest = layer.farthest * layer.radius + depth;
  executor.forRanges(std::ssize(places), kItemsAPiece, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) nearest[i] = grid.nearestIndex(places[i], farthest);
  });
  return nearest;
}

/// The large triangles of the mesh in pieces, the small ones left over.
std::vector<SurfacePiece> takeTriangles(const TriangleMesh& mesh, const CoveringLayer& layer,
                                        const Executor& executor, TriangleMesh& small) {
  std::vector<SurfacePiece> pieces;
  small.vertices = mesh.vertices;
  for (const auto& t : mesh.triangles) {
    const SurfacePiece whole{.corners = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}};
    if (whole.areaVector().norm() < kSmallPiece * layer.radius * layer.radius) {
      small.triangles.push_back(t);
    } else {
      cutUp(whole, kLongPiece * layer.radius, pieces);
    }
  }
  std::vector<Vector3> middles;
  for (const SurfacePiece& p : pieces) middles.push_back((p.corners[0] + p.corners[1] + p.corners[2]) / 3.0);
  const std::vector<std::int32_t> nearest = nearestParticles(middles, layer, executor);
  for (std::size_t i = 0; i < pieces.size(); ++i) pieces[i].particle = nearest[i];
  return pieces;
}

void gatherTriangles(const TriangleMesh& small, const CoveringLayer& layer, const Executor& executor,
                     std::vector<SurfacePiece>& pieces) {
  const std::vector<SurfacePoint> samples = sampleSurface(small, std::pow(kSampleSpacing * layer.radius, 2));
  if (samples.empty()) return;
  const double areaEach = surfaceArea(small) / static_cast<double>(samples.size());
  std::vector<Vector3> places;
  for (const SurfacePoint& s : samples) places.push_back(s.point);
  const std::vector<std::int32_t> nearest = nearestParticles(places, layer, executor);
  std::vector<std::int32_t> order(samples.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::int32_t a, std::int32_t b) { return nearest[a] < nearest[b]; });
  std::vector<PieceSum> sums;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const SurfacePoint& s = samples[order[i]];
    const auto same = std::find_if(sums.begin(), sums.end(), [&](const PieceSum& p) {
      return s.normal.dot(p.normal) > kSamePiece * p.normal.norm();
    });
    (same == sums.end() ? sums.emplace_back() : *same).add(s);
    const std::int32_t particle = nearest[order[i]];
    if (i + 1 < order.size() && nearest[order[i + 1]] == particle) continue;
    for (const PieceSum& sum : sums) sum.addTo(pieces, particle, areaEach);
    sums.clear();
  }
}

}  // namespace

std::vector<SurfacePiece> shareSurface(const TriangleMesh& mesh, const CoveringLayer& layer,
                                       const Executor& executor) {
  TriangleMesh small;
  std::vector<SurfacePiece> pieces = takeTriangles(mesh, layer, executor, small);
  gatherTriangles(small, layer, executor, pieces);
  std::erase_if(pieces, [](const SurfacePiece& piece) { return piece.particle < 0; });
  for (SurfacePiece& piece : pieces) {
    const Vector3 up = (layer.radius + layer.offsets[piece.particle]) * piece.areaVector().normalized();
    for (Vector3& corner : piece.corners) corner += up;
  }
  std::stable_sort(pieces.begin(), pieces.end(),
                   [](const SurfacePiece& a, const SurfacePiece& b) { return a.particle < b.particle; });
  return pieces;
}

}  // namespace granular::detail
