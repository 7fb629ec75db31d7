// SPDX-License-Identifier: MIT
// `granular_bench stacking`: stacks in Bullet's solver and in ours, side by side, from the same btRigidBody
// numbers. All is measured from outside and alike: places from the bodies, depths from Bullet's manifolds,
// which it makes for covered pairs too. Nothing is asleep but where the set-up says so.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "bullet_bridge/bullet_bridge.h"
#include "bullet_bridge/convert.h"
#include "demos/render/camera.h"
#include "demos/render/image.h"
#include "demos/render/plot.h"
#include "demos/render/render.h"
#include "demos/runner/csv_file.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/stacking_scenes.h"

namespace granular_bench {
namespace {

using bullet_bridge::fromBullet;
using granular::Vector3;

struct Options {
  std::string only, setup, out;
  double seconds = 0.0;  // 0: 5, or 60 with full
  bool full = false;
};

/// Whose solver, and how it is set.
struct Setup {
  std::string name;
  bool isOurs = false;
  int ticksPerSecond = 60;
  int iterations = 10;  // Bullet's default
  bool sleeps = false;
  granular::IntegratorDef integrator = {};
};

std::vector<Setup> setups() {
  return {{.name = "Bullet default", .sleeps = true},
          {.name = "Bullet default awake"},
          {.name = "Bullet best", .ticksPerSecond = 240, .iterations = 50},
          {.name = "granular default", .isOurs = true},
          {.name = "granular leapfrog",
           .isOurs = true,
           .integrator = {.stepper = granular::Stepper::Leapfrog, .contactTimeFraction = 0.3}}};
}

struct Result {
  double drift = 0.0;        // of the last piece, largest, sizes
  double sunk = 0.0;         // by the last piece at the end, sizes
  double depth = 0.0;        // largest of the second half of the time, sizes
  double rest = 0.0;         // last moment at which anything was faster than 0.01 sizes a second, s
  bool stands = false;       // at the end nothing has moved by a quarter of a size
  double wall = 0.0;         // s a simulated second
  double evaluations = 0.0;  // a simulated second; Bullet: 0
  std::vector<double> times = {}, drifts = {};
};

/// One scene in one world.
class Run {
 public:
  Run(const StackScene& scene, const Setup& setup) : scene_(scene), setup_(setup) {
    world_.setGravity(bullet_bridge::toBullet(scene.gravity));
    world_.getSolverInfo().m_numIterations = setup.iterations;
    for (const StackPiece& piece : scene.pieces) addBody(piece);
    if (!setup.isOurs) return;
    sand_ = std::make_unique<bullet_bridge::GranularLayer>(
        world_, bullet_bridge::LayerDef{.integrator = setup.integrator});
    for (auto& body : bodies_) sand_->coverBody(*body);
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;
  ~Run() {
    sand_.reset();
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }

  Result run(double seconds) {
    Result result;
    const btScalar tick = btScalar(1) / btScalar(setup_.ticksPerSecond);
    const int ticks = static_cast<int>(std::lround(seconds * setup_.ticksPerSecond));
    const auto start = std::chrono::steady_clock::now();
    for (int i = 1; i <= ticks; ++i) {
      world_.stepSimulation(tick, 1, tick);
      if (sand_) result.evaluations += static_cast<double>(sand_->lastStep().evaluations) / seconds;
      measure(i * double(tick), i * 2 > ticks, result);
    }
    const double all = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    result.wall = all / seconds;
    result.sunk = -moveOf(bodies_.size() - 1).y() / scene_.size;
    result.stands = true;
    for (std::size_t i = 0; i < bodies_.size(); ++i) result.stands &= moveOf(i).norm() < 0.25 * scene_.size;
    return result;
  }

  /// How it looks now.
  void draw(const std::filesystem::path& file) const {
    granular_demo::RenderScene picture;
    for (std::size_t i = 1; i < bodies_.size(); ++i) {
      const float shade = i % 2 ? 1.0f : 0.82f;
      picture.meshes.push_back({.mesh = std::make_shared<granular::TriangleMesh>(
                                    bullet_bridge::shapeSurface(*bodies_[i]->getCollisionShape())),
                                .pose = fromBullet(bodies_[i]->getWorldTransform()),
                                .surface = {.color = shade * granular_demo::Color(0.78f, 0.55f, 0.38f)}});
    }
    const granular_demo::RenderSettings settings{.width = 480, .height = 640};
    granular::Box box = boundsOf(picture);
    granular_demo::writePng(
        render(picture, granular_demo::frameBox(box, double(settings.width) / settings.height), settings),
        file);
  }

 private:
  void addBody(const StackPiece& piece) {
    btVector3 inertia(0, 0, 0);
    if (piece.mass > 0.0) piece.shape->calculateLocalInertia(btScalar(piece.mass), inertia);
    btRigidBody::btRigidBodyConstructionInfo info(btScalar(piece.mass), nullptr, piece.shape, inertia);
    info.m_startWorldTransform = bullet_bridge::toBullet(piece.pose);
    info.m_friction = btScalar(std::sqrt(scene_.friction));
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    if (!setup_.sleeps) bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_.addRigidBody(bodies_.back().get());
  }

  Vector3 moveOf(std::size_t i) const {
    return fromBullet(bodies_[i]->getWorldTransform().getOrigin()) - scene_.pieces[i].pose.position;
  }

  void measure(double time, bool isLate, Result& result) {
    const Vector3 move = moveOf(bodies_.size() - 1);
    const double drift = std::hypot(move.x(), move.z()) / scene_.size;
    result.drift = std::max(result.drift, drift);
    result.times.push_back(time);
    result.drifts.push_back(std::max(drift, 1e-12));
    for (const auto& body : bodies_) {
      const double speed = double(body->getLinearVelocity().length());
      if (body->isActive() && speed > 0.01 * scene_.size) result.rest = time;
    }
    if (!isLate) return;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(i);
      for (int k = 0; k < manifold.getNumContacts(); ++k) {
        result.depth =
            std::max(result.depth, -double(manifold.getContactPoint(k).getDistance()) / scene_.size);
      }
    }
  }

  const StackScene& scene_;
  const Setup& setup_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::unique_ptr<bullet_bridge::GranularLayer> sand_;
};

std::string fileName(std::string text) {
  for (char& letter : text) {
    if (!std::isalnum(static_cast<unsigned char>(letter)) && letter != '.') letter = '-';
  }
  return text;
}

const char* word(bool stands) {
  return stands ? "stands" : "falls";
}

void printHead() {
  std::cout << std::left << std::setw(38) << "scene" << std::setw(22) << "set-up" << std::right
            << std::setw(8) << "statics" << std::setw(8) << "here" << std::setw(10) << "drift"
            << std::setw(10) << "sunk" << std::setw(10) << "depth" << std::setw(8) << "rest s"
            << std::setw(10) << "wall s/s" << std::setw(12) << "eval/s" << '\n';
}

void printRow(const StackScene& scene, const Setup& setup, const Result& r) {
  std::cout << std::left << std::setw(38) << scene.name << std::setw(22) << setup.name << std::right
            << std::setw(8) << (scene.stands ? word(*scene.stands) : "") << std::setw(8) << word(r.stands)
            << std::scientific << std::setprecision(1) << std::setw(10) << r.drift << std::setw(10) << r.sunk
            << std::setw(10) << r.depth << std::fixed << std::setprecision(2) << std::setw(8) << r.rest
            << std::setprecision(3) << std::setw(10) << r.wall << std::setprecision(0) << std::setw(12)
            << r.evaluations << std::endl;
}

void drawDrifts(const std::string& scene, const std::vector<granular_demo::Series>& series,
                const std::filesystem::path& file) {
  granular_demo::writeFigure(
      {.title = scene,
       .panels = {{.x = {.label = "time, s"},
                   .y = {.label = "drift of the top, sizes", .scale = granular_demo::Scale::logarithmic},
                   .series = series}}},
      file);
}

int runStacking(const Options& options) {
  const double seconds = options.seconds > 0.0 ? options.seconds : options.full ? 60.0 : 5.0;
  const std::filesystem::path out = options.out;
  std::unique_ptr<granular_demo::CsvFile> csv;
  if (!options.out.empty()) {
    std::filesystem::create_directories(out);
    csv = std::make_unique<granular_demo::CsvFile>(
        out / "stacking.csv",
        std::vector<std::string>{"scene", "setup", "statics_stands", "stands", "drift_sizes", "sunk_sizes",
                                 "depth_sizes", "rest_s", "wall_s_per_s", "evaluations_per_s"});
  }
  printHead();
  const std::vector<Setup> all = setups();
  const std::vector<StackScene> scenes = stackScenes(options.full);
  for (std::size_t s = 0; s < scenes.size(); ++s) {
    const StackScene& scene = scenes[s];
    if (scene.name.find(options.only) == std::string::npos) continue;
    std::vector<granular_demo::Series> series;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k].name.find(options.setup) == std::string::npos) continue;
      Run run(scene, all[k]);
      const Result r = run.run(seconds);
      printRow(scene, all[k], r);
      if (!csv) continue;
      csv->row({scene.name, all[k].name},
               {scene.stands ? double(*scene.stands) : std::nan(""), double(r.stands), r.drift, r.sunk,
                r.depth, r.rest, r.wall, r.evaluations});
      series.push_back({.name = all[k].name, .x = r.times, .y = r.drifts});
      run.draw(out / (fileName(scene.name + " " + all[k].name) + ".png"));
    }
    if (!series.empty()) drawDrifts(scene.name, series, out / (fileName(scene.name) + "-drift.png"));
  }
  return 0;
}

}  // namespace

void addStackingCommand(CLI::App& app, int& status) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("stacking", "Stacks in Bullet's solver and in ours, side by side");
  command->add_option("--only", options->only, "Only scenes whose name contains this");
  command->add_option("--setup", options->setup, "Only set-ups whose name contains this");
  command->add_option("--seconds", options->seconds, "To simulate; default 5, with --full 60")
      ->check(CLI::PositiveNumber);
  command->add_flag("--full", options->full, "Tall columns, the whole pyramid and wall, for a minute");
  command->add_option("--out", options->out, "Folder for the table as CSV, for pictures and for plots");
  command->callback([options, &status] { status = runStacking(*options); });
}

}  // namespace granular_bench
