// SPDX-License-Identifier: MIT
#include "granular/contact/pair_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "granular/contact/restitution.h"

namespace granular {
namespace {

const ContactSide kGlass{
    .inverseMass = 100.0, .inverseRadius = 100.0, .youngsModulus = 48e9, .poissonRatio = 0.2};

TEST(EffectiveContact, OfEqualSidesHalvesMassRadiusAndModulus) {
  const EffectiveContact c = effectiveContact(kGlass, kGlass);
  EXPECT_DOUBLE_EQ(c.mass, 0.005);
  EXPECT_DOUBLE_EQ(c.radius, 0.005);
  EXPECT_DOUBLE_EQ(c.modulus, 48e9 / (2.0 * (1.0 - 0.04)));
  EXPECT_DOUBLE_EQ(c.hertzStiffness(), 4.0 / 3.0 * c.modulus * std::sqrt(0.005));
}

TEST(EffectiveContact, AgainstAHeldPlaneKeepsMassAndRadius) {
  const ContactSide plane{
      .inverseMass = 0.0, .inverseRadius = 0.0, .youngsModulus = 48e9, .poissonRatio = 0.2};
  EXPECT_DOUBLE_EQ(effectiveContact(kGlass, plane).mass, 0.01);
  EXPECT_DOUBLE_EQ(effectiveContact(kGlass, plane).radius, 0.01);
}

TEST(Restitution, OfSmallDampingFollowsTheSeries) {
  // 1 - e = C D with C = 0.8 B(0.4 (alpha + 1), 1.5) 1.25^(0.4 (alpha + 1)): work of the damper along the
  // elastic path.
  for (const double alpha : {0.0, 0.25, 0.5}) {
    const double p = 0.4 * (alpha + 1.0);
    const double beta = std::exp(std::lgamma(p) + std::lgamma(1.5) - std::lgamma(p + 1.5));
    const double C = 0.8 * beta * std::pow(1.25, p);
    const double D = 1e-4;
    EXPECT_NEAR((1.0 - restitutionOfDamping(alpha, 1.5, D)) / D, C, 1e-3 * C) << alpha;
  }
}

TEST(Restitution, OfTheClampedLinearSpringIsItsClosedForm) {
  // alpha 0, beta 1 with D = 2 z: e = exp(-z / sqrt(1 - z^2) (pi - atan2(2 z sqrt(1 - z^2), 1 - 2 z^2))).
  for (const double z : {0.05, 0.2, 0.5, 0.8}) {
    const double s = std::sqrt(1.0 - z * z);
    const double expected =
        std::exp(-z / s * (std::numbers::pi - std::atan2(2.0 * z * s, 1.0 - 2.0 * z * z)));
    EXPECT_NEAR(restitutionOfDamping(0.0, 1.0, 2.0 * z), expected, 1e-8) << z;
  }
}

TEST(Restitution, InversionReturnsWhatWasAsked) {
  for (const double alpha : {0.0, 0.25, 0.5}) {
    for (const double e : {0.05, 0.3, 0.5, 0.8, 0.97}) {
      EXPECT_NEAR(restitutionOfDamping(alpha, 1.5, dampingForRestitution(alpha, 1.5, e)), e, 1e-9);
    }
  }
  EXPECT_EQ(dampingForRestitution(0.5, 1.5, 1.0), 0.0);
}

TEST(HertzViscoelastic, NeverPulls) {
  const HertzViscoelastic law{.kr = 1e6, .kd = 500.0};
  EXPECT_EQ(law.force(1e-6, -1.0), 0.0);
  EXPECT_GT(law.force(1e-4, 0.0), 0.0);
}

TEST(HertzViscoelastic, EnergyIsTheIntegralOfTheElasticForce) {
  const HertzViscoelastic law{.kr = 3e5, .kd = 0.0};
  const double xi = 2e-4, d = 1e-8;
  const double slope = (law.elasticEnergy(xi + d) - law.elasticEnergy(xi - d)) / (2.0 * d);
  EXPECT_NEAR(slope, law.elasticForce(xi), 1e-6 * slope);
  EXPECT_DOUBLE_EQ(law.elasticForce(xi), law.force(xi, 0.0));
}

TEST(RegularisedCoulomb, NeverExceedsMuTimesNormal) {
  const RegularisedCoulomb law{.mu = 0.4, .kt = 20.0};
  for (const double speed : {1e-9, 1e-3, 0.1, 3.0, 100.0}) {
    for (const double fn : {0.0, 1e-3, 1.0, 1e4}) {
      const double friction = law.factor(fn, speed) * speed;
      EXPECT_LE(friction, 0.4 * fn * (1.0 + 1e-15));
      EXPECT_LE(friction, 20.0 * speed * (1.0 + 1e-15));
    }
  }
  EXPECT_EQ(law.factor(1.0, 0.0), 20.0);
}

TEST(PairLaw, DefaultViscosityStopsSlidingWithinOneContactTime) {
  const MaterialPair pair = combineMaterials({}, {}, {.restitutionSpeed = 2.0});
  const EffectiveContact c = effectiveContact(kGlass, kGlass);
  const double tc = hertzContactTime(c.hertzStiffness(), c.mass, 2.0);
  EXPECT_DOUBLE_EQ(makePairLaw(pair, kGlass, kGlass).shear.kt, 2.0 / 7.0 * std::numbers::pi * c.mass / tc);
}

TEST(PairLaw, UrgencyIsTheContactTimeOfTheImpactItIsPartOf) {
  const PairLaw law = makePairLaw(combineMaterials({}, {}, {}), kGlass, kGlass);
  const EffectiveContact c = effectiveContact(kGlass, kGlass);
  const double v = 0.7;
  const double deepest = std::pow(1.25 * c.mass * v * v / c.hertzStiffness(), 0.4);
  const double expected = hertzContactTime(c.hertzStiffness(), c.mass, v);
  EXPECT_NEAR(contactTimeOfUrgency(law.urgency(1e-12, v)), expected, 1e-6 * expected);
  EXPECT_NEAR(contactTimeOfUrgency(law.urgency(deepest, 0.0)), expected, 1e-9 * expected);
}

TEST(MaterialPair, TakesGeometricMeansUnlessTold) {
  const MaterialDef a{.restitution = 0.9, .friction = 0.8}, b{.restitution = 0.4, .friction = 0.2};
  EXPECT_DOUBLE_EQ(combineMaterials(a, b, {}).friction, 0.4);
  EXPECT_DOUBLE_EQ(combineMaterials(a, b, {}).restitution, 0.6);
  EXPECT_EQ(combineMaterials(a, b, {.friction = 0.0}).friction, 0.0);
  EXPECT_EQ(combineMaterials(a, a, {}).friction, 0.8);
}

TEST(MaterialDef, RefusesImpossibleValuesByName) {
  const auto message = [](const MaterialDef& def) -> std::string {
    try {
      checkMaterial(def);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({.density = 0.0}), "MaterialDef.density is 0 kg/m^3; it must be finite and > 0");
  EXPECT_EQ(message({.poissonRatio = 0.6}), "MaterialDef.poissonRatio is 0.6; it must be in (-1, 0.5]");
  EXPECT_EQ(message({.restitution = 1.5}), "MaterialDef.restitution is 1.5; it must be in [0.01, 1]");
  EXPECT_NE(message({.youngsModulus = std::nan("")}).find("MaterialDef.youngsModulus is nan Pa"),
            std::string::npos);
  EXPECT_NE(message({.friction = -1.0}), "");
  EXPECT_EQ(message({}), "");
}

}  // namespace
}  // namespace granular
