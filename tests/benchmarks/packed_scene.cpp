// SPDX-License-Identifier: MIT
#include "tests/benchmarks/packed_scene.h"

#include <cmath>

#include "granular/system/fill.h"

namespace granular_bench {
namespace {

using granular::Vector3;

constexpr double kSpread = 0.05;                        // of the radius
constexpr double kReferenceWidth = 0.2;                 // m, of the box
constexpr double kReferenceParticles = 50'000.0;        // in it
constexpr double kClumpSpacing = 1.6;                   // centre distance in a tetrahedron, R
constexpr double kSettlingTime = 0.3, kFlowTime = 0.1;  // s
constexpr double kFrame = 1e-3;                         // s
// Packing need not be exact, and big packings take long: as other DEM codes step, 18.5 % of the Rayleigh
// time.
const granular::IntegratorDef kPackingIntegrator = {.stepper = granular::Stepper::Verlet,
                                                    .fixedSubStep = 4e-5};
const granular::IntegratorDef kSceneIntegrator = {
    .tolerance = 1e-2, .contactTimeFraction = 0.15, .eventContacts = 0};

granular::GrainShapeDef grainShape(bool tetrahedra) {
  if (!tetrahedra) return granular::sphereShape(kPackedRadius);
  granular::GrainShapeDef shape = granular::tetrahedronShape(kPackedRadius);
  for (granular::ShapeParticle& particle : shape.particles) particle.position *= 0.5 * kClumpSpacing;
  return shape;
}

void addWall(granular::GranularSystem& system, granular::MaterialId material, const Vector3& point,
             const Vector3& inward) {
  system.addBody({.exact = granular::HalfSpace{},
                  .material = material,
                  .pose = {point, granular::Quaternion::FromTwoVectors(Vector3::UnitY(), inward)}});
}

void run(granular::GranularSystem& system, double time) {
  for (double t = 0.0; t < time; t += kFrame) system.step(kFrame);
}

/// As many as asked, loose, in a column over the box.
PackedGrains looseGrains(bool tetrahedra, std::int64_t particles) {
  PackedGrains grains;
  grains.shape = grainShape(tetrahedra);
  // The same height for every number of particles, so that pressure and contacts are the same.
  grains.width = kReferenceWidth * std::sqrt(static_cast<double>(particles) / kReferenceParticles);
  const double half = 0.5 * grains.width;
  const granular::GrainShape shape = granular::makeGrainShape(grains.shape);
  for (const granular::PlacedGrain& grain : granular::fillRegion(
           granular::boxRegion({{-half, 0.0, -half}, {half, 10.0 * kReferenceWidth, half}}), grains.shape,
           {.count = particles / static_cast<std::int64_t>(grains.shape.particles.size()),
           .solidFraction = tetrahedra ? 0.35 : 0.5,
           .minScale = 1.0 - kSpread,
           .maxScale = 1.0 + kSpread})) {
    const granular::Quaternion turned = grain.pose.orientation * shape.principalFrame.orientation;
    grains.motions.push_back(
        {.pose = {grain.pose.toWorld(grain.scale * shape.principalFrame.position), turned}});
    grains.scales.push_back(grain.scale);
  }
  return grains;
}

PackedGrains after(double time, PackedGrains grains, const granular::MaterialPairDef& pair, int threads) {
  PackedScene scene = makePackedScene(grains, pair, kPackingIntegrator, threads);
  run(scene.system, time);
  const auto motions = scene.system.grainMotions();
  grains.motions.assign(motions.begin(), motions.end());
  return grains;
}

}  // namespace

PackedGrains packGrains(bool tetrahedra, std::int64_t particles, int threads) {
  return after(kSettlingTime, looseGrains(tetrahedra, particles), {}, threads);
}

PackedGrains letFlow(const PackedGrains& atRest, int threads) {
  PackedGrains open = atRest;
  open.isOpen = true;
  return after(kFlowTime, std::move(open), {}, threads);
}

PackedScene makePackedScene(const PackedGrains& grains, const granular::MaterialPairDef& pair,
                            const granular::IntegratorDef& integrator, int threads) {
  PackedScene scene{granular::GranularSystem({.integrator = integrator, .threads = threads}), {}, {}};
  granular::GranularSystem& system = scene.system;
  scene.material = system.addMaterial({.name = "grain",
                                       .density = 2500.0,
                                       .youngsModulus = 1e7,
                                       .poissonRatio = 0.3,
                                       .restitution = 0.5,
                                       .friction = 0.5});
  system.setMaterialPair(scene.material, scene.material, pair);
  const granular::GrainShapeId shape = system.addGrainShape(grains.shape);
  for (std::size_t i = 0; i < grains.motions.size(); ++i) {
    scene.grains.push_back(
        system.addGrain({.shape = shape, .material = scene.material, .scale = grains.scales[i]}));
    system.setGrainMotion(scene.grains.back(), grains.motions[i]);
  }
  const double half = 0.5 * grains.width;
  addWall(system, scene.material, {0.0, 0.0, 0.0}, Vector3::UnitY());
  addWall(system, scene.material, {-half, 0.0, 0.0}, Vector3::UnitX());
  addWall(system, scene.material, {0.0, 0.0, -half}, Vector3::UnitZ());
  addWall(system, scene.material, {0.0, 0.0, half}, -Vector3::UnitZ());
  if (!grains.isOpen) addWall(system, scene.material, {half, 0.0, 0.0}, -Vector3::UnitX());
  return scene;
}

std::string PackedSceneDef::name() const {
  return std::string(tetrahedra ? "tetra" : "spheres") + (flowing ? ", flowing" : ", at rest") +
         (memory ? ", law 19" : ", law 18");
}

PackedScene makePackedScene(const PackedSceneDef& def) {
  granular::MaterialPairDef pair;
  if (def.memory) pair.shear.law = granular::ShearLaw::StaticFriction;
  PackedGrains grains = after(kSettlingTime, looseGrains(def.tetrahedra, def.particles), pair, def.threads);
  grains.isOpen = def.flowing;
  if (def.flowing) grains = after(kFlowTime, std::move(grains), pair, def.threads);
  return makePackedScene(grains, pair, kSceneIntegrator, def.threads);
}

}  // namespace granular_bench
