// SPDX-License-Identifier: MIT
// A warm step allocates nothing. This file replaces operator new for the whole program, to count.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "granular/base/random.h"
#include "granular/system/granular_system.h"

namespace {

std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = alignment <= alignof(std::max_align_t)
                     ? std::malloc(size)
                     : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Not inlined: where only one of new and delete is, gcc takes std::free for the wrong partner.
[[gnu::noinline]] void* operator new(std::size_t size) {
  return counted(size, 1);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace granular {
namespace {

/// 216 spheres of many sizes, packed and stirred a little, on a floor; every step makes the list anew.
long allocationsOfAWarmStep(Stepper stepper, ShearLaw shear) {
  GranularSystem system({.integrator = {.stepper = stepper, .fixedSubStep = 1e-4}});
  const MaterialId stone = system.addMaterial({});
  system.setMaterialPair(stone, stone, {.shear = {.law = shear}});
  const GrainShapeId sphere = system.addGrainShape(sphereShape(0.01));
  system.addBody({.exact = HalfSpace{}, .material = stone});
  Random random(1);
  for (int i = 0; i < 216; ++i) {
    const Vector3 site(i % 6, i / 36, i / 6 % 6);
    system.addGrain({.shape = sphere,
                     .material = stone,
                     .pose = {.position = 0.0198 * site + Vector3(0.0, 0.0099, 0.0)},
                     .velocity = 0.02 * (random.rotation() * Vector3::UnitX()),
                     .scale = random.uniform(0.95, 1.0)});
  }
  for (int i = 0; i < 60; ++i) system.step(1e-3);
  const long before = allocations;
  const StepReport report = system.step(1e-3);
  EXPECT_GT(report.contacts, 100);
  return allocations - before;
}

TEST(WarmStep, AllocatesNothing) {
  for (const Stepper stepper : {Stepper::Verlet, Stepper::Leapfrog, Stepper::Rkf45}) {
    for (const ShearLaw shear : {ShearLaw::RegularisedCoulomb, ShearLaw::StaticFriction}) {
      EXPECT_EQ(allocationsOfAWarmStep(stepper, shear), 0)
          << static_cast<int>(stepper) << ' ' << static_cast<int>(shear);
    }
  }
}

}  // namespace
}  // namespace granular
