// SPDX-License-Identifier: MIT
#include "demos/body_covering.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/mesh_primitives.h"
#include "granular/geometry/surface_floaters.h"

namespace granular_demo {
namespace {

using granular::CoverDef;
using granular::Covering;
using granular::CoverReport;
using granular::MeshDistance;
using granular::TriangleMesh;

// Floaters stop when they move by less than this, in particle radii. Ten times coarser than coverMesh's
// default and ten times faster on a large floor (5 s instead of 60 s for 16,000 particles); holes are closed
// all the same.
constexpr double kConvergence = 0.02;
constexpr double kRoughnessDensity = 0.3;
constexpr int kRoughnessIterations = 100;  // enough for an even look; a sparse layer creeps on for long

/// Settings for the layer that must hold the grains back.
CoverDef mainLayer(const CoveringPart& def, double smallestGrainRadius, int threads) {
  CoverDef cover;
  cover.particleRadius = def.layer.particleRadius;
  cover.density = def.layer.density;
  cover.offset = def.layer.offset;
  cover.smallestGrainRadius = smallestGrainRadius;
  cover.convergence = kConvergence;
  cover.seed = def.seed;
  cover.threads = threads;
  return cover;
}

/// A plane patch is covered as the upper face of a slab thick enough that the lower face is out of reach.
TriangleMesh slabUnder(const PlanePatchShape& patch, double thickness) {
  TriangleMesh slab = granular::makeBox({patch.sizeX, thickness, patch.sizeZ});
  for (Vector3& v : slab.vertices) v.y() -= 0.5 * thickness;
  return slab;
}

Covering coverPatch(const PlanePatchShape& patch, const CoverDef& def, BodyCovering& result) {
  const double depth = -def.offset.value_or(-def.particleRadius);
  CoverReport report;
  Covering covering = granular::coverMesh(
      slabUnder(patch, 6.0 * def.particleRadius + 2.0 * std::max(0.0, depth)), def, &report);
  granular::keepOnly(covering, [&](const Vector3& p, double r) { return p.y() > -depth - 0.5 * r; });
  report.particleCount = static_cast<std::int64_t>(covering.positions.size());
  result.reports.push_back(report);
  return covering;
}

/// Particles on one part that lie inside another part would never be met.
Covering coverParts(const BodySolid& solid, const CoverDef& def, BodyCovering& result) {
  std::vector<MeshDistance> distances;
  for (const TriangleMesh& part : solid.parts) distances.emplace_back(part);
  const double deepest = std::min(0.0, def.offset.value_or(-def.particleRadius)) - 0.5 * def.particleRadius;
  Covering all;
  for (std::size_t i = 0; i < solid.parts.size(); ++i) {
    CoverReport report;
    Covering covering = granular::coverMesh(solid.parts[i], def, &report);
    granular::keepOnly(covering, [&](const Vector3& p, double) {
      for (std::size_t j = 0; j < distances.size(); ++j) {
        if (j != i && distances[j].nearest(p).signedDistance < deepest) return false;
      }
      return true;
    });
    report.particleCount = static_cast<std::int64_t>(covering.positions.size());
    result.reports.push_back(report);
    granular::append(all, covering);
  }
  return all;
}

/// Distance of neighbours in an even layer of discs of radius r that cover `density` of the area.
double evenSpacing(double r, double density) {
  return r * std::sqrt(2.0 * std::numbers::pi / (std::sqrt(3.0) * density));
}

/// The layer of roughness: floaters alone, since it may be sparse and has no holes to close.
Covering scatter(const TriangleMesh& mesh, const granular::FloaterSurface& surface, const CoveringPart& def,
                 int threads, BodyCovering& result) {
  const LayerDef& layer = *def.roughness;
  const double r = layer.particleRadius;
  const double density = layer.density.value_or(kRoughnessDensity);
  Covering covering;
  covering.positions = granular::seedFloaters(mesh, r, density, granular::Random(def.seed + 1));
  const granular::FloaterReport floaters = granular::relaxFloaters(covering.positions, surface,
                                                                   {.spacing = evenSpacing(r, density),
                                                                    .convergence = kConvergence * r,
                                                                    .maxIterations = kRoughnessIterations,
                                                                    .threads = threads});
  covering.radii.assign(covering.positions.size(), r);
  CoverReport report;
  report.particleRadius = r;
  report.density = density;
  report.iterations = floaters.iterations;
  report.converged = floaters.converged;
  report.particleCount = static_cast<std::int64_t>(covering.positions.size());
  result.reports.push_back(report);
  return covering;
}

Covering roughenPatch(const PlanePatchShape& patch, const BodySolid& solid, const CoveringPart& def,
                      int threads, BodyCovering& result) {
  const double offset = def.roughness->offset.value_or(0.0);
  const auto plane = [offset](std::int32_t, const Vector3& p) {
    return granular::SurfaceSample{p.y() - offset, Vector3::UnitY()};
  };
  Covering covering = scatter(solid.parts.front(), plane, def, threads, result);
  // Floaters at the border have neighbours on one side only and are pushed out: those beyond it go.
  granular::keepOnly(covering, [&](const Vector3& p, double) {
    return std::abs(p.x()) < 0.5 * patch.sizeX && std::abs(p.z()) < 0.5 * patch.sizeZ;
  });
  result.reports.back().particleCount = static_cast<std::int64_t>(covering.positions.size());
  return covering;
}

Covering roughenParts(const BodySolid& solid, const CoveringPart& def, int threads, BodyCovering& result) {
  const double offset = def.roughness->offset.value_or(0.0);
  Covering all;
  for (const TriangleMesh& part : solid.parts) {
    const MeshDistance distance(part);
    const auto surface = [&](std::int32_t, const Vector3& p) {
      const granular::NearestPoint nearest = distance.nearest(p);
      return granular::SurfaceSample{nearest.signedDistance - offset, nearest.normal};
    };
    granular::append(all, scatter(part, surface, def, threads, result));
  }
  return all;
}

}  // namespace

BodyCovering coverSolid(const BodyShapeDef& shape, const BodySolid& solid, const CoveringPart& def,
                        double smallestGrainRadius, int threads) {
  const auto* patch = std::get_if<PlanePatchShape>(&shape);
  const CoverDef main = mainLayer(def, smallestGrainRadius, threads);
  BodyCovering result;
  granular::append(result.covering,
                   patch ? coverPatch(*patch, main, result) : coverParts(solid, main, result));
  if (def.roughness) {
    granular::append(result.covering, patch ? roughenPatch(*patch, solid, def, threads, result)
                                            : roughenParts(solid, def, threads, result));
  }
  return result;
}

}  // namespace granular_demo
