// SPDX-License-Identifier: MIT
#include "granular/geometry/signed_distance_band.h"

#include <cmath>
#include <iterator>
#include <limits>

#include "granular/base/require.h"

namespace granular {
namespace {

constexpr std::int64_t kBlocksAPiece = 16;  // of parallel work

constexpr double kHalfDiagonal = 0.8660254037844387;  // of a unit cube: sqrt(3) / 2

// A node farther than this many spacings beyond the band serves no voxel that the band passes through: a
// voxel's diagonal, and a little for rounding.
constexpr double kNodeReach = 2.0 * kHalfDiagonal + 1e-6;

int blockOf(int node) {
  return node >> 2;
}
int insideBlock(int node) {
  return node & 3;
}

/// None of the eight is the mark of a node left out.
bool areKept(const std::array<double, 8>& values) {
  double sum = 0.0;
  for (double v : values) sum += v;
  return !std::isnan(sum);
}

}  // namespace

SignedDistanceBand::SignedDistanceBand(const MeshDistance& mesh, const BandDef& def) : def_(def) {
  const DistanceFunction distance = [&mesh, hint = std::int32_t{-1}](const Vector3& p) mutable {
    const NearestPoint nearest = mesh.nearest(p, hint);
    hint = nearest.triangle;
    return nearest.signedDistance;
  };
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
  // Half a voxel over, so that faces of boxes at whole spacings do not fall on nodes.
  const double margin = std::max(def_.upper, 0.0) + 2.5 * def_.spacing;
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
    constexpr std::int64_t kVoxelsPerBlock = std::int64_t{kBlockEdge} * kBlockEdge * kBlockEdge;
    require(std::ssize(blocks_) * kVoxelsPerBlock <= def_.maxVoxels, "BandDef.maxVoxels", def_.maxVoxels, "",
            "at least the voxels of the band, which are more: raise it, or spacing");
    return;
  }
  const int half = edge / 2;
  for (int child = 0; child < 8; ++child) {
    findBlocks(distance, i + (child & 1) * half, j + (child >> 1 & 1) * half, k + (child >> 2 & 1) * half,
               half);
  }
}

/// Nodes out of reach of the band are left out; that a node is, the last one that was sampled may tell, since
/// a distance changes no faster than one metre a metre.
template <class MakeSampler>
void SignedDistanceBand::sampleBlocks(MakeSampler makeSampler) {
  const auto count = static_cast<std::int64_t>(blocks_.size());
  const double lowest = def_.lower - kNodeReach * def_.spacing,
               highest = def_.upper + kNodeReach * def_.spacing;
  Executor(def_.threads).forRanges(count, kBlocksAPiece, [&](std::int64_t begin, std::int64_t end) {
    auto distanceAt = makeSampler();
    for (std::int64_t b = begin; b < end; ++b) {
      Block& block = blocks_[b];
      Vector3 sampledAt = Vector3::Zero();
      double excess = -1.0;  // by how much the sampled node is out of reach, m
      for (int n = 0; n < kBlockNodes; ++n) {
        const Vector3 p = nodePosition(block.i * kBlockEdge + n % 4, block.j * kBlockEdge + n / 4 % 4,
                                       block.k * kBlockEdge + n / 16);
        block.values[n] = std::numeric_limits<double>::quiet_NaN();
        if (excess > 0.0 && (p - sampledAt).squaredNorm() < excess * excess) continue;
        const double d = distanceAt(p);
        sampledAt = p;
        excess = std::max(lowest - d, d - highest);
        if (excess <= 0.0) block.values[n] = d;
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
  return value && !std::isnan(*value) ? std::optional(*value) : std::nullopt;
}

bool SignedDistanceBand::voxelValues(int i, int j, int k, std::array<double, 8>& values) const {
  const double* first = node(i, j, k);
  if (!first) return false;
  if (insideBlock(i) < 3 && insideBlock(j) < 3 && insideBlock(k) < 3) {
    for (int c = 0; c < 8; ++c) values[c] = first[(c & 1) + 4 * (c >> 1 & 1) + 16 * (c >> 2 & 1)];
    return areKept(values);
  }
  for (int c = 0; c < 8; ++c) {
    const double* value = node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2 & 1));
    if (!value) return false;
    values[c] = *value;
  }
  return areKept(values);
}

std::optional<DistanceSample> SignedDistanceBand::sample(const Vector3& p) const {
  Cursor cursor;
  return sample(p, cursor);
}

std::optional<DistanceSample> SignedDistanceBand::sample(const Vector3& p, Cursor& cursor) const {
  const Vector3 x = (p - origin_) / def_.spacing;
  const Eigen::Array3d base = x.array().floor();
  if (!(base.abs() < detail::kLatticeReach / 2).all()) return std::nullopt;
  const int i = static_cast<int>(base[0]), j = static_cast<int>(base[1]), k = static_cast<int>(base[2]);
  if (!cursor.isSet || cursor.i != i || cursor.j != j || cursor.k != k) {
    cursor.i = i, cursor.j = j, cursor.k = k;
    cursor.isSet = voxelValues(i, j, k, cursor.values);
    if (!cursor.isSet) return std::nullopt;
  }
  const std::array<double, 8>& v = cursor.values;
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

/// The blocks at (0 or 1, 0 or 1, 0 or 1) from this one, x fastest; none where none is kept.
std::array<const SignedDistanceBand::Block*, 8> SignedDistanceBand::blocksFrom(const Block& block) const {
  std::array<const Block*, 8> found;
  for (int c = 0; c < 8; ++c) {
    const std::int32_t b =
        index_.find(detail::latticeKey(block.i + (c & 1), block.j + (c >> 1 & 1), block.k + (c >> 2 & 1)));
    found[c] = b < 0 ? nullptr : &blocks_[b];
  }
  return found;
}

void SignedDistanceBand::forEachVoxel(
    const std::function<void(int, int, int, const std::array<double, 8>&)>& visit) const {
  std::array<double, 8> values;
  for (const Block& block : blocks_) {
    const std::array<const Block*, 8> around = blocksFrom(block);
    for (int n = 0; n < kBlockNodes; ++n) {
      const int i = n % 4, j = n / 4 % 4, k = n / 16;
      bool isKept = true;
      for (int c = 0; c < 8 && isKept; ++c) {
        const int x = i + (c & 1), y = j + (c >> 1 & 1), z = k + (c >> 2 & 1);
        const Block* of = around[x / 4 + 2 * (y / 4) + 4 * (z / 4)];
        isKept = of != nullptr;
        if (isKept) values[c] = of->values[x % 4 + 4 * (y % 4) + 16 * (z % 4)];
      }
      if (isKept && areKept(values)) {
        visit(block.i * kBlockEdge + i, block.j * kBlockEdge + j, block.k * kBlockEdge + k, values);
      }
    }
  }
}

}  // namespace granular
