// SPDX-License-Identifier: MIT
// The kernels that are compiled for several processors, and the numbers in packs that they work with.
#include "granular/system/detail/contact_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
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
    for (int lane = 0; lane < kPackSize; ++lane) EXPECT_EQ(roots[lane], inverseFifthRoot<double>(x[lane]));
  }
}

/// Three sizes of spheres of two materials that fall together onto a floor of particles and a wall.
std::vector<double> numbersAfterAFall(NormalLaw normal, ShearLaw shear) {
  GranularSystem system;
  const MaterialId stone = system.addMaterial({}), wood = system.addMaterial({.density = 700.0});
  for (const MaterialId a : {stone, wood}) {
    for (const MaterialId b : {stone, wood}) {
      system.setMaterialPair(a, b, {.normal = {.law = normal}, .shear = {.law = shear}});
    }
  }
  const GrainShapeId sphere = system.addGrainShape(sphereShape(0.01));
  Random random(2);
  for (int i = 0; i < 90; ++i) {
    const Vector3 site(i % 5, 1 + i / 25, i / 5 % 5);
    system.addGrain({.shape = sphere,
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

TEST(ContactKernels, GiveTheSameBitsForEveryProcessorUnderEveryLaw) {
  for (const NormalLaw normal : {NormalLaw::HertzViscoelastic, NormalLaw::HertzTsuji,
                                 NormalLaw::HertzConstantDamping, NormalLaw::LinearSpring}) {
    for (const ShearLaw shear :
         {ShearLaw::RegularisedCoulomb, ShearLaw::StaticFriction, ShearLaw::Coulomb, ShearLaw::Viscous}) {
      std::vector<double> first;
      for (const detail::ContactKernels* kernels : detail::availableContactKernels()) {
        const AskForProcessor ask(kernels->processor);
        const std::vector<double> numbers = numbersAfterAFall(normal, shear);
        if (first.empty()) first = numbers;
        EXPECT_EQ(std::memcmp(numbers.data(), first.data(), sizeof(double) * first.size()), 0)
            << kernels->processor << ", normal law " << static_cast<int>(normal) << ", shear law "
            << static_cast<int>(shear);
      }
    }
  }
}

TEST(ContactKernels, AreThoseAskedFor) {
  for (const detail::ContactKernels* kernels : detail::availableContactKernels()) {
    const AskForProcessor ask(kernels->processor);
    EXPECT_STREQ(detail::contactKernels().processor, kernels->processor);
  }
}

}  // namespace
}  // namespace granular
