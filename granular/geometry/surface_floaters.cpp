// SPDX-License-Identifier: MIT
#include "granular/geometry/surface_floaters.h"

#include <cmath>
#include <numbers>

#include "granular/base/parallel.h"
#include "granular/base/require.h"
#include "granular/geometry/detail/point_grid.h"

namespace granular {
namespace {

// Chosen by the largest hole left on a sphere, a torus and a box, and by how soon they converge. In spacings:
constexpr double kReach = 1.5;  // of the repulsion: the ring of six neighbours; with 2.0 larger holes stay
constexpr double kStep = 0.7;   // repulsion to move; above 1 it takes longer again
constexpr double kLongestMove = 0.3;  // seeds may start nearly on top of one another

// A floater keeps this part of its last move while the push goes the same way; 0 needs several times the
// iterations.
constexpr double kMemory = 0.85;

// When the push turns back, as it does for ever at a sharp edge, the floater's own step is halved, down to
// the least gain; it grows again while the push keeps its direction.
constexpr double kGainLoss = 0.5;
constexpr double kGainGrowth = 1.2;
constexpr double kLeastGain = 1.0 / 256.0;

// Spacings beyond the reach that neighbour lists hold; they last until a floater has moved as far. Two that
// came nearer to each other by twice as much are seen late: then K is 0.04, a third of that between
// neighbours.
constexpr double kListSkin = 0.3;

constexpr std::int64_t kFloatersAPiece = 256;  // of parallel work
constexpr std::int64_t kCellsAPiece = 64;

/// Neighbours of each floater, kept while nobody has moved far.
class NeighbourLists {
 public:
  NeighbourLists(double reach, double skin, const Executor& executor)
      : reach_(reach), skin_(skin), executor_(executor) {}

  void update(std::span<const Vector3> positions) {
    if (isStale(positions)) build(positions);
  }

  std::span<const std::int32_t> of(std::int64_t i) const { return lists_[i]; }

 private:
  bool isStale(std::span<const Vector3> positions) const {
    if (builtAt_.size() != positions.size()) return true;
    const double limit = skin_ * skin_;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if ((positions[i] - builtAt_[i]).squaredNorm() > limit) return true;
    }
    return false;
  }

  /// Cell by cell: what may be near is gathered once for all floaters of a cell.
  void build(std::span<const Vector3> positions) {
    builtAt_.assign(positions.begin(), positions.end());
    const double radius = reach_ + skin_;
    const detail::PointGrid grid(positions, radius);
    lists_.resize(positions.size());
    entries_.resize(Executor::pieceCount(grid.cellCount(), kCellsAPiece));
    executor_.forRanges(grid.cellCount(), kCellsAPiece, [&](std::int64_t begin, std::int64_t end) {
      std::vector<std::int32_t>& entries = entries_[begin / kCellsAPiece];
      std::vector<std::pair<std::int32_t, std::size_t>> starts;  // floater, its first entry
      std::vector<detail::PointGrid::Entry> near;
      entries.clear();
      for (auto c = static_cast<std::int32_t>(begin); c < end; ++c) {
        const std::span<const detail::PointGrid::Entry> floaters = grid.cell(c);
        grid.gatherNear(detail::boxAround(floaters), radius, near);
        for (const auto& own : floaters) {
          starts.emplace_back(own.index, entries.size());
          for (const auto& other : near) {
            if ((other.point - own.point).squaredNorm() < radius * radius && other.index != own.index)
              entries.push_back(other.index);
          }
        }
      }
      for (std::size_t s = 0; s < starts.size(); ++s) {
        const std::size_t last = s + 1 < starts.size() ? starts[s + 1].second : entries.size();
        lists_[starts[s].first] = {entries.data() + starts[s].second, entries.data() + last};
      }
    });
  }

  double reach_, skin_;
  const Executor& executor_;
  std::vector<Vector3> builtAt_;
  std::vector<std::vector<std::int32_t>> entries_;    // of each piece of cells
  std::vector<std::span<const std::int32_t>> lists_;  // of floater i, within entries_
};

/// Sum of K(d) (P - Pi) / d over the neighbours (Bell 2005, eq. 20); no unit.
Vector3 repulsion(std::span<const Vector3> positions, std::int64_t i,
                  std::span<const std::int32_t> neighbours, double reach) {
  Vector3 sum = Vector3::Zero();
  for (std::int32_t j : neighbours) {
    const Vector3 away = positions[i] - positions[j];
    const double d = away.norm();
    if (d >= reach) continue;
    if (d == 0.0) {  // no direction: the two part along x, the surface takes what points out of it
      sum[0] += i < j ? 1.0 : -1.0;
      continue;
    }
    const double k = 1.0 - d / reach;
    sum += k * k / d * away;
  }
  return sum;
}

Vector3 alongSurface(const Vector3& v, const Vector3& normal) {
  return v - normal * normal.dot(v);
}

Vector3 shortened(const Vector3& move, double longest) {
  const double length = move.norm();
  return length > longest ? Vector3(longest / length * move) : move;
}

double rootMeanSquare(std::span<const Vector3> moves) {
  double sum = 0.0;
  for (const Vector3& m : moves) sum += m.squaredNorm();
  return moves.empty() ? 0.0 : std::sqrt(sum / static_cast<double>(moves.size()));
}

Vector3 randomPointIn(const TriangleMesh& mesh, const std::array<std::int32_t, 3>& t, Random& random) {
  double u = random.uniform(), v = random.uniform();
  if (u + v > 1.0) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  const Vector3& a = mesh.vertices[t[0]];
  return a + u * (mesh.vertices[t[1]] - a) + v * (mesh.vertices[t[2]] - a);
}

class Relaxation {
 public:
  Relaxation(std::span<Vector3> positions, const FloaterSurface& surface, const FloaterDef& def)
      : positions_(positions),
        surface_(surface),
        def_(def),
        executor_(def.threads),
        neighbours_(kReach * def.spacing, kListSkin * def.spacing, executor_),
        moves_(positions.size(), Vector3::Zero()),
        gains_(positions.size(), 1.0) {}

  /// Moves all floaters once, each by where the others were before. Returns the root mean square move, m.
  double iterate() {
    neighbours_.update(positions_);
    executor_.forRanges(std::ssize(positions_), kFloatersAPiece, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = std::max(begin, def_.fixed); i < end; ++i) chooseMove(i);
    });
    for (std::size_t i = 0; i < positions_.size(); ++i) positions_[i] += moves_[i];
    return rootMeanSquare(std::span(moves_).subspan(std::min<std::size_t>(def_.fixed, moves_.size())));
  }

 private:
  void chooseMove(std::int64_t i) {
    const SurfaceSample s = surface_(static_cast<std::int32_t>(i), positions_[i]);
    const Vector3 push =
        alongSurface(repulsion(positions_, i, neighbours_.of(i), kReach * def_.spacing), s.normal);
    Vector3 move = alongSurface(kMemory * moves_[i], s.normal);
    if (push.dot(moves_[i]) < 0.0) {
      gains_[i] = std::max(kLeastGain, kGainLoss * gains_[i]);
      move.setZero();
    } else {
      gains_[i] = std::min(1.0, kGainGrowth * gains_[i]);
    }
    move += gains_[i] * kStep * def_.spacing * push - s.value * s.normal;
    moves_[i] = shortened(move, kLongestMove * def_.spacing);
  }

  std::span<Vector3> positions_;
  const FloaterSurface& surface_;
  const FloaterDef& def_;
  Executor executor_;
  NeighbourLists neighbours_;
  std::vector<Vector3> moves_;  // last move of floater i, m
  std::vector<double> gains_;   // part of its full step that floater i takes
};

}  // namespace

std::vector<Vector3> seedFloaters(const TriangleMesh& surface, double particleRadius, double density,
                                  const Random& random) {
  requirePositive(particleRadius, "seedFloaters particleRadius", "m");
  requirePositive(density, "seedFloaters density", "");
  const double discArea = std::numbers::pi * particleRadius * particleRadius;
  std::vector<Vector3> seeds;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    Random own = random.forItem(t);
    const double wanted = density * 0.5 * doubleAreaVector(surface, surface.triangles[t]).norm() / discArea;
    const double whole = std::floor(wanted);
    const auto count = static_cast<std::int64_t>(whole) + (own.uniform() < wanted - whole ? 1 : 0);
    for (std::int64_t n = 0; n < count; ++n)
      seeds.push_back(randomPointIn(surface, surface.triangles[t], own));
  }
  return seeds;
}

FloaterReport relaxFloaters(std::span<Vector3> positions, const FloaterSurface& surface,
                            const FloaterDef& def) {
  requirePositive(def.spacing, "FloaterDef.spacing", "m");
  requirePositive(def.convergence, "FloaterDef.convergence", "m");
  require(def.fixed >= 0, "FloaterDef.fixed", def.fixed, "", ">= 0");
  require(def.threads > 0, "FloaterDef.threads", def.threads, "", "> 0");
  Relaxation relaxation(positions, surface, def);
  FloaterReport report;
  while (report.iterations < def.maxIterations && !report.converged) {
    report.meanMove = relaxation.iterate();
    report.converged = report.meanMove < def.convergence;
    ++report.iterations;
  }
  return report;
}

}  // namespace granular
