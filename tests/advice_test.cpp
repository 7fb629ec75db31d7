// SPDX-License-Identifier: MIT
// Advice: numbers worked out by hand from Hertz's theory, and silence where nothing is unwise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "granular/system/granular_system.h"

namespace granular {
namespace {

constexpr double kRadius = 0.01;

/// Balls of one material on a half-space of another one, stiff and held by static friction: nothing to say.
struct Bed {
  GranularSystem system;
  MaterialDef sand = {.name = "sand", .youngsModulus = 1e10};
  MaterialDef floor = {.name = "floor", .youngsModulus = 1e10};
  MaterialPairDef sandOnSand = {.shear = {.law = ShearLaw::StaticFriction}};
  MaterialPairDef sandOnFloor = sandOnSand;
  int balls = 2;
  MaterialId sandId, floorId;

  std::vector<std::string> advice(double speed) {
    sandId = system.addMaterial(sand);
    floorId = system.addMaterial(floor);
    system.setMaterialPair(sandId, sandId, sandOnSand);
    system.setMaterialPair(sandId, floorId, sandOnFloor);
    const GrainShapeId sphere = system.addGrainShape(sphereShape(kRadius));
    for (int i = 0; i < balls; ++i) {
      system.addGrain({.shape = sphere, .material = sandId, .pose = {.position = {0.0, 1.0 + i, 0.0}}});
    }
    system.addBody({.exact = HalfSpace{}, .material = floorId});
    return system.advice(speed);
  }

  double mass() const { return sand.density * 4.0 / 3.0 * std::numbers::pi * std::pow(kRadius, 3); }
};

std::string shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Advice, IsNoneForStiffGrainsHeldByStaticFriction) {
  EXPECT_EQ(Bed().advice(1.0), std::vector<std::string>());
}

TEST(Advice, NamesTheOverlapOfAHertzImpactAndTheModulusForFivePercent) {
  Bed bed;
  bed.sand.youngsModulus = bed.floor.youngsModulus = 1e7;
  bed.balls = 1;  // it meets the floor alone
  const std::vector<std::string> advice = bed.advice(3.0);
  ASSERT_EQ(advice.size(), 1u);
  // delta = (5 m v^2 / (4 kr))^(2/5), kr = (4/3) E* sqrt(R), E* = E / (2 (1 - nu^2)); E for 5 % from
  // delta ~ E^(-2/5).
  const double kr = 4.0 / 3.0 * 1e7 / (2.0 * (1.0 - 0.09)) * std::sqrt(kRadius);
  const double share = std::pow(1.25 * bed.mass() * 9.0 / kr, 0.4) / kRadius;
  const std::string modulus = shown(1e7 * std::pow(share / 0.05, 2.5)) + " Pa in place of 1e+07 Pa";
  EXPECT_EQ(advice[0], "sand on floor: impacts at 3 m/s overlap by up to " + shown(100.0 * share) +
                           " % of the smaller radius (0.01 m); youngsModulus of sand " + modulus +
                           " and youngsModulus of floor " + modulus + " give 5 %");
}

TEST(Advice, OnTheModulusLeavesNoOverlapToAdviseOn) {
  Bed soft;
  soft.balls = 1;
  const double kr = 4.0 / 3.0 * 1e7 / (2.0 * (1.0 - 0.09)) * std::sqrt(kRadius);
  const double share = std::pow(1.25 * soft.mass() * 9.0 / kr, 0.4) / kRadius;
  soft.sand.youngsModulus = soft.floor.youngsModulus = 1.01 * 1e7 * std::pow(share / 0.05, 2.5);
  EXPECT_TRUE(soft.advice(3.0).empty());
}

TEST(Advice, OnOverlapAgreesWithAnElasticImpactSimulated) {
  Bed bed;
  bed.sand.youngsModulus = bed.floor.youngsModulus = 1e7;
  bed.sand.friction = 0.0;
  bed.sandOnFloor.restitution = 1.0;
  bed.balls = 0;
  bed.advice(3.0);
  bed.system.setGravity(Vector3::Zero());
  bed.system.addGrain({.shape = bed.system.addGrainShape(sphereShape(kRadius)),
                       .material = bed.sandId,
                       .pose = {.position = {0.0, 1.001 * kRadius, 0.0}},
                       .velocity = {0.0, -3.0, 0.0}});
  const double deepest = bed.system.step(0.01).largestOverlap;
  const std::vector<std::string> advice = bed.system.advice(3.0);
  ASSERT_FALSE(advice.empty());
  const std::size_t at = advice[0].find("up to ");
  ASSERT_NE(at, std::string::npos) << advice[0];
  EXPECT_NEAR(std::stod(advice[0].substr(at + 6)), 100.0 * deepest, 0.02 * 100.0 * deepest);
}

TEST(Advice, NamesAGivenStiffnessInPlaceOfTheModulus) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.normal = {.law = NormalLaw::LinearSpring, .stiffness = 1e3};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  // delta = v sqrt(m / kr): k for 5 % is m v^2 / (0.05 R)^2.
  const double wanted = bed.mass() / std::pow(0.05 * kRadius, 2);
  EXPECT_TRUE(advice[0].ends_with("normal.stiffness " + shown(wanted) + " in place of 1e+03 gives 5 %"))
      << advice[0];
}

TEST(Advice, NamesAGivenContactTimeInPlaceOfTheModulus) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.restitution = 1.0;
  bed.sandOnFloor.normal = {.law = NormalLaw::LinearSpring, .contactTime = 0.01};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  // Without losses half a swing is pi sqrt(m / kr), so delta = v t_c / pi.
  const double wanted = std::numbers::pi * 0.05 * kRadius;
  EXPECT_TRUE(advice[0].ends_with("normal.contactTime " + shown(wanted) + " s in place of 0.01 s gives 5 %"))
      << advice[0];
}

/// Sub-step that the contact time of a Hertz impact asks for: a tenth of 2.94 delta / v (Landau & Lifshitz).
double contactSubStep(const Bed& bed, double speed) {
  const double kr = 4.0 / 3.0 * bed.sand.youngsModulus / (2.0 * (1.0 - 0.09)) * std::sqrt(kRadius);
  const double depth = std::pow(1.25 * bed.mass() * speed * speed / kr, 0.4);
  return 0.1 * 2.0 * depth / speed * std::exp(std::lgamma(0.4) + std::lgamma(0.5) - std::lgamma(0.9)) / 2.5;
}

TEST(Advice, NamesAViscosityThatForcesShorterSubStepsThanTheContactTime) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.shear = {.viscosity = 1e4};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  const double mass = 2.0 / 7.0 * bed.mass(), subStep = contactSubStep(bed, 1.0);
  EXPECT_EQ(advice[0], "sand on floor: shear.viscosity is 1e+04 N s/m, which asks for sub-steps of " +
                           shown(3.0 * mass / 1e4) + " s where the contact time does for " + shown(subStep) +
                           " s; at most " + shown(3.0 * mass / subStep) + " N s/m would not");
}

TEST(Advice, SaysWhenAViscosityCannotBeFollowed) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.shear = {.viscosity = 1e12};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_TRUE(advice[0].ends_with("is below smallestSubStep (1e-10 s): it cannot be followed")) << advice[0];
}

TEST(Advice, SaysWhenAnUnboundedViscosityIsUnstable) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.shear = {.law = ShearLaw::Viscous, .viscosity = 1e12};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_TRUE(advice[0].ends_with("the motion is unstable and what touches may be lost")) << advice[0];
}

/// A ball sliding onto the floor for a millisecond under a viscosity that no sub-step can follow.
struct Unfollowed {
  GranularSystem system;
  GrainId ball;
  StepReport report;

  explicit Unfollowed(ShearLaw law) : system({.integrator = {.smallestSubStep = 1e-7, .trialLimit = 20000}}) {
    const MaterialId glass = system.addMaterial({.youngsModulus = 1e8});
    system.setMaterialPair(glass, glass, {.shear = {.law = law, .viscosity = 1e12}});
    system.addBody({.exact = HalfSpace{}, .material = glass});
    ball = system.addGrain({.shape = system.addGrainShape(sphereShape(kRadius)),
                            .material = glass,
                            .pose = {.position = {0.0, 1.0001 * kRadius, 0.0}},
                            .velocity = {1.0, -1.0, 0.0}});
    report = system.step(1e-3);
  }
};

TEST(UnfollowedViscosity, UnderLaw18StaysBoundedByCoulomb) {
  const Unfollowed run(ShearLaw::RegularisedCoulomb);
  ASSERT_TRUE(run.system.isAlive(run.ball));
  EXPECT_LT(run.system.grainMotions()[run.ball.index].velocity.norm(), std::sqrt(2.0))
      << "no energy from nowhere";
}

TEST(UnfollowedViscosity, UnderLaw16IsReported) {
  EXPECT_NE(Unfollowed(ShearLaw::Viscous).report.flags, StepFlag::None);
}

TEST(Advice, NamesAShearStiffnessAndTheOneThatWouldNotForceShorterSubSteps) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.shear = {.law = ShearLaw::StaticFriction, .stiffness = 1e12};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  const double mass = 2.0 / 7.0 * bed.mass(), subStep = contactSubStep(bed, 1.0);
  EXPECT_TRUE(holds(advice[0], "shear.stiffness is 1e+12 N/m, which asks for sub-steps of " +
                                   shown(std::sqrt(mass / 1e12)) + " s"))
      << advice[0];
  EXPECT_TRUE(advice[0].ends_with("at most " + shown(mass / (subStep * subStep)) + " N/m would not"))
      << advice[0];
}

TEST(Advice, NamesANormalDampingThatForcesShorterSubSteps) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.normal = {.law = NormalLaw::HertzConstantDamping, .damping = 1e5};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_TRUE(holds(advice[0], "normal.damping is 1e+05, which asks for sub-steps of " +
                                   shown(3.0 * bed.mass() / 1e5) + " s"))
      << advice[0];
}

TEST(Advice, NamesTheCreepOfLaw18AndBothCures) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.shear = {.viscosity = 2.0};
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  const double weight = bed.mass() * 9.81;
  EXPECT_TRUE(holds(advice[0],
                    "a grain of sand held by one contact on floor creeps at " + shown(weight / 2.0) + " m/s"))
      << advice[0];
  EXPECT_TRUE(holds(advice[0], "static-friction")) << advice[0];
  EXPECT_TRUE(holds(advice[0], "shear.viscosity " + shown(weight / 1e-3) + " N s/m")) << advice[0];
}

TEST(Advice, IsSilentOnCreepWithoutGravity) {
  Bed bed;
  bed.system.setGravity(Vector3::Zero());
  bed.sandOnFloor.shear = {.viscosity = 2.0};
  EXPECT_TRUE(bed.advice(1.0).empty());
}

TEST(Advice, NamesARestitutionBelowAFewPercent) {
  Bed bed;
  bed.balls = 1;
  bed.sandOnFloor.restitution = 0.02;
  const std::vector<std::string> advice = bed.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  EXPECT_TRUE(advice[0].starts_with("sand on floor: restitution is 0.02: ")) << advice[0];
}

TEST(Advice, SpeaksOfPairsThatCanMeetOnly) {
  Bed bed;
  bed.sandOnSand.restitution = 0.02;
  bed.balls = 1;  // no second grain to meet
  EXPECT_TRUE(bed.advice(1.0).empty());
}

TEST(Advice, GivesOneLineForGrainsOfAThousandSizes) {
  Bed bed;
  bed.balls = 0;
  bed.advice(1.0);
  const MaterialId soft = bed.system.addMaterial({.name = "soft", .youngsModulus = 1e6});
  bed.system.setMaterialPair(soft, soft, {.shear = {.law = ShearLaw::StaticFriction}});
  bed.system.setMaterialPair(soft, bed.floorId, {.shear = {.law = ShearLaw::StaticFriction}});
  const GrainShapeId sphere = bed.system.addGrainShape(sphereShape(kRadius));
  for (int i = 0; i < 1000; ++i) {
    bed.system.addGrain({.shape = sphere,
                         .material = soft,
                         .pose = {.position = {0.0, 0.1 * i + 1.0, 0.0}},
                         .scale = 1.0 + 1e-3 * i});
  }
  EXPECT_EQ(bed.system.advice(1.0).size(), 2u) << "soft on soft, soft on floor";
}

TEST(Advice, OnBodiesTakesAllOfOneSideAtOnce) {
  GranularSystem system;
  const MaterialId soft = system.addMaterial({.name = "soft", .youngsModulus = 1e4});
  system.setMaterialPair(soft, soft, {.shear = {.law = ShearLaw::StaticFriction}});
  system.addBody({.exact = HalfSpace{}, .material = soft});
  system.addBody({.motion = BodyMotion::Dynamic,
                  .covering = {.positions = {Vector3::Zero()}, .radii = {kRadius}},
                  .material = soft,
                  .mass = 0.01,
                  .principalInertia = Vector3::Constant(1e-6),
                  .pose = {.position = {0, 1, 0}}});
  const std::vector<std::string> advice = system.advice(1.0);
  ASSERT_EQ(advice.size(), 1u);
  // Elastic foundation k = E* / L per area, L = sqrt(A / 2), A = 2 sqrt(3) R^2 the area that the particle
  // stands for, half of it one side: delta = v sqrt(m L / (E* A / 2)).
  const double area = 2.0 * std::sqrt(3.0) * kRadius * kRadius, length = std::sqrt(0.5 * area);
  const double modulus = 1e4 / (2.0 * (1.0 - 0.09));
  const double depth = std::sqrt(0.01 * length / (modulus * 0.5 * area));
  EXPECT_TRUE(holds(advice[0], "overlap by at least " + shown(100.0 * depth / kRadius) + " %")) << advice[0];
}

TEST(Advice, RefusesASpeedThatIsNone) {
  GranularSystem system;
  EXPECT_THROW(system.advice(-1.0), std::invalid_argument);
  EXPECT_THROW(system.advice(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
}

TEST(Advice, IsNoneForAnEmptySystem) {
  EXPECT_TRUE(GranularSystem().advice(1.0).empty());
}

}  // namespace
}  // namespace granular
