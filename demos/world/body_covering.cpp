// SPDX-License-Identifier: MIT
#include "demos/world/body_covering.h"

#include <cmath>
#include <numbers>

#include "bullet_bridge/shape_covering.h"
#include "granular/geometry/mesh_distance.h"
#include "granular/geometry/surface_floaters.h"

namespace granular_demo {
namespace {

using bullet_bridge::PartKind;
using bullet_bridge::ShapePart;
using granular::CoverDef;
using granular::Covering;
using granular::CoverReport;
using granular::MeshDistance;
using granular::TriangleMesh;

constexpr double kRoughnessDensity = 0.3;
constexpr int kRoughnessIterations = 100;  // enough for an even look; a sparse layer creeps on for long

/// Settings for the layer that must hold the grains back.
CoverDef mainLayer(const CoveringPart& def, double smallestGrainRadius, int threads) {
  CoverDef cover;
  cover.particleRadius = def.layer.particleRadius;
  cover.density = def.layer.density;
  cover.offset = def.layer.offset;
  cover.smallestGrainRadius = smallestGrainRadius;
  cover.seed = def.seed;
  cover.threads = threads;
  return cover;
}

/// What is to be covered, in the bridge's terms: a plane patch is ground, which is met from above.
std::vector<ShapePart> partsOf(const BodyShapeDef& shape, const BodySolid& solid) {
  std::vector<ShapePart> parts;
  if (const auto* patch = std::get_if<PlanePatchShape>(&shape)) {
    const double x = 0.5 * patch->sizeX, z = 0.5 * patch->sizeZ;
    parts.push_back({.mesh = {.vertices = {{-x, 0, -z}, {-x, 0, z}, {x, 0, z}, {x, 0, -z}},
                              .triangles = {{0, 1, 2}, {0, 2, 3}}},
                     .kind = PartKind::Ground,
                     .up = Vector3::UnitY()});
    return parts;
  }
  for (const TriangleMesh& part : solid.parts) parts.push_back({.mesh = part, .kind = PartKind::Solid});
  return parts;
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
                                                                    .convergence = CoverDef().convergence * r,
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
  result.covering = bullet_bridge::coverParts(partsOf(shape, solid), main, &result.reports);
  if (def.roughness) {
    granular::append(result.covering, patch ? roughenPatch(*patch, solid, def, threads, result)
                                            : roughenParts(solid, def, threads, result));
  }
  return result;
}

}  // namespace granular_demo
