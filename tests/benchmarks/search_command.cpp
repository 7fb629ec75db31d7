// SPDX-License-Identifier: MIT
// granular_bench search: neighbours by the paper's hash as it reads (every particle in its 27 voxels, one
// look-up a query; Bell 2005, sec. 3.2), by the plain one (one voxel, 27 look-ups) and by ours (voxels in
// the order of rows; lists with a margin). All three find the same pairs, or no time is printed. Time
// against how far particles move in a step.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <unordered_map>
#include <vector>

#include "granular/base/random.h"
#include "granular/search/candidate_list.h"
#include "tests/benchmarks/commands.h"

namespace granular_bench {
namespace {

using granular::ParticleRow;
using granular::Vector3;

constexpr double kRadius = 1.0;
constexpr double kSpacing = 2.02;  // radii, of the grid that particles are shaken off
constexpr double kShake = 0.15;    // radii
constexpr double kMargin = 0.15;   // radii, that our list lets a particle go
constexpr double kEdge = 2.0 * kRadius;

struct SearchOptions {
  std::int64_t particles = 50'000;
  int steps = 30;
};

/// Particles that travel at one speed each in directions of their own.
struct Cloud {
  std::vector<ParticleRow> rows;
  std::vector<Vector3> directions;

  explicit Cloud(std::int64_t count) {
    const auto side = static_cast<std::int64_t>(std::ceil(std::cbrt(static_cast<double>(count))));
    granular::Random random(7);
    for (std::int64_t i = 0; i < count; ++i) {
      const auto shaken = [&](std::int64_t at) {
        return kSpacing * static_cast<double>(at) + kShake * (2.0 * random.uniform() - 1.0);
      };
      const double x = shaken(i % side), y = shaken(i / side % side), z = shaken(i / (side * side));
      rows.push_back({x, y, z, kRadius});
      const Vector3 direction(random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5);
      directions.push_back(direction.normalized());
    }
  }
  void move(double way) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].x += way * directions[i].x();
      rows[i].y += way * directions[i].y();
      rows[i].z += way * directions[i].z();
    }
  }
};

bool overlap(const ParticleRow& a, const ParticleRow& b) {
  const double dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z, reach = a.radius + b.radius;
  return dx * dx + dy * dy + dz * dz < reach * reach;
}

using Cell = std::array<int, 3>;
struct CellHash {
  std::size_t operator()(const Cell& c) const {
    std::uint64_t h = 0;
    for (const int at : c) h = (h ^ static_cast<std::uint32_t>(at)) * 0x9e3779b97f4a7c15u;
    return h ^ h >> 29;
  }
};
Cell cellOf(const ParticleRow& p) {
  return {static_cast<int>(std::floor(p.x / kEdge)), static_cast<int>(std::floor(p.y / kEdge)),
          static_cast<int>(std::floor(p.z / kEdge))};
}
template <class Visit>
void forNeighbours(const Cell& c, Visit&& visit) {
  for (int n = 0; n < 27; ++n) visit(Cell{c[0] + n % 3 - 1, c[1] + n / 3 % 3 - 1, c[2] + n / 9 - 1});
}

/// A hash that changes only where a particle crosses a border. isInserted27: as the paper has it.
template <bool isInserted27>
class VoxelSearch {
 public:
  explicit VoxelSearch(const Cloud& cloud) : cells_(cloud.rows.size()) {
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(cells_.size()); ++i) {
      cells_[i] = cellOf(cloud.rows[i]);
      insert(i);
    }
  }
  std::int64_t pairs(const Cloud& cloud) {
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(cells_.size()); ++i) {
      const Cell now = cellOf(cloud.rows[i]);
      if (now == cells_[i]) continue;
      remove(i);
      cells_[i] = now;
      insert(i);
    }
    std::int64_t found = 0;
    for (std::int32_t i = 0; i < static_cast<std::int32_t>(cells_.size()); ++i) {
      const auto test = [&](const Cell& cell) {
        const auto voxel = voxels_.find(cell);
        if (voxel == voxels_.end()) return;
        for (const std::int32_t j : voxel->second) found += j > i && overlap(cloud.rows[i], cloud.rows[j]);
      };
      if constexpr (isInserted27) {
        test(cells_[i]);
      } else {
        forNeighbours(cells_[i], test);
      }
    }
    return found;
  }

 private:
  void insert(std::int32_t i) {
    if constexpr (isInserted27) {
      forNeighbours(cells_[i], [&](const Cell& cell) { voxels_[cell].push_back(i); });
    } else {
      voxels_[cells_[i]].push_back(i);
    }
  }
  void remove(std::int32_t i) {
    const auto from = [&](const Cell& cell) {
      std::vector<std::int32_t>& voxel = voxels_[cell];
      *std::find(voxel.begin(), voxel.end(), i) = voxel.back();
      voxel.pop_back();
    };
    if constexpr (isInserted27) {
      forNeighbours(cells_[i], from);
    } else {
      from(cells_[i]);
    }
  }

  std::vector<Cell> cells_;
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> voxels_;
};

/// The list of the library, made anew when something has moved too far.
class ListSearch {
 public:
  explicit ListSearch(const Cloud& cloud) : own_(cloud.rows.size()), margin_(own_.size(), kMargin) {
    std::iota(own_.begin(), own_.end(), 0);
  }
  std::int64_t pairs(const Cloud& cloud) {
    if (mostMoved(cloud) > kMargin) rebuild(cloud);
    std::int64_t found = 0;
    for (std::size_t i = 0; i < own_.size(); ++i) {
      for (std::int32_t c = list_.rowStart()[i]; c < list_.rowStart()[i + 1]; ++c) {
        found += overlap(cloud.rows[i], cloud.rows[list_.partner()[c]]);
      }
    }
    return found;
  }
  std::int64_t rebuilds = 0;

 private:
  double mostMoved(const Cloud& cloud) const {
    if (listed_.empty()) return std::numeric_limits<double>::infinity();
    double most = 0.0;
    for (std::size_t i = 0; i < listed_.size(); ++i) {
      const double dx = cloud.rows[i].x - listed_[i].x, dy = cloud.rows[i].y - listed_[i].y,
                   dz = cloud.rows[i].z - listed_[i].z;
      most = std::max(most, dx * dx + dy * dy + dz * dz);
    }
    return std::sqrt(most);
  }
  void rebuild(const Cloud& cloud) {
    ++rebuilds;
    listed_ = cloud.rows;
    list_.rebuild({.particles = cloud.rows,
                   .owner = own_,
                   .rank = own_,
                   .dynamicCount = static_cast<std::int32_t>(own_.size()),
                   .rules = &rules_,
                   .margin = margin_},
                  executor_);
  }

  std::vector<std::int32_t> own_;  // everyone is his own owner and rank
  std::vector<double> margin_;
  std::vector<ParticleRow> listed_;
  granular::MeetingRules rules_;
  granular::CandidateList list_;
  granular::Executor executor_{1};
};

/// Nanoseconds a particle and step; the pairs of each step are added to `found`.
template <class Search>
double timeOf(Search& search, const Cloud& start, double way, int steps, std::vector<std::int64_t>& found) {
  Cloud cloud = start;
  double seconds = 0.0;
  search.pairs(cloud);
  for (int step = 0; step < steps; ++step) {
    cloud.move(way);
    const auto begin = std::chrono::steady_clock::now();
    found.push_back(search.pairs(cloud));
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }
  return 1e9 * seconds / (static_cast<double>(steps) * static_cast<double>(start.rows.size()));
}

void runSearch(const SearchOptions& options) {
  const Cloud cloud(options.particles);
  std::printf("%zu particles; ns a particle and step, by way of a particle in a step (radii)\n",
              cloud.rows.size());
  std::printf("%8s %18s %18s %18s %12s %10s\n", "way", "27 insertions", "27 look-ups", "ours", "lists made",
              "pairs");
  for (const double way : {1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3}) {
    VoxelSearch<true> paper(cloud);
    VoxelSearch<false> plain(cloud);
    ListSearch ours(cloud);
    std::array<std::vector<std::int64_t>, 3> found;
    const double t27 = timeOf(paper, cloud, way, options.steps, found[0]);
    const double tPlain = timeOf(plain, cloud, way, options.steps, found[1]);
    const double tOurs = timeOf(ours, cloud, way, options.steps, found[2]);
    if (found[0] != found[1] || found[0] != found[2]) {
      throw std::runtime_error("the three searches do not find the same number of pairs");
    }
    std::printf("%8.0e %18.1f %18.1f %18.1f %12lld %10lld\n", way, t27, tPlain, tOurs,
                static_cast<long long>(ours.rebuilds), static_cast<long long>(found[0].back()));
    std::fflush(stdout);
  }
}

}  // namespace

void addSearchCommand(CLI::App& app, int& status) {
  CLI::App* command =
      app.add_subcommand("search", "The paper's hash, the plain one and ours: time against motion");
  const auto options = std::make_shared<SearchOptions>();
  command->add_option("--particles", options->particles, "particles")
      ->check(CLI::Range(100, 10'000'000))
      ->capture_default_str();
  command->add_option("--steps", options->steps, "steps that are timed")
      ->check(CLI::Range(1, 100'000))
      ->capture_default_str();
  command->callback([options, &status] {
    runSearch(*options);
    status = 0;
  });
}

}  // namespace granular_bench
