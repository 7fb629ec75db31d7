// SPDX-License-Identifier: MIT
#include "granular/geometry/cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "granular/base/parallel.h"
#include "granular/base/require.h"
#include "granular/geometry/detail/feature_lines.h"
#include "granular/geometry/detail/nearest_batch.h"
#include "granular/geometry/detail/point_grid.h"
#include "granular/geometry/detail/surface_pieces.h"
#include "granular/geometry/detail/surface_samples.h"
#include "granular/geometry/marching_tetrahedra.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/signed_distance_band.h"
#include "granular/geometry/surface_floaters.h"

namespace granular {
namespace {

using detail::SurfacePoint, detail::sampleSurface;

// Of r, the distance between the samples on which holes are measured: all over the iso-surface, and coarser
// all over the mesh, where they matter only if the iso-surface misses a part.
constexpr double kIsoSampleSpacing = 0.3;
constexpr double kMeshSampleSpacing = 0.45;
constexpr double kHoleMargin =
    0.1;  // of r: holes are filled down to this much below the bound, for what lies between samples
constexpr double kFarthestHole = 6.0;  // of r: emptier places than this are not told apart
constexpr double kUsualHole = 1.5;     // of r: nearly every place has a centre this near
constexpr double kAskingCell = 1.5;    // of r, of the cells in which places ask together
constexpr double kThinDepth =
    0.9;  // of half the thickness: far enough from the middle for a clear direction outwards
constexpr double kThinReach =
    0.5;  // of the ball that fits: the other side is as near as this to the point across
constexpr int kMostShrinks = 30;  // of that ball; three or four are usual
constexpr double kResolved =
    0.25;  // of r: where the iso-surface is this near to the true one, it stands for it
constexpr double kClearSlope = 0.5;   // of the band; 1 on a well resolved surface, 0 in the middle of a part
constexpr double kSettled = 1e-9;     // of r: off the offset surface by no more than this
constexpr double kNotSettled = 1e-3;  // of r: off by more than this, the surface is not there
constexpr int kLastFills = 4;         // one is enough where the iso-surface is resolved
constexpr double kAside = 1e-3;       // of r: beside the surface, to see what is on either side
constexpr std::int64_t kItemsAPiece = 512;  // of parallel work

/// CoverDef with every default replaced by its number.
struct Settings {
  double radius, offset, grainRadius, holeBound, density, spacing;
};

Settings settle(const CoverDef& def) {
  requirePositive(def.particleRadius, "CoverDef.particleRadius", "m");
  requireNotNegative(def.smallestGrainRadius, "CoverDef.smallestGrainRadius", "m");
  requirePositive(def.convergence, "CoverDef.convergence", "of particleRadius");
  require(def.maxIterations > 0, "CoverDef.maxIterations", def.maxIterations, "", "> 0");
  require(def.maxFillRounds >= 0, "CoverDef.maxFillRounds", def.maxFillRounds, "", ">= 0");
  require(def.threads > 0, "CoverDef.threads", def.threads, "", "> 0");
  Settings s;
  s.radius = def.particleRadius;
  s.offset = def.offset.value_or(-s.radius);
  require(std::abs(s.offset) <= 1000.0 * s.radius, "CoverDef.offset", s.offset, "m",
          "at most 1000 particleRadius either way");
  s.grainRadius = def.smallestGrainRadius > 0.0 ? def.smallestGrainRadius : s.radius;
  s.holeBound = def.largestHole.value_or(0.5 * s.grainRadius);
  requirePositive(s.holeBound, "CoverDef.largestHole", "m");
  const double evenSpacing = std::numbers::sqrt3 * (s.radius + s.holeBound) / kUnevenness;
  const double hexagonalDensity =
      2.0 * std::numbers::pi / std::numbers::sqrt3 * s.radius * s.radius;  // D spacing^2
  s.density = def.density.value_or(hexagonalDensity / (evenSpacing * evenSpacing));
  requirePositive(s.density, "CoverDef.density", "");
  require(def.sharpEdgeDegrees > 0.0 && def.sharpEdgeDegrees <= 180.0, "CoverDef.sharpEdgeDegrees",
          def.sharpEdgeDegrees, "degrees", "in (0, 180]");
  if (def.edgeParticleRadius) {
    const double edge = *def.edgeParticleRadius;
    require(edge >= s.radius / 3.0 && edge < s.radius, "CoverDef.edgeParticleRadius", edge, "m",
            "at least a third of particleRadius, and smaller than it");
  }
  s.spacing = std::sqrt(hexagonalDensity / s.density);
  return s;
}

void requireAffordable(double area, const Settings& s, std::int64_t maxParticles) {
  const double expected = std::max(s.density, 1.0) * area / (std::numbers::pi * s.radius * s.radius);
  if (expected <= static_cast<double>(maxParticles)) return;
  std::ostringstream text;
  text << "CoverDef.particleRadius is " << s.radius << " m; a surface of " << area << " m^2 would need about "
       << expected << " particles, more than CoverDef.maxParticles = " << maxParticles;
  throw std::invalid_argument(text.str());
}

/// A place where a particle's centre may be, and the offset of the surface through it.
struct Spot {
  Vector3 point;
  double offset;
  bool exact;  // found on the mesh itself, not on the iso-surface, which the voxels may resolve badly here
};

class Coverer {
 public:
  Coverer(const TriangleMesh& mesh, bool hasBuriedParts, const CoverDef& def, const Settings& settings)
      : mesh_(mesh),
        def_(def),
        set_(settings),
        executor_(def.threads),
        exact_(mesh, hasBuriedParts ? MeshSign::WindingNumber : MeshSign::PseudoNormal),
        band_(exact_, {.spacing = set_.radius,
                       .lower = set_.offset - set_.radius,
                       .upper = set_.offset + set_.radius,
                       .threads = def.threads}),
        hasBuriedParts_(hasBuriedParts) {}

  Covering run(CoverReport& report) {
    startFloaters();
    findSpots();
    relax(report);
    measureHoles();
    while (worstHole() > fillBound() && report.fillRounds < def_.maxFillRounds) {
      report.filledParticles += fillHoles();
      relax(report);
      measureHoles();
      ++report.fillRounds;
    }
    removeBuried();
    // What relaxing opens again and again, at edges mostly, is closed by floaters that stay where they are
    // put.
    for (int attempt = 0; attempt < kLastFills && worstHole() > fillBound(); ++attempt) {
      report.filledParticles += fillHoles();
      putOnSurface();
      measureHoles();
    }
    describe(report);
    Covering covering{
        positions_, std::vector<double>(positions_.size(), set_.radius),
        detail::shareSurface(mesh_, {positions_, offsets_, set_.radius, kFarthestHole}, executor_)};
    addEdgeParticles(covering, report);
    return covering;
  }

 private:
  void startFloaters() {
    isoSurface_ = marchingTetrahedra(band_, set_.offset);
    requireAffordable(surfaceArea(isoSurface_), set_, def_.maxParticles);
    positions_ = detail::creasePoints(mesh_, exact_, featureDef(set_.offset, set_.spacing));
    fixed_ = std::ssize(positions_);
    addSeeds(seedFloaters(isoSurface_, set_.radius, set_.density, Random(def_.seed)));
    offsets_.assign(positions_.size(), set_.offset);
    isExact_.assign(positions_.size(), 0);
    hints_.assign(positions_.size(), -1);
  }

  detail::FeatureDef featureDef(double offset, double spacing) const {
    return {.offset = offset, .spacing = spacing, .sharpDegrees = def_.sharpEdgeDegrees};
  }

  /// Of the seeds, the nearest to each particle that has its place already makes room for it.
  void addSeeds(const std::vector<Vector3>& seeds) {
    std::vector<char> isDropped(seeds.size(), 0);
    const double reach = 0.7 * set_.spacing;
    const detail::PointGrid grid(seeds, set_.spacing);
    for (const Vector3& p : positions_) {
      std::int32_t nearest = -1;
      double best = reach * reach;
      grid.forEachNear(p, reach, [&](std::int32_t i, const Vector3& q) {
        const double squared = (q - p).squaredNorm();
        if (!isDropped[i] && squared < best) best = squared, nearest = i;
      });
      if (nearest >= 0) isDropped[nearest] = 1;
    }
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      if (!isDropped[i]) positions_.push_back(seeds[i]);
    }
  }

  /// The mesh near a point has the solid on both sides there: parts overlap.
  bool isBuried(const Vector3& p) const {
    const NearestPoint near = exact_.nearest(p);
    const Vector3 away = p - near.point;
    const Vector3 aside =
        kAside * set_.radius * (away.norm() > kAside * set_.radius ? away.normalized() : near.normal);
    return exact_.nearest(near.point + aside).signedDistance < 0.0 &&
           exact_.nearest(near.point - aside).signedDistance < 0.0;
  }

  /// Particles that no grain can come to.
  void removeBuried() {
    if (!hasBuriedParts_) return;
    std::size_t kept = 0;
    std::int64_t fixedKept = 0;
    for (std::size_t i = 0; i < positions_.size(); ++i) {
      if (isBuried(positions_[i])) continue;
      positions_[kept] = positions_[i];
      offsets_[kept] = offsets_[i];
      isExact_[kept] = isExact_[i];
      hints_[kept] = hints_[i];
      if (std::cmp_less(i, fixed_)) fixedKept = static_cast<std::int64_t>(kept) + 1;
      ++kept;
    }
    fixed_ = fixedKept;
    positions_.resize(kept);
    offsets_.resize(kept);
    isExact_.resize(kept);
    hints_.resize(kept);
    measureHoles();
  }

  /// Where the covering will be asked for holes: all over the iso-surface, and below (or above) the parts of
  /// the mesh that it misses.
  void findSpots() {
    meshSamples_ = sampleSurface(mesh_, std::pow(kMeshSampleSpacing * set_.radius, 2));
    if (hasBuriedParts_)
      std::erase_if(meshSamples_, [&](const SurfacePoint& s) { return isBuried(s.point); });
    std::vector<std::optional<Spot>> missed(meshSamples_.size());
    executor_.forRanges(std::ssize(missed), kItemsAPiece, [&](std::int64_t begin, std::int64_t end) {
      std::int32_t hint = -1;
      std::array<SignedDistanceBand::Cursor, 3> cursors;
      for (std::int64_t i = begin; i < end; ++i) {
        const SurfacePoint& s = meshSamples_[i];
        if (!isOnIsoSurface(s.point + set_.offset * s.normal, cursors)) missed[i] = spotAt(s, hint);
      }
    });
    for (const auto& spot : missed) {
      if (spot) spots_.push_back(*spot);
    }
    for (const SurfacePoint& s : sampleSurface(isoSurface_, std::pow(kIsoSampleSpacing * set_.radius, 2))) {
      spots_.push_back({s.point, set_.offset, false});
    }
    if (hasBuriedParts_) std::erase_if(spots_, [&](const Spot& spot) { return isBuried(spot.point); });
    nearest_.resize(spots_.size());
    std::vector<Vector3> points;
    for (const Spot& spot : spots_) points.push_back(spot.point);
    spotBatch_.emplace(points, kAskingCell * set_.radius);
  }

  /// The iso-surface passes close by: the band crosses the offset with a clear slope.
  bool isOnIsoSurface(const Vector3& p, std::array<SignedDistanceBand::Cursor, 3>& cursors) const {
    const auto at = band_.sample(p, cursors[0]);
    if (!at || at->gradient.norm() < kClearSlope) return false;
    const Vector3 outwards = kResolved * set_.radius * at->gradient.normalized();
    const auto above = band_.sample(p + outwards, cursors[1]), below = band_.sample(p - outwards, cursors[2]);
    return above && below && above->value > set_.offset && below->value < set_.offset;
  }

  /// The spot that belongs to a point of the mesh, if there is one.
  std::optional<Spot> spotAt(const SurfacePoint& s, std::int32_t& hint) const {
    return set_.offset < 0.0 ? spotBelow(s, hint) : spotAbove(s, hint);
  }

  std::optional<Spot> spotAbove(const SurfacePoint& s, std::int32_t& hint) const {
    const Vector3 center = s.point + set_.offset * s.normal;
    if (exact_.nearestWithin(center, set_.offset * (1.0 - 1e-6), hint))
      return std::nullopt;  // in a concave place
    return Spot{center, set_.offset, true};
  }

  /// Shrinks a ball that touches the surface in s from within until it touches elsewhere too (the shrinking
  /// ball of Ma, Bae & Choi 2012); a touch close to s, as faceted surfaces have everywhere, does not count.
  /// At full size the centre is on the offset surface. Smaller, the part is thin if its other side is near
  /// the point across the ball from s; otherwise s is near an edge, which its surroundings cover.
  std::optional<Spot> spotBelow(const SurfacePoint& s, std::int32_t& hint) const {
    double depth = -set_.offset;
    std::optional<NearestPoint> hit;
    for (int attempt = 0; attempt < kMostShrinks; ++attempt) {
      hit = exact_.nearestWithin(s.point - depth * s.normal, depth * (1.0 - 1e-6), hint);
      if (!hit) break;
      hint = hit->triangle;
      const Vector3 across = s.point - hit->point;
      const double height = across.dot(s.normal);
      if (!(height > 0.0)) return std::nullopt;
      const double smaller = 0.5 * across.squaredNorm() / height;
      if (across.norm() < smaller) break;  // seen from the centre less than 60 degrees from s
      depth = std::min(depth, smaller);
    }
    if (depth == -set_.offset)
      return hit ? std::nullopt : std::optional(Spot{s.point - depth * s.normal, set_.offset, true});
    if (!exact_.nearestWithin(s.point - 2.0 * depth * s.normal, kThinReach * depth, hint))
      return std::nullopt;
    const Vector3 middle = s.point - kThinDepth * depth * s.normal;
    return Spot{middle, exact_.nearest(middle, hint).signedDistance, true};
  }

  SurfaceSample exactSurface(std::int32_t i, const Vector3& p) {
    const NearestPoint near = exact_.nearest(p, hints_[i]);
    hints_[i] = near.triangle;
    const bool clear = std::abs(near.signedDistance) > kSettled * set_.radius;
    return {near.signedDistance - offsets_[i],
            clear ? Vector3((p - near.point) / near.signedDistance) : near.normal};
  }

  /// The paper's way: value and normal from the band. A floater that comes where the band has no clear slope
  /// follows the exact distance from then on: going to and fro between the two it would never come to rest.
  SurfaceSample surface(std::int32_t i, const Vector3& p) {
    if (!isExact_[i]) {
      const auto s = band_.sample(p, cursors_[i]);
      const double slope = s ? s->gradient.norm() : 0.0;
      if (slope > kClearSlope) return {s->value - offsets_[i], s->gradient / slope};
      isExact_[i] = 1;
    }
    return exactSurface(i, p);
  }

  void relax(CoverReport& report) {
    cursors_.assign(positions_.size(), {});
    const FloaterReport floaters =
        relaxFloaters(positions_, [this](std::int32_t i, const Vector3& p) { return surface(i, p); },
                      {.spacing = set_.spacing,
                       .convergence = def_.convergence * set_.radius,
                       .maxIterations = def_.maxIterations,
                       .fixed = fixed_,
                       .threads = def_.threads});
    cursors_ = {};
    report.iterations += floaters.iterations;
    report.converged = floaters.converged;
    putOnSurface();
  }

  void putOnSurface() {
    executor_.forRanges(static_cast<std::int64_t>(positions_.size()), kItemsAPiece,
                        [&](std::int64_t begin, std::int64_t end) {
                          for (std::int64_t i = begin; i < end; ++i)
                            putOnSurface(static_cast<std::int32_t>(i));
                        });
  }

  /// Newton's method on the exact distance. Where the part turns out too thin to hold the offset surface, the
  /// spot that belongs to the nearest point of the mesh.
  void putOnSurface(std::int32_t i) {
    Vector3& p = positions_[i];
    SurfaceSample s = exactSurface(i, p);
    for (int step = 0; step < 30 && std::abs(s.value) > kSettled * set_.radius; ++step) {
      p -= s.value * s.normal;
      s = exactSurface(i, p);
    }
    if (std::abs(s.value) <= kNotSettled * set_.radius) return;
    const NearestPoint near = exact_.nearest(p, hints_[i]);
    if (const auto spot = spotAt({near.point, near.normal}, hints_[i])) {
      p = spot->point;
      offsets_[i] = spot->offset;
      isExact_[i] = 1;
    }
  }

  /// Distance from each spot to the nearest floater.
  void measureHoles() {
    const auto answers =
        spotBatch_->nearest(positions_, kUsualHole * set_.radius, kFarthestHole * set_.radius, executor_);
    for (std::size_t i = 0; i < answers.size(); ++i) nearest_[i] = answers[i].distance;
  }

  double worstHole() const {
    return nearest_.empty() ? 0.0 : *std::max_element(nearest_.begin(), nearest_.end()) - set_.radius;
  }

  double fillBound() const {
    return std::max(0.5 * set_.holeBound, set_.holeBound - kHoleMargin * set_.radius);
  }

  /// A floater in every hole beyond the bound, the largest first; a spot next to a new floater is no hole any
  /// more.
  std::int64_t fillHoles() {
    const double reach = set_.radius + fillBound();
    std::vector<std::int32_t> holes;
    for (std::size_t i = 0; i < spots_.size(); ++i) {
      if (nearest_[i] > reach) holes.push_back(static_cast<std::int32_t>(i));
    }
    std::stable_sort(holes.begin(), holes.end(),
                     [&](std::int32_t a, std::int32_t b) { return nearest_[a] > nearest_[b]; });
    std::vector<Vector3> points;
    for (std::int32_t h : holes) points.push_back(spots_[h].point);
    const detail::PointGrid grid(points, reach);
    std::vector<char> isFilled(holes.size(), 0);
    const std::size_t before = positions_.size();
    for (std::size_t h = 0; h < holes.size(); ++h) {
      if (isFilled[h]) continue;
      addFloater(spots_[holes[h]]);
      grid.forEachNear(points[h], reach, [&](std::int32_t other, const Vector3& q) {
        if ((q - points[h]).norm() < reach) isFilled[other] = 1;
      });
    }
    return static_cast<std::int64_t>(positions_.size() - before);
  }

  void addFloater(const Spot& spot) {
    positions_.push_back(spot.point);
    offsets_.push_back(spot.offset);
    isExact_.push_back(spot.exact);
    hints_.push_back(-1);
  }

  void describe(CoverReport& report) {
    measureHoles();
    report.particleCount = static_cast<std::int64_t>(positions_.size());
    report.particleRadius = set_.radius;
    report.smallestGrainRadius = set_.grainRadius;
    report.density = set_.density;
    report.largestHole = worstHole();
    report.holeBound = set_.holeBound;
    report.holesClosed = report.largestHole <= report.holeBound;
    report.thinParticles =
        std::count_if(offsets_.begin(), offsets_.end(), [&](double o) { return o != set_.offset; });
    describeSpacing(report);
    findNearestToMesh();
    describeEnvelope(report);
  }

  void describeSpacing(CoverReport& report) const {
    if (positions_.size() < 2) return;
    const detail::PointGrid grid(positions_, set_.spacing);
    std::vector<double> spacing(positions_.size());
    for (std::size_t i = 0; i < spacing.size(); ++i) {
      spacing[i] =
          grid.nearestDistance(positions_[i], kFarthestHole * set_.radius, static_cast<std::int32_t>(i));
    }
    std::sort(spacing.begin(), spacing.end());
    report.spacingMin = spacing.front();
    report.spacingMedian = spacing[spacing.size() / 2];
    report.spacingMax = spacing.back();
  }

  void findNearestToMesh() {
    std::vector<Vector3> points;
    for (const SurfacePoint& s : meshSamples_) points.push_back(s.point);
    const double depth = std::abs(set_.offset);
    nearestToMesh_ = detail::NearestBatch(points, kAskingCell * set_.radius)
                         .nearest(positions_, std::hypot(depth, kUsualHole * set_.radius),
                                  kFarthestHole * set_.radius + depth, executor_);
  }

  /// Smaller particles along the convex edges, where those of radius r cannot reach.
  void addEdgeParticles(Covering& covering, CoverReport& report) const {
    report.edgeParticles = fixed_;
    const double small = def_.edgeParticleRadius.value_or(set_.radius);
    std::vector<Vector3> points;
    if (def_.edgeParticleRadius) {
      points = detail::creasePoints(
          mesh_, exact_, featureDef(set_.offset + set_.radius - small, set_.spacing * small / set_.radius));
      if (hasBuriedParts_) std::erase_if(points, [&](const Vector3& p) { return isBuried(p); });
    }
    report.edgeParticles += std::ssize(points);
    report.particleCount += std::ssize(points);
    for (const Vector3& p : points) {
      covering.positions.push_back(p);
      covering.radii.push_back(small);
    }
    describeEdges(points, small, report);
  }

  void describeEdges(const std::vector<Vector3>& smallOnes, double small, CoverReport& report) const {
    const double apart = kIsoSampleSpacing * set_.radius;
    const std::vector<Vector3> samples = detail::sharpEdgePoints(mesh_, featureDef(0.0, apart));
    if (samples.empty()) return;
    const double farthest = kFarthestHole * set_.radius + std::abs(set_.offset);
    const detail::PointGrid large(positions_, set_.spacing), fine(smallOnes, set_.spacing);
    double sum = 0.0;
    for (const Vector3& p : samples) {
      const double gap = std::min(std::abs(large.nearestDistance(p, farthest) - set_.radius),
                                  std::abs(fine.nearestDistance(p, farthest) - small));
      sum += gap;
      report.edgeMax = std::max(report.edgeMax, gap);
    }
    report.edgeMean = sum / static_cast<double>(samples.size());
    report.edgeLength = apart * static_cast<double>(samples.size());
  }

  void describeEnvelope(CoverReport& report) const {
    double sum = 0.0;
    for (const detail::NearestBatch::Answer& nearest : nearestToMesh_) {
      const double gap = std::abs(nearest.distance - set_.radius);
      sum += gap;
      report.envelopeMax = std::max(report.envelopeMax, gap);
    }
    if (!meshSamples_.empty()) report.envelopeMean = sum / static_cast<double>(meshSamples_.size());
  }

  const TriangleMesh& mesh_;
  const CoverDef& def_;
  Settings set_;
  Executor executor_;
  MeshDistance exact_;
  SignedDistanceBand band_;
  bool hasBuriedParts_;
  std::int64_t fixed_ = 0;  // the first so many floaters have their place
  TriangleMesh isoSurface_;
  std::vector<SurfacePoint> meshSamples_;
  std::vector<Spot> spots_;
  std::optional<detail::NearestBatch> spotBatch_;
  std::vector<double> nearest_;                              // distance from spot i to the nearest floater, m
  std::vector<detail::NearestBatch::Answer> nearestToMesh_;  // floater nearest to mesh sample i
  std::vector<Vector3> positions_;                           // floater i
  std::vector<double> offsets_;                              // of the surface that floater i lives on, m
  std::vector<char> isExact_;  // floater i follows the exact distance instead of the band
  std::vector<SignedDistanceBand::Cursor> cursors_;  // of floater i, while they relax
  std::vector<std::int32_t> hints_;                  // triangle last nearest to floater i
};

}  // namespace

Covering coverMesh(const TriangleMesh& mesh, const CoverDef& def, CoverReport* report) {
  const Settings settings = settle(def);
  CoverReport own;
  const TriangleMesh solid =
      repairMesh(def.sheetThickness ? makeSheet(mesh, *def.sheetThickness) : mesh, &own.repair);
  requireAffordable(surfaceArea(solid), settings, def.maxParticles);
  Covering covering = Coverer(solid, own.repair.buriedTriangles.count > 0, def, settings).run(own);
  if (report) *report = own;
  return covering;
}

void append(Covering& covering, const Covering& more) {
  // Where only one side knows what its particles stand for, neither does.
  const bool bothKnow = (covering.positions.empty() || !covering.pieces.empty()) && !more.pieces.empty();
  if (!bothKnow) covering.pieces.clear();
  const auto before = static_cast<std::int32_t>(covering.positions.size());
  for (SurfacePiece piece : bothKnow ? more.pieces : std::vector<SurfacePiece>{}) {
    piece.particle += before;
    covering.pieces.push_back(piece);
  }
  covering.positions.insert(covering.positions.end(), more.positions.begin(), more.positions.end());
  covering.radii.insert(covering.radii.end(), more.radii.begin(), more.radii.end());
}

void keepOnly(Covering& covering, const std::function<bool(const Vector3&, double)>& keep) {
  Covering kept;
  auto piece = covering.pieces.begin();
  for (std::size_t i = 0; i < covering.positions.size(); ++i) {
    const bool keeps = keep(covering.positions[i], covering.radii[i]);
    for (; piece != covering.pieces.end() && piece->particle == static_cast<std::int32_t>(i); ++piece) {
      if (!keeps) continue;
      kept.pieces.push_back(*piece);
      kept.pieces.back().particle = static_cast<std::int32_t>(kept.positions.size());
    }
    if (!keeps) continue;
    kept.positions.push_back(covering.positions[i]);
    kept.radii.push_back(covering.radii[i]);
  }
  covering = std::move(kept);
}

}  // namespace granular
