// SPDX-License-Identifier: MIT
#include "granular/contact/pair_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "granular/contact/law_list.h"
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

TEST(Restitution, WithAttractionIsThePapersClosedForm) {
  // Eqs. 9-10: z = -ln e / sqrt(ln^2 e + pi^2).
  for (const double e : {0.2, 0.5, 0.9}) {
    const double z = -std::log(e) / std::hypot(std::log(e), std::numbers::pi);
    EXPECT_NEAR(restitutionOfDamping(0.0, 1.0, 2.0 * z, true), e, 1e-8);
    EXPECT_NEAR(LinearSpring::dampingForRestitution(e, true), z, 1e-15);
  }
}

TEST(LinearSpring, ConstantsGiveTheAskedContactTime) {
  // Integrating the clamped oscillator until the force is gone.
  const NormalRequest request{.contact = {.mass = 0.3, .radius = 0.01, .modulus = 1e7},
                              .damping = LinearSpring::dampingForRestitution(0.4, false),
                              .def = {.law = NormalLaw::LinearSpring, .contactTime = 2e-3}};
  const NormalConstants c = LinearSpring::constants(request);
  double x = 0.0, v = 1.0, t = 0.0;
  const double h = 1e-8;
  while (t < 1e-6 || LinearSpring::force(c, x, v) > 0.0) {
    const double xm = x + 0.5 * h * v, vm = v - 0.5 * h * LinearSpring::force(c, x, v) / 0.3;
    x += h * vm, v -= h * LinearSpring::force(c, xm, vm) / 0.3, t += h;
  }
  EXPECT_NEAR(t, 2e-3, 1e-7);
  EXPECT_NEAR(-v, 0.4, 1e-4);
}

TEST(ElasticFoundation, ReboundDependsOnSpeedAndDampingAlone) {
  // m v dv = -k x (1 + a v) dx integrated for two masses and stiffnesses.
  const double e = 0.6, speed = 2.0, a = ElasticFoundation::dampingForRestitution(e, false) / speed;
  for (const auto& pair : {std::pair(1.0, 1e4), std::pair(50.0, 3e7)}) {
    const double m = pair.first, k = pair.second;
    double x = 0.0, v = speed;
    const double h = 1e-5 * std::sqrt(m / k);
    do {
      const auto rate = [&](double position, double velocity) {
        return -k / m * position * (1.0 + a * velocity);
      };
      const double xm = x + 0.5 * h * v, vm = v + 0.5 * h * rate(x, v);
      x += h * vm, v += h * rate(xm, vm);
    } while (x > 0.0);
    EXPECT_NEAR(-v / speed, e, 1e-4);
  }
}

TEST(NormalLaws, DryGrainsNeverPull) {
  const NormalConstants c{.kr = 1e6, .kd = 500.0};
  EXPECT_EQ(HertzViscoelastic::force(c, 1e-6, -1.0), 0.0);
  EXPECT_EQ(HertzTsuji::force(c, 1e-6, -1.0), 0.0);
  EXPECT_EQ(HertzConstantDamping::force(c, 1e-6, -1.0), 0.0);
  EXPECT_EQ(LinearSpring::force(c, 1e-6, -1.0), 0.0);
  EXPECT_EQ(ElasticFoundation::force(c, 1e-6, -1.0), 0.0);
  EXPECT_GT(HertzViscoelastic::force(c, 1e-4, 0.0), 0.0);
}

TEST(NormalLaws, PullWhereTold) {
  const NormalConstants c{.kr = 1e6, .kd = 500.0, .smallestForce = -std::numeric_limits<double>::infinity()};
  EXPECT_DOUBLE_EQ(LinearSpring::force(c, 1e-6, -1.0), 1.0 - 500.0);
  EXPECT_LT(HertzTsuji::force(c, 1e-6, -1.0), 0.0);
}

template <class Law>
class NormalLawTest : public testing::Test {};
using AllNormalLaws =
    testing::Types<HertzViscoelastic, HertzTsuji, HertzConstantDamping, LinearSpring, ElasticFoundation>;
TYPED_TEST_SUITE(NormalLawTest, AllNormalLaws);

TYPED_TEST(NormalLawTest, EnergyIsTheIntegralOfTheElasticForce) {
  const NormalConstants c{.kr = 3e5, .kd = 0.0};
  const double xi = 2e-4, d = 1e-8;
  const double slope =
      (TypeParam::elasticEnergy(c, xi + d) - TypeParam::elasticEnergy(c, xi - d)) / (2.0 * d);
  EXPECT_NEAR(slope, TypeParam::elasticForce(c, xi), 1e-6 * slope);
  EXPECT_DOUBLE_EQ(TypeParam::elasticForce(c, xi), TypeParam::force(c, xi, 0.0));
  EXPECT_NEAR(TypeParam::force(c, xi, 0.5) - TypeParam::elasticForce(c, xi), 0.5 * TypeParam::damping(c, xi),
              1e-9 * TypeParam::force(c, xi, 0.5));
}

TYPED_TEST(NormalLawTest, TangentStiffnessIsTheSlopeOfTheElasticForce) {
  const NormalConstants c{.kr = 3e5, .kd = 0.0};
  const double xi = 2e-4, d = 1e-8;
  const double slope = (TypeParam::elasticForce(c, xi + d) - TypeParam::elasticForce(c, xi - d)) / (2.0 * d);
  EXPECT_NEAR(slope, TypeParam::tangentStiffness(c, xi), 1e-6 * slope);
}

TEST(RegularisedCoulomb, NeverExceedsMuTimesNormal) {
  const ShearConstants c{.mu = 0.4, .viscosity = 20.0};
  for (const double speed : {1e-9, 1e-3, 0.1, 3.0, 100.0}) {
    for (const double fn : {0.0, 1e-3, 1.0, 1e4}) {
      const Vector3 Vt = speed * Vector3(0.6, 0.0, -0.8);
      const Vector3 friction = RegularisedCoulomb::force<double>(c, fn, Vt);
      EXPECT_LE(friction.norm(), 0.4 * fn * (1.0 + 1e-15));
      EXPECT_LE(friction.norm(), 20.0 * speed * (1.0 + 1e-15));
      EXPECT_LE(friction.dot(Vt), 0.0);
    }
  }
  EXPECT_EQ(RegularisedCoulomb::force<double>(c, 1.0, Vector3(Vector3::Zero())), Vector3::Zero());
}

TEST(StaticFriction, IsASpringUpToTheCoulombLimit) {
  const ShearConstants c{.mu = 0.5};
  const Vector3 D(3e-6, 0, -4e-6);
  EXPECT_TRUE(StaticFriction::force<double>(c, 100.0, 1e6, Vector3::Zero(), D, false).isApprox(-1e6 * D));
  EXPECT_NEAR(StaticFriction::force<double>(c, 2.0, 1e6, Vector3::Zero(), D, false).norm(), 1.0, 1e-14);
}

TEST(StaticFriction, SettlingChangesNoForce) {
  const ShearConstants c{.mu = 0.5, .dashpot = 3.0};
  const Vector3 D(3e-6, 0, -4e-6), Vt(0.2, 0.1, 0.0);
  for (const double fn : {100.0, 2.0, 0.0}) {
    const bool slides = StaticFriction::slides<double>(c, fn, 1e6, Vt, D, false);
    EXPECT_EQ(slides, fn < 100.0);
    const Vector3 settled = StaticFriction::settled<double>(c, fn, 1e6, Vt, D, slides);
    const Vector3 before = StaticFriction::force<double>(c, fn, 1e6, Vt, D, false);
    EXPECT_LT((StaticFriction::force<double>(c, fn, 1e6, Vt, settled, false) - before).norm(), 1e-12);
  }
}

TEST(StaticFriction, SpringHoldsNoMoreThanTheLimitHoweverFastItSlides) {
  const ShearConstants c{.mu = 0.5, .dashpot = 3.0};
  const Vector3 D(3e-6, 0, -4e-6);
  for (const double speed : {1e-3, 1.0, 1e3}) {
    const Vector3 Vt = speed * D.normalized();
    const Vector3 settled = StaticFriction::settled<double>(c, 2.0, 1e6, Vt, D, true);
    EXPECT_LT((1e6 * settled - D.normalized()).norm(), 1e-12 * (1.0 + c.dashpot * speed)) << "1 N along D";
  }
}

TEST(Coulomb, PushesWithFullFrictionAsSoonAsItSlides) {
  const ShearConstants c{.mu = 0.5, .slipCompliance = 1e-3};
  const Vector3 Vt(0.0, 0.0, 0.2);
  EXPECT_TRUE(Coulomb::force<double>(c, 10.0, 1e6, Vt, Vector3::Zero(), true).isApprox(Vector3(0, 0, -5.0)));
  EXPECT_TRUE(
      Coulomb::settled<double>(c, 10.0, 1e6, Vt, Vector3::Zero(), true).isApprox(Vector3(0, 0, 5e-6)));
}

TEST(Coulomb, HoldsWhenTheVelocityTurnsBack) {
  const ShearConstants c{.mu = 0.5};
  const Vector3 D(2e-6, 0, 0), back(-0.1, 0, 0);
  EXPECT_TRUE(Coulomb::force<double>(c, 10.0, 1e6, back, D, true).isApprox(Vector3(-2.0, 0, 0)));
  EXPECT_FALSE(Coulomb::slides<double>(c, 10.0, 1e6, back, D, true));
  EXPECT_EQ(Coulomb::force<double>(c, 10.0, 1e6, Vector3::Zero(), Vector3::Zero(), true), Vector3::Zero());
}

TEST(Coulomb, SlidesAgainWhenTheSpringIsLoadedToTheLimit) {
  const ShearConstants c{.mu = 0.5, .slipCompliance = 1e-3};
  const Vector3 D(6e-6, 0, 0), Vt(0.1, 0, 0.1);
  EXPECT_TRUE(Coulomb::slides<double>(c, 10.0, 1e6, Vt, D, false));
  EXPECT_TRUE(Coulomb::force<double>(c, 10.0, 1e6, Vt, D, false).isApprox(-5.0 * Vt.normalized()));
}

TEST(PairLaw, DefaultViscosityStopsSlidingWithinOneContactTime) {
  const MaterialPair pair = combineMaterials({}, {}, {.restitutionSpeed = 2.0});
  const EffectiveContact c = effectiveContact(kGlass, kGlass);
  const double tc = hertzContactTime(c.hertzStiffness(), c.mass, 2.0);
  const double kt = makePairLaw(pair, {.contact = kGlass}, {.contact = kGlass}).shear.viscosity;
  EXPECT_NEAR(kt, 2.0 / 7.0 * std::numbers::pi * c.mass / tc, 1e-12 * kt);
}

TEST(PairLaw, UrgencyIsTheContactTimeOfTheImpactItIsPartOf) {
  const PairLaw law = makePairLaw(combineMaterials({}, {}, {}), {.contact = kGlass}, {.contact = kGlass});
  const EffectiveContact c = effectiveContact(kGlass, kGlass);
  const double v = 0.7;
  const double deepest = std::pow(1.25 * c.mass * v * v / c.hertzStiffness(), 0.4);
  const double expected = hertzContactTime(c.hertzStiffness(), c.mass, v);
  EXPECT_NEAR(contactTimeOfUrgency(HertzViscoelastic::urgency(law.normal, 1e-12, v)), expected,
              1e-6 * expected);
  EXPECT_NEAR(contactTimeOfUrgency(HertzViscoelastic::urgency(law.normal, deepest, 0.0)), expected,
              1e-9 * expected);
}

TEST(PairLaw, BodiesMeetUnderTheirOwnNormalLaw) {
  const MaterialPair pair = combineMaterials({}, {}, {});
  const PairSide body{.contact = kGlass, .isBody = true, .bodyLength = 0.1, .bodyArea = 0.02};
  const PairSide plane{.contact = {.youngsModulus = 48e9, .poissonRatio = 0.2}, .isBody = true};
  EXPECT_EQ(makePairLaw(pair, body, plane).normalLaw, NormalLaw::ElasticFoundation);
  EXPECT_EQ(makePairLaw(pair, {.contact = kGlass}, plane).normalLaw, NormalLaw::HertzViscoelastic);
  // Foundation modulus over depth, whichever side is named first.
  const double modulus = 48e9 / (2.0 * (1.0 - 0.04));
  EXPECT_DOUBLE_EQ(makePairLaw(pair, body, plane).normal.kr, modulus / 0.1);
  EXPECT_DOUBLE_EQ(makePairLaw(pair, plane, body).normal.kr, modulus / 0.1);
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

TEST(MaterialPairDef, RefusesWhatContradictsItself) {
  const auto message = [](const MaterialPairDef& def) -> std::string {
    try {
      checkMaterialPair(def);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message({}), "");
  EXPECT_EQ(
      message({.normal = {.contactTime = 1e-3}}),
      "MaterialPairDef.normal.contactTime is 0.001 s; it must be left out unless the law is LinearSpring");
  EXPECT_NE(message({.normal = {.law = NormalLaw::LinearSpring, .contactTime = 1e-3, .stiffness = 1e5}}), "");
  EXPECT_NE(message({.normal = {.law = NormalLaw::ElasticFoundation}}), "");
  EXPECT_EQ(message({.shear = {.viscosity = -1.0}}),
            "MaterialPairDef.shear.viscosity is -1 N s/m; it must be finite and >= 0");
  EXPECT_NE(message({.shear = {.stiffness = 1e5}}), "");  // eq. 18 has none
  EXPECT_NE(message({.shear = {.law = ShearLaw::StaticFriction, .viscosity = 1.0}}), "");
  EXPECT_EQ(message({.shear = {.law = ShearLaw::StaticFriction, .stiffness = 1e5, .dampingRatio = 0.3}}), "");
  EXPECT_NE(message({.restitutionSpeed = 0.0}), "");
}

}  // namespace
}  // namespace granular
