// SPDX-License-Identifier: MIT
#include "granular/geometry/signed_distance_band.h"

#include <cmath>

#include "granular/base/require.h"

namespace granular {
namespace {

constexpr std::int64_t kBlocksAPiece = 16;  // of parallel work

constexpr double kHalfDiagonal = 0.8660254037844387;  // of a unit cube: sqrt(3) / 2

int blockOf(int node) {
  return node >> 2;
}
int insideBlock(int node) {
  return node & 3;
}

}  // namespace

SignedDistanceBand::SignedDistanceBand(const MeshDistance& mesh, const BandDef& def) : def_(def) {
  const DistanceFunction distance = [&](const Vector3& p) { return mesh.nearest(p).signedDistance; };
  chooseBlocks(distance, mesh.bounds());
  sampleBlocks([&] {
    // Neighbouring nodes are mostly nearest to the same triangle.
    return [&mesh, hint = std::int32_t{-1}](const Vector3& p) mutable {
      const NearestPoint nearest = mesh.nearest(p, hint);
      hint = nearest.triangle;
      return nearest.signedDistance;
    };
  });
}

SignedDistanceBand::SignedDistanceBand(const DistanceFunction& distance, const Box& bounds,
                                       const BandDef& def)
    : def_(def) {
  chooseBlocks(distance, bounds);
  sampleBlocks([&] { return [&distance](const Vector3& p) { return distance(p); }; });
}

void SignedDistanceBand::chooseBlocks(const DistanceFunction& distance, const Box& bounds) {
  requirePositive(def_.spacing, "BandDef.spacing", "m");
  require(std::isfinite(def_.lower), "BandDef.lower", def_.lower, "m", "finite");
  require(std::isfinite(def_.upper) && def_.upper >= def_.lower, "BandDef.upper", def_.upper, "m",
          "finite and >= lower");
  const double margin = std::max(def_.upper, 0.0) + 2.0 * def_.spacing;
  origin_ = bounds.lower - Vector3::Constant(margin);
  const double blockEdge = kBlockEdge * def_.spacing;
  const double blocks = std::ceil((bounds.size().maxCoeff() + 2.0 * margin) / blockEdge);
  require(blocks * kBlockEdge < detail::kLatticeReach, "BandDef.spacing", def_.spacing, "m",
          "at least 1/500000 of the size of the mesh");
  int edge = 1;
  while (edge < blocks) edge *= 2;
  findBlocks(distance, 0, 0, 0, edge);
}

/// Keeps the blocks of the cube of `edge` blocks at block (i, j, k) that the band may reach. A block's nodes
/// serve all voxels that touch them, from one voxel before its first node to one after its last.
void SignedDistanceBand::findBlocks(const DistanceFunction& distance, int i, int j, int k, int edge) {
  const double reach = (edge * kBlockEdge + 1) * def_.spacing;
  const Vector3 center = nodePosition(i * kBlockEdge, j * kBlockEdge, k * kBlockEdge) +
                         Vector3::Constant(0.5 * reach - def_.spacing);
  const double d = distance(center);
  const double slack = kHalfDiagonal * reach;
  if (d < def_.lower - slack || d > def_.upper + slack) return;
  if (edge == 1) {
    index_.findOrInsert(detail::latticeKey(i, j, k), static_cast<std::int32_t>(blocks_.size()));
    blocks_.push_back({i, j, k, {}});
    return;
  }
  const int half = edge / 2;
  for (int child = 0; child < 8; ++child) {
    findBlocks(distance, i + (child & 1) * half, j + (child >> 1 & 1) * half, k + (child >> 2 & 1) * half,
               half);
  }
}

template <class MakeSampler>
void SignedDistanceBand::sampleBlocks(MakeSampler makeSampler) {
  const auto count = static_cast<std::int64_t>(blocks_.size());
  Executor(def_.threads).forRanges(count, kBlocksAPiece, [&](std::int64_t begin, std::int64_t end) {
    auto distanceAt = makeSampler();
    for (std::int64_t b = begin; b < end; ++b) {
      Block& block = blocks_[b];
      for (int n = 0; n < kBlockNodes; ++n) {
        block.values[n] = distanceAt(nodePosition(
            block.i * kBlockEdge + n % 4, block.j * kBlockEdge + n / 4 % 4, block.k * kBlockEdge + n / 16));
      }
    }
  });
}

const double* SignedDistanceBand::node(int i, int j, int k) const {
  const std::int32_t b = index_.find(detail::latticeKey(blockOf(i), blockOf(j), blockOf(k)));
  return b < 0 ? nullptr : &blocks_[b].values[insideBlock(i) + 4 * insideBlock(j) + 16 * insideBlock(k)];
}

std::optional<double> SignedDistanceBand::nodeValue(int i, int j, int k) const {
  const double* value = node(i, j, k);
  return value ? std::optional(*value) : std::nullopt;
}

bool SignedDistanceBand::voxelValues(int i, int j, int k, std::array<double, 8>& values) const {
  const double* first = node(i, j, k);
  if (!first) return false;
  if (insideBlock(i) < 3 && insideBlock(j) < 3 && insideBlock(k) < 3) {
    for (int c = 0; c < 8; ++c) values[c] = first[(c & 1) + 4 * (c >> 1 & 1) + 16 * (c >> 2 & 1)];
    return true;
  }
  for (int c = 0; c < 8; ++c) {
    const double* value = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
    if (!value) return false;
    values[c] = *value;
  }
  return true;
}

std::optional<DistanceSample> SignedDistanceBand::sample(const Vector3& p) const {
  const Vector3 x = (p - origin_) / def_.spacing;
  const Eigen::Array3d base = x.array().floor();
  if (!(base.abs() < detail::kLatticeReach / 2).all()) return std::nullopt;
  std::array<double, 8> v;
  if (!voxelValues(static_cast<int>(base[0]), static_cast<int>(base[1]), static_cast<int>(base[2]), v))
    return std::nullopt;
  const Vector3 f = x - base.matrix();
  // Along x on the four edges, then along y on two, then along z; each with its slope.
  std::array<double, 4> onX, slopeX;
  for (int e = 0; e < 4; ++e) {
    slopeX[e] = v[2 * e + 1] - v[2 * e];
    onX[e] = v[2 * e] + f[0] * slopeX[e];
  }
  const double y0 = onX[0] + f[1] * (onX[1] - onX[0]), y1 = onX[2] + f[1] * (onX[3] - onX[2]);
  const double x0 = slopeX[0] + f[1] * (slopeX[1] - slopeX[0]),
               x1 = slopeX[2] + f[1] * (slopeX[3] - slopeX[2]);
  DistanceSample result;
  result.value = y0 + f[2] * (y1 - y0);
  result.gradient[0] = x0 + f[2] * (x1 - x0);
  result.gradient[1] = (1.0 - f[2]) * (onX[1] - onX[0]) + f[2] * (onX[3] - onX[2]);
  result.gradient[2] = y1 - y0;
  result.gradient /= def_.spacing;
  return result;
}

std::size_t SignedDistanceBand::bytes() const {
  return blocks_.size() * sizeof(Block) + index_.bytes();
}

void SignedDistanceBand::forEachVoxel(
    const std::function<void(int, int, int, const std::array<double, 8>&)>& visit) const {
  std::array<double, 8> values;
  for (const Block& block : blocks_) {
    for (int n = 0; n < kBlockNodes; ++n) {
      const int i = block.i * kBlockEdge + n % 4, j = block.j * kBlockEdge + n / 4 % 4,
                k = block.k * kBlockEdge + n / 16;
      if (voxelValues(i, j, k, values)) visit(i, j, k, values);
    }
  }
}

}  // namespace granular
