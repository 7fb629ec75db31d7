// SPDX-License-Identifier: MIT
// Bodies that meet each other by the particles of each on the exact surface of the other.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "granular/geometry/cover.h"
#include "granular/geometry/mesh_primitives.h"
#include "granular/granular.h"

namespace granular {
namespace {

constexpr double kSide = 1.0;       // m
constexpr double kMass = 1000.0;    // kg
constexpr double kStiffness = 5e7;  // of the foundation, N/m^3
constexpr double kGravity = 9.81;   // m/s^2

class Boxes {
 public:
  explicit Boxes(const SystemDef& def = {.gravity = {0.0, -kGravity, 0.0}}) : system(def) {
    material = system.addMaterial({.name = "stone", .restitution = 0.2, .friction = 0.5});
    system.setMaterialPair(material, material,
                           {.bodyNormal = {.law = NormalLaw::ElasticFoundation, .stiffness = kStiffness},
                            .shear = {.law = ShearLaw::StaticFriction, .dampingRatio = 0.5}});
    covering = coverMesh(makeBox(Vector3::Constant(kSide)), {.particleRadius = 0.12});
  }

  BodyId add(const Vector3& position, BodyMotion motion = BodyMotion::Dynamic) {
    return system.addBody({.motion = motion,
                           .covering = covering,
                           .exact = ExactBox{Vector3::Constant(0.5 * kSide)},
                           .exactUse = ExactUse::Bodies,
                           .material = material,
                           .mass = kMass,
                           .principalInertia = Vector3::Constant(kMass * kSide * kSide / 6.0),
                           .pose = {.position = position}});
  }

  GranularSystem system;
  MaterialId material;
  Covering covering;
};

double vertical(GranularSystem& system, BodyId body) {
  return system.contactWrench(body).force.y();
}

TEST(BodySurface, OfTwoMovingBodiesPressesAsOneFoundation) {
  Boxes boxes;
  const BodyId lower = boxes.add({0, 0, 0});
  const double depth = 1e-3, shift = 0.3;  // the upper one stands half beside
  const BodyId upper = boxes.add({shift, kSide - depth, 0});
  const double whole = kStiffness * kSide * kSide * depth;
  EXPECT_NEAR(vertical(boxes.system, upper), whole * (1.0 - shift), 1e-6 * whole);
  EXPECT_NEAR(vertical(boxes.system, upper), -vertical(boxes.system, lower), 1e-9 * whole);
}

/// What hangs over carries nothing: the torque about the upper one's centre is the force times half the
/// shift.
TEST(BodySurface, OfAnOverhangingBodyCarriesByTheMiddleOfWhatLiesOn) {
  for (const BodyMotion motion : {BodyMotion::Dynamic, BodyMotion::Static}) {
    Boxes boxes;
    boxes.add({0, 0, 0}, motion);
    const double depth = 1e-3, shiftX = 0.37, shiftZ = -0.81;
    const BodyId upper = boxes.add({shiftX, kSide - depth, shiftZ});
    const Wrench wrench = boxes.system.contactWrench(upper);
    const double force = kStiffness * (kSide - shiftX) * (kSide + shiftZ) * depth;
    EXPECT_NEAR(wrench.force.y(), force, 1e-6 * force);
    // At (x, z) from the centre the force (0, f, 0) turns by (-z f, 0, x f).
    EXPECT_NEAR(wrench.torque.z(), -0.5 * shiftX * force, 1e-6 * force);
    EXPECT_NEAR(wrench.torque.x(), 0.5 * shiftZ * force, 1e-6 * force);
  }
}

TEST(BodySurface, FlatOnFlatPressesByTheWholeFace) {
  for (const BodyMotion motion : {BodyMotion::Dynamic, BodyMotion::Kinematic, BodyMotion::Static}) {
    Boxes boxes;
    boxes.add({0, 0, 0}, motion);
    const double depth = 1e-3;
    const BodyId upper = boxes.add({0, kSide - depth, 0});
    EXPECT_NEAR(vertical(boxes.system, upper), kStiffness * kSide * kSide * depth, 1e-6 * kStiffness * depth);
  }
}

TEST(BodySurface, IsLeftAloneByGrains) {
  Boxes boxes;
  boxes.add({0, 0, 0}, BodyMotion::Static);
  // Just above the face, away from particles' tops it would hang in the air if there were none.
  boxes.system.addGrain({.shape = boxes.system.addGrainShape(sphereShape(0.02)),
                         .material = boxes.material,
                         .pose = {.position = {0.03, 0.5 * kSide + 0.019, 0.05}}});
  std::vector<ContactView> contacts;
  boxes.system.readContacts(contacts);
  for (const ContactView& contact : contacts) EXPECT_GE(contact.particle[1], 0);
}

TEST(BodySurface, WithoutParticlesIsRefused) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({});
  EXPECT_THROW(system.addBody({.exact = ExactSphere{1.0}, .exactUse = ExactUse::Bodies, .material = stone}),
               std::invalid_argument);
}

TEST(BodySurface, KeepsMomentumInAnImpactOfTwoBodies) {
  Boxes boxes({.gravity = Vector3::Zero()});
  const BodyId a = boxes.add({0, 0, 0});
  const BodyId b = boxes.add({0.4, 1.01, 0.2});
  boxes.system.setBodyMotion(b, {.pose = {.position = {0.4, 1.01, 0.2}}, .velocity = {0, -1, 0}});
  const StepReport before = boxes.system.measure();
  StepReport after;
  for (int i = 0; i < 20; ++i) after = boxes.system.step(0.01);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum.norm());
  EXPECT_LT((after.angularMomentum - before.angularMomentum).norm(), 1e-4 * before.momentum.norm());
  EXPECT_LT(after.energy.kinetic, before.energy.kinetic);
  EXPECT_LT(boxes.system.bodyMotion(a).velocity.y(), -0.3);
}

/// Columns sink by the compression of their springs, box i by what stands on it.
TEST(BodySurface, CarriesAColumnThatStandsStill) {
  Boxes boxes;
  constexpr int kCount = 5;
  boxes.add({0, -0.5 * kSide, 0}, BodyMotion::Static);
  std::vector<BodyId> column;
  for (int i = 0; i < kCount; ++i) column.push_back(boxes.add({0, (i + 0.5) * kSide, 0}));
  for (int i = 0; i < 150; ++i) boxes.system.step(0.02);
  double sunk = 0.0;
  for (int i = 0; i < kCount; ++i) {
    sunk += (kCount - i) * kMass * kGravity / (kStiffness * kSide * kSide);
    const RigidMotion motion = boxes.system.bodyMotion(column[i]);
    const Vector3 expected(0, (i + 0.5) * kSide - sunk, 0);
    EXPECT_LT((motion.pose.position - expected).norm(), 1e-4 * kSide) << "box " << i;
    EXPECT_LT(motion.velocity.norm(), 1e-4);
  }
}

}  // namespace
}  // namespace granular
