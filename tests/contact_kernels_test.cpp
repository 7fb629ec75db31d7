// SPDX-License-Identifier: MIT
// The kernels that are compiled for several processors, and the numbers in packs that they work with.
#include "granular/system/detail/contact_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "granular/base/pack.h"
#include "granular/base/random.h"
#include "granular/system/granular_system.h"

namespace granular {
namespace {

TEST(InverseFifthRoot, IsOneOverTheFifthRootAtEveryMagnitude) {
  for (double x = 1e-60; x < 1e60; x *= 1.37) {
    const auto exact = static_cast<double>(std::pow(static_cast<long double>(x), -0.2L));
    EXPECT_NEAR(inverseFifthRoot(x) / exact, 1.0, 1e-15)
        << x;  // the last of Newton's steps rounds a few times
  }
}

TEST(InverseFifthRoot, OfAPackHasTheBitsOfEachNumber) {
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const Pack x = Pack([&](int) { return std::exp(random.uniform(-80.0, 80.0)); });
    const Pack roots = inverseFifthRoot(x);
    for (int lane = 0; lane < Pack::kSize; ++lane) EXPECT_EQ(roots[lane], inverseFifthRoot<double>(x[lane]));
  }
}

TEST(InverseFifthRoot, OfFloatsIsAsExactAsTheyAre) {
  Random random(6);
  for (int i = 0; i < 1000; ++i) {
    const FloatPack x = FloatPack([&](int) { return std::exp(random.uniform(-60.0, 60.0)); });
    const FloatPack roots = inverseFifthRoot(x);
    for (int lane = 0; lane < FloatPack::kSize; ++lane) {
      EXPECT_NEAR(roots[lane] / std::pow(x[lane], -0.2), 1.0, 5e-7) << x[lane];  // eight roundings of 6e-8
    }
  }
}

constexpr std::array kNormalLaws = {NormalLaw::HertzViscoelastic, NormalLaw::HertzTsuji,
                                    NormalLaw::HertzConstantDamping, NormalLaw::LinearSpring};
constexpr std::array kShearLaws = {ShearLaw::RegularisedCoulomb, ShearLaw::StaticFriction, ShearLaw::Coulomb,
                                   ShearLaw::Viscous};

std::string nameOf(NormalLaw normal, ShearLaw shear) {
  return "normal law " + std::to_string(static_cast<int>(normal)) + ", shear law " +
         std::to_string(static_cast<int>(shear));
}

/// Grains, in three sizes and of two materials, that fall together onto a floor of
/// particles and a wall, for .05 s.
GranularSystem afterAFall(NormalLaw normal, ShearLaw shear, const GrainShapeDef& shape,
                          ContactPrecision precision) {
  GranularSystem system({.integrator = {.precision = precision}});
  const MaterialId stone = system.addMaterial({}), wood = system.addMaterial({.density = 700.0});
  for (const MaterialId a : {stone, wood}) {
    for (const MaterialId b : {stone, wood}) {
      system.setMaterialPair(a, b, {.normal = {.law = normal}, .shear = {.law = shear}});
    }
  }
  const GrainShapeId grain = system.addGrainShape(shape);
  Random random(2);
  for (int i = 0; i < 90; ++i) {
    const Vector3 site(i % 5, 1 + i / 25, i / 5 % 5);
    system.addGrain({.shape = grain,
                     .material = i % 3 == 0 ? wood : stone,
                     .pose = {.position = 0.0205 * site},
                     .velocity = {random.uniform(-0.3, 0.3), -1.0, random.uniform(-0.3, 0.3)},
                     .angularVelocity = {random.uniform(-20.0, 20.0), 0.0, 0.0},
                     .scale = random.uniform(0.8, 1.0)});
  }
  Covering floor;
  for (int i = 0; i < 144; ++i) floor.positions.push_back({0.01 * (i % 12), 0.0, 0.01 * (i / 12)});
  floor.radii.assign(floor.positions.size(), 0.01);
  system.addBody({.covering = floor, .material = stone});
  system.addBody({.exact = HalfSpace{}, .material = wood, .pose = {.position = {0.0, -0.05, 0.0}}});
  for (int i = 0; i < 5; ++i) system.step(0.01);
  return system;
}

std::vector<double> numbersAfterAFall(NormalLaw normal, ShearLaw shear, ContactPrecision precision) {
  GranularSystem system = afterAFall(normal, shear, sphereShape(0.01), precision);
  std::vector<double> numbers = {system.measure().dissipated};
  for (const RigidMotion& motion : system.grainMotions()) {
    for (int axis = 0; axis < 3; ++axis) {
      numbers.push_back(motion.pose.position[axis]);
      numbers.push_back(motion.angularVelocity[axis]);
    }
  }
  return numbers;
}

/// For as long as it lives new systems use the kernels of this processor.
class AskForProcessor {
 public:
  explicit AskForProcessor(const char* processor) { setenv("GRANULAR_PROCESSOR", processor, 1); }
  ~AskForProcessor() { unsetenv("GRANULAR_PROCESSOR"); }
};

void expectTheSameBitsForEveryProcessor(ContactPrecision precision) {
  for (const NormalLaw normal : kNormalLaws) {
    for (const ShearLaw shear : kShearLaws) {
      std::vector<double> first;
      for (const detail::ContactKernels* kernels : detail::availableContactKernels()) {
        const AskForProcessor ask(kernels->processor);
        const std::vector<double> numbers = numbersAfterAFall(normal, shear, precision);
        if (first.empty()) first = numbers;
        EXPECT_EQ(std::memcmp(numbers.data(), first.data(), sizeof(double) * first.size()), 0)
            << kernels->processor << ", " << nameOf(normal, shear);
      }
    }
  }
}

TEST(ContactKernels, GiveTheSameBitsForEveryProcessorUnderEveryLaw) {
  expectTheSameBitsForEveryProcessor(ContactPrecision::Double);
}

TEST(ContactKernels, GiveTheSameBitsForEveryProcessorInMixedPrecision) {
  expectTheSameBitsForEveryProcessor(ContactPrecision::Mixed);
}

TEST(ContactKernels, AreThoseAskedFor) {
  for (const detail::ContactKernels* kernels : detail::availableContactKernels()) {
    const AskForProcessor ask(kernels->processor);
    EXPECT_STREQ(detail::contactKernels().processor, kernels->processor);
  }
}

void setPrecision(GranularSystem& system, ContactPrecision precision) {
  IntegratorDef integrator = system.integrator();
  integrator.precision = precision;
  system.setIntegrator(integrator);
}

TEST(MixedPrecision, HasTheForcesOfDoublePrecisionUnderEveryLaw) {
  const GrainShapeDef clump = {.particles = {{{-0.003, 0.0, 0.0}, 0.0085}, {{0.003, 0.0, 0.0}, 0.0085}}};
  for (const GrainShapeDef& shape : {sphereShape(0.01), clump}) {
    for (const NormalLaw normal : kNormalLaws) {
      for (const ShearLaw shear : kShearLaws) {
        GranularSystem system = afterAFall(normal, shear, shape, ContactPrecision::Double);
        std::vector<ContactView> exact, mixed;
        system.readContacts(exact);
        setPrecision(system, ContactPrecision::Mixed);
        system.readContacts(mixed);
        ASSERT_EQ(mixed.size(), exact.size());
        ASSERT_GT(exact.size(), 5u);
        double squares = 0.0;
        for (const ContactView& contact : exact) squares += contact.force.squaredNorm();
        const double force = std::sqrt(squares / static_cast<double>(exact.size()));
        int different = 0;
        for (std::size_t n = 0; n < exact.size(); ++n) {
          // Some forty roundings of 6e-8 on the way to a force.
          EXPECT_LT((mixed[n].force - exact[n].force).norm(), 3e-6 * force) << nameOf(normal, shear);
          different += mixed[n].force != exact[n].force;
        }
        EXPECT_GT(different, 0) << "not in single precision: " << nameOf(normal, shear);
      }
    }
  }
}

TEST(MixedPrecision, SeesASmallOverlapFarFromTheOrigin) {
  constexpr double kRadius = 0.01, kOverlap = 1e-6;
  GranularSystem system({.gravity = Vector3::Zero(), .integrator = {.precision = ContactPrecision::Mixed}});
  const MaterialId stone = system.addMaterial({.youngsModulus = 1e7, .poissonRatio = 0.25});
  const GrainShapeId sphere = system.addGrainShape(sphereShape(kRadius));
  for (const double x : {0.0, 2.0 * kRadius - kOverlap}) {
    system.addGrain({.shape = sphere, .material = stone, .pose = {.position = {100.0 + x, -50.0, 70.0}}});
  }
  std::vector<ContactView> contacts;
  system.readContacts(contacts);
  ASSERT_EQ(contacts.size(), 1u);
  const double modulus = 1e7 / (2.0 * (1.0 - 0.25 * 0.25));
  const double hertz = 4.0 / 3.0 * modulus * std::sqrt(0.5 * kRadius) * std::pow(kOverlap, 1.5);
  EXPECT_NEAR(contacts[0].force.norm() / hertz, 1.0, 1e-6);  // positions there are exact to 1.4e-8 overlaps
}

TEST(MixedPrecision, KeepsMomentum) {
  GranularSystem system({.gravity = Vector3::Zero(), .integrator = {.precision = ContactPrecision::Mixed}});
  const MaterialId stone = system.addMaterial({});
  const GrainShapeId sphere = system.addGrainShape(sphereShape(0.01));
  Random random(3);
  for (int i = 0; i < 27; ++i) {
    system.addGrain(
        {.shape = sphere,
         .material = stone,
         .pose = {.position = 0.021 * Vector3(i % 3, i / 3 % 3, i / 9)},
         .velocity = {random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)},
         .angularVelocity = {0.0, random.uniform(-20.0, 20.0), 0.0}});
  }
  const StepReport before = system.measure();
  std::int64_t contacts = 0;
  for (int i = 0; i < 20; ++i) contacts += system.step(1e-3).contacts;
  ASSERT_GT(contacts, 20);
  const StepReport after = system.measure();
  const double ofOneAtOneMetreASecond = 4.0 / 3.0 * std::numbers::pi * 1e-6 * MaterialDef{}.density;
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * ofOneAtOneMetreASecond);
}

}  // namespace
}  // namespace granular
