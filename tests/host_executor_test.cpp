// SPDX-License-Identifier: MIT
// A host's threads in place of ours: the same bits.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "granular/base/random.h"
#include "granular/system/granular_system.h"

namespace granular {
namespace {

/// The simplest there is: new threads for every loop, which take pieces as they come.
class PlainThreads : public HostExecutor {
 public:
  explicit PlainThreads(int threads) : threads_(threads) {}
  void run(std::int32_t pieces, const std::function<void(std::int32_t)>& body) override {
    ++loops;
    std::atomic<std::int32_t> next = 0;
    const auto work = [&] {
      for (std::int32_t piece = next++; piece < pieces; piece = next++) body(piece);
    };
    std::vector<std::jthread> helpers;
    for (int i = 1; i < threads_; ++i) helpers.emplace_back(work);
    work();
  }

  int loops = 0;

 private:
  int threads_;
};

/// The last piece first.
class Backwards : public HostExecutor {
 public:
  void run(std::int32_t pieces, const std::function<void(std::int32_t)>& body) override {
    while (pieces > 0) body(--pieces);
  }
};

/// 1000 spheres that meet in the middle of a box without walls.
std::vector<RigidMotion> motionsAfterFlight(const SystemDef& def) {
  GranularSystem system(def);
  const MaterialId stone = system.addMaterial({});
  const GrainShapeId sphere = system.addGrainShape(sphereShape(0.01));
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Vector3 place = 0.023 * Vector3(i % 10, i / 10 % 10, i / 100);
    const Vector3 noise(random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    system.addGrain({.shape = sphere,
                     .material = stone,
                     .pose = {.position = place},
                     .velocity = noise - 10.0 * (place - Vector3::Constant(0.1035))});
  }
  for (int i = 0; i < 4; ++i) system.step(1.0 / 120.0);
  return {system.grainMotions().begin(), system.grainMotions().end()};
}

void expectSameBits(const std::vector<RigidMotion>& a, const std::vector<RigidMotion>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].pose.position, b[i].pose.position) << i;
    ASSERT_EQ(a[i].pose.orientation.coeffs(), b[i].pose.orientation.coeffs()) << i;
    ASSERT_EQ(a[i].velocity, b[i].velocity) << i;
    ASSERT_EQ(a[i].angularVelocity, b[i].angularVelocity) << i;
  }
}

TEST(HostExecutor, GivesTheBitsOfOneThread) {
  const std::vector<RigidMotion> alone = motionsAfterFlight({});
  for (const int threads : {1, 3}) {
    PlainThreads host(threads);
    expectSameBits(motionsAfterFlight({.executor = &host}), alone);
    EXPECT_GT(host.loops, 100) << "it was asked to run the loops";
  }
  Backwards host;
  expectSameBits(motionsAfterFlight({.executor = &host}), alone);
}

TEST(HostExecutor, TakesThePlaceOfOwnThreads) {
  PlainThreads host(2);
  const Executor executor(2, &host);
  std::vector<int> calls(100, 0);
  executor.forPieces(100, [&](std::int32_t piece) { ++calls[piece]; });
  EXPECT_EQ(calls, std::vector<int>(100, 1));
  EXPECT_EQ(host.loops, 1);
}

}  // namespace
}  // namespace granular
