// SPDX-License-Identifier: MIT
// A warm step allocates nothing, and particles take no more memory than what is listed here. This file
// replaces operator new for the whole program, to count.
#include <gtest/gtest.h>
#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "granular/base/random.h"
#include "granular/system/granular_system.h"

namespace {

std::atomic<long> allocations{0};
std::atomic<long> bytes{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = alignment <= alignof(std::max_align_t)
                     ? std::malloc(size)
                     : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  bytes += static_cast<long>(malloc_usable_size(memory));
  return memory;
}

void uncounted(void* memory) {
  bytes -= static_cast<long>(malloc_usable_size(memory));
  std::free(memory);
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
  uncounted(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  uncounted(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  uncounted(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  uncounted(memory);
}

namespace granular {
namespace {

/// side^3 spheres of as many sizes, packed and stirred a little, on a floor; every step makes the list anew.
GranularSystem stirredSpheres(int side, Stepper stepper, ShearLaw shear) {
  GranularSystem system({.integrator = {.stepper = stepper, .fixedSubStep = 1e-4}});
  const MaterialId stone = system.addMaterial({});
  system.setMaterialPair(stone, stone, {.shear = {.law = shear}});
  const GrainShapeId sphere = system.addGrainShape(sphereShape(0.01));
  system.addBody({.exact = HalfSpace{}, .material = stone});
  Random random(1);
  for (int i = 0; i < side * side * side; ++i) {
    const Vector3 site(i % side, i / (side * side), i / side % side);
    system.addGrain({.shape = sphere,
                     .material = stone,
                     .pose = {.position = 0.0198 * site + Vector3(0.0, 0.0099, 0.0)},
                     .velocity = 0.02 * (random.rotation() * Vector3::UnitX()),
                     .scale = random.uniform(0.95, 1.0)});
  }
  return system;
}

long allocationsOfAWarmStep(Stepper stepper, ShearLaw shear) {
  GranularSystem system = stirredSpheres(6, stepper, shear);
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

/// What the README's table of memory says, of single spheres under law 18 with Verlet: room of arrays that
/// grow is an eighth more than was used at any time, and candidates were a few more before.
TEST(Memory, OfASphereIsWhatItsRowsAddUpTo) {
  constexpr int kSide = 16;
  const long before = bytes;
  GranularSystem system = stirredSpheres(kSide, Stepper::Verlet, ShearLaw::RegularisedCoulomb);
  StepReport report;
  for (int i = 0; i < 30; ++i) report = system.step(1e-3);
  const double spheres = kSide * kSide * kSide;
  const double candidates = static_cast<double>(report.candidates) / spheres;
  const double record = 40, motion = 112, state = 2 * 104 + 2 * 48, owner = 96, numbers = 12 * 4 + 9;
  const double rows = 64 + 32 + 32 + 8 + 8 + 8, hash = 8 + 1 + 3 * 4 + 40 + 12;
  // A third of the candidates are in two blocks: in the list, in blocks, and as they are shared out to these.
  const double list = 4 + 8 + 16, perCandidate = 4 + 4 + 4.0 / 3.0 * (4 + 4 + 32) + 1.0 / 3.0 * (12 + 8);
  const double block = 1024 * 1.5 * (16 * candidates + 64) / spheres;  // what a thread works with
  const double all =
      record + motion + state + owner + numbers + rows + hash + list + block + candidates * perCandidate;
  EXPECT_LT(static_cast<double>(bytes - before) / spheres, 1.125 * 1.05 * all);
}

}  // namespace
}  // namespace granular
