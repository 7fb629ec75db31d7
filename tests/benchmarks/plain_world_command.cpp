// SPDX-License-Identifier: MIT
// `granular_bench plain-world`: what a world without grains and covered bodies costs beside plain Bullet. The
// two run the same scene in turns, so that what else the machine does meets both; the answers are compared
// bit for bit before a time is printed.
#include <btBulletDynamicsCommon.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <vector>

#include "bullet_bridge/bullet_bridge.h"
#include "tests/benchmarks/commands.h"

namespace granular_bench {
namespace {

constexpr int kTicks = 300;

/// A wall of 8 x 8 boxes that a ball runs into: sleeping, waking, many contacts.
template <class World>
class PlainWorld {
 public:
  explicit PlainWorld(bool withLayer) {
    if (withLayer) layer_ = std::make_unique<bullet_bridge::GranularLayer>(world_);
    add(ground_, 0, btVector3(0, -1, 0));
    for (int i = 0; i < 64; ++i) add(box_, 1, btVector3(btScalar(i % 8), btScalar(0.5 + i / 8), 0));
    add(ball_, 20, btVector3(3, 3, 12));
    bodies_.back()->setLinearVelocity(btVector3(0, 0, -10));
  }
  PlainWorld(const PlainWorld&) = delete;
  PlainWorld& operator=(const PlainWorld&) = delete;
  ~PlainWorld() {
    layer_.reset();
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  /// Seconds for all ticks.
  double run() {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < kTicks; ++i) world_.stepSimulation(btScalar(1.0 / 60.0), 1, btScalar(1.0 / 60.0));
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
  std::vector<btScalar> bits() const {
    std::vector<btScalar> numbers;
    for (const auto& body : bodies_) {
      for (int k = 0; k < 3; ++k) numbers.push_back(body->getWorldTransform().getOrigin()[k]);
      for (int k = 0; k < 3; ++k) numbers.push_back(body->getLinearVelocity()[k]);
    }
    return numbers;
  }

 private:
  void add(btCollisionShape& shape, double mass, const btVector3& position) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape.calculateLocalInertia(btScalar(mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(mass), nullptr, &shape, inertia);
    info.m_startWorldTransform.setOrigin(position);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    world_.addRigidBody(bodies_.back().get());
  }

  btBoxShape ground_{btVector3(50, 1, 50)}, box_{btVector3(0.5, 0.5, 0.5)};
  btSphereShape ball_{btScalar(1)};
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  World world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::unique_ptr<bullet_bridge::GranularLayer> layer_;
};

/// Median of the ratios with its interval of 95 % by order statistics (binomial, normal approximation): no
/// distribution is assumed.
void printRatios(const char* name, std::vector<double> ratios) {
  std::sort(ratios.begin(), ratios.end());
  const auto n = static_cast<double>(ratios.size());
  const double half = 0.98 * std::sqrt(n);  // 1.96 sqrt(n) / 2 places
  const auto at = [&](double place) {
    return ratios[static_cast<std::size_t>(std::clamp(std::round(place), 0.0, n - 1.0))];
  };
  std::printf("%-24s time over plain Bullet's: median %.4f, 95 %% interval %.4f to %.4f, %d pairs\n", name,
              at(0.5 * (n - 1.0)), at(0.5 * n - half - 1.0), at(0.5 * n + half), static_cast<int>(n));
}

template <class World>
void compare(const char* name, bool withLayer, int pairs) {
  std::vector<double> ratios;
  for (int i = 0; i < pairs + 1; ++i) {
    PlainWorld<btDiscreteDynamicsWorld> plain(false);
    PlainWorld<World> ours(withLayer);
    double plainTime = 0.0, ourTime = 0.0;
    if (i % 2) {
      plainTime = plain.run();
      ourTime = ours.run();
    } else {
      ourTime = ours.run();
      plainTime = plain.run();
    }
    if (ours.bits() != plain.bits())
      throw std::runtime_error(std::string(name) + ": not the bits of plain Bullet");
    if (i > 0) ratios.push_back(ourTime / plainTime);  // the first pair warms up
  }
  printRatios(name, ratios);
}

}  // namespace

void addPlainWorldCommand(CLI::App& app, int& status) {
  const auto pairs = std::make_shared<int>(31);
  CLI::App* command = app.add_subcommand(
      "plain-world", "What a world without grains costs beside plain Bullet: ratio of times");
  command->add_option("--pairs", *pairs, "Runs of each, in turns")
      ->check(CLI::Range(5, 100000))
      ->capture_default_str();
  command->callback([pairs, &status] {
    compare<btDiscreteDynamicsWorld>("plain Bullet itself", false, *pairs);
    compare<bullet_bridge::GranularDynamicsWorld>("GranularDynamicsWorld", false, *pairs);
    compare<btDiscreteDynamicsWorld>("GranularLayer attached", true, *pairs);
    status = 0;
  });
}

}  // namespace granular_bench
