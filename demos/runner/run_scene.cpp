// SPDX-License-Identifier: MIT
#include "demos/runner/run_scene.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "demos/runner/frame_table.h"
#include "demos/runner/picture_writer.h"
#include "demos/runner/trajectory_table.h"
#include "granular/io/vtp_writer.h"

namespace granular_demo {
namespace {

// Energy may rise above its running minimum by this fraction of what has fallen: the integrator's error, not
// physics.
constexpr double kLargestEnergyRise = 1e-3;

class StopWatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// particles_00012.vtp and particles.pvd.
class VtpSeries {
 public:
  VtpSeries(const BuiltScene& scene, std::filesystem::path folder)
      : scene_(scene), folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_ / "vtp");
  }

  void write(int frame) {
    char name[64];
    std::snprintf(name, sizeof name, "vtp/particles_%05d.vtp", frame);
    granular::writeVtp(folder_ / name, granular::particleCloud(scene_.grains(), scene_.cloudBodies()));
    series_.emplace_back(scene_.time(), name);
    granular::writePvd(file(), series_);
  }

  std::filesystem::path file() const { return folder_ / "particles.pvd"; }

 private:
  const BuiltScene& scene_;
  std::filesystem::path folder_;
  std::vector<std::pair<double, std::string>> series_;
};

/// The files of a run; those the scene does not ask for stay empty.
struct Files {
  Files(const BuiltScene& scene, const RunOptions& options) {
    if (options.folder.empty()) return;
    const OutputsDef& outputs = scene.def().outputs;
    std::filesystem::create_directories(options.folder);
    table.emplace(options.folder / "frames.csv");
    trajectories.emplace(scene, options.folder);
    if (outputs.pictures) pictures.emplace(scene, options.folder, options.threads);
    if (outputs.vtp) vtp.emplace(scene, options.folder);
  }

  std::optional<FrameTable> table;
  std::optional<TrajectoryTables> trajectories;
  std::optional<PictureWriter> pictures;
  std::optional<VtpSeries> vtp;
};

void keepLargest(PlaceCounts& worst, const PlaceCounts& counts) {
  worst.insideBodies = std::max(worst.insideBodies, counts.insideBodies);
  worst.belowGround = std::max(worst.belowGround, counts.belowGround);
  worst.outside = std::max(worst.outside, counts.outside);
  worst.notFinite = std::max(worst.notFinite, counts.notFinite);
}

class Runner {
 public:
  Runner(BuiltScene& scene, const RunOptions& options, RunResult& result)
      : scene_(scene), options_(options), result_(result), checks_(scene), files_(scene, options) {}

  void run() {
    result_.framesWanted = options_.frames.value_or(scene_.def().frameCount());
    result_.state.start = result_.state.end = scene_.grains().measure();
    result_.energy.add(result_.state.start);
    if (files_.trajectories) files_.trajectories->add();
    finishFrame({});
    while (result_.frames < result_.framesWanted && !result_.interrupted) runFrame();
    finishFiles();
  }

 private:
  void runFrame() {
    const StopWatch watch;
    RunTotals frame;
    for (int i = 0; i < scene_.def().ticksPerFrame && !result_.interrupted; ++i) {
      result_.state.end = scene_.tick();
      frame.add(result_.state.end);
      result_.totals.add(result_.state.end);
      result_.energy.add(result_.state.end);
      if (files_.trajectories) files_.trajectories->add();
      result_.interrupted = options_.shallStop && options_.shallStop();
    }
    ++result_.frames;
    frameStepSeconds_ = watch.seconds();
    result_.stepSeconds += frameStepSeconds_;
    finishFrame(frame);
    if (options_.onFrame) {
      options_.onFrame({result_.frames, result_.framesWanted, scene_.time(), result_.state.end.contacts});
    }
  }

  /// Checks and files of the state as it stands.
  void finishFrame(const RunTotals& work) {
    const PlaceCounts places = checks_.count();
    keepLargest(result_.worst, places);
    const StopWatch watch;
    if (files_.pictures) files_.pictures->write(result_.frames);
    const double pictureSeconds = watch.seconds();
    result_.pictureSeconds += pictureSeconds;
    if (files_.vtp && result_.frames % scene_.def().outputs.vtpEvery == 0) files_.vtp->write(result_.frames);
    if (files_.table) {
      files_.table->add(result_.frames, result_.state.end, work, places, frameStepSeconds_, pictureSeconds);
    }
  }

  void finishFiles() {
    if (files_.table) result_.outputs.push_back(options_.folder / "frames.csv");
    if (files_.trajectories) {
      result_.outputs.insert(result_.outputs.end(), files_.trajectories->files().begin(),
                             files_.trajectories->files().end());
    }
    if (files_.vtp) result_.outputs.push_back(files_.vtp->file());
    if (!files_.pictures) return;
    result_.outputs.insert(result_.outputs.end(), files_.pictures->frameFolders().begin(),
                           files_.pictures->frameFolders().end());
    if (!scene_.def().outputs.film) return;
    const StopWatch watch;
    try {
      for (const auto& film : files_.pictures->writeFilms()) result_.outputs.push_back(film);
    } catch (const std::runtime_error& error) {
      result_.filmProblem = error.what();
    }
    result_.pictureSeconds += watch.seconds();
  }

  BuiltScene& scene_;
  const RunOptions& options_;
  RunResult& result_;
  PlaceChecks checks_;
  Files files_;
  double frameStepSeconds_ = 0.0;
};

}  // namespace

bool RunResult::passed(bool containerIsClosed) const {
  return worst.insideBodies == 0 && worst.belowGround == 0 && worst.notFinite == 0 &&
         totals.quarantined == 0 && (!containerIsClosed || worst.outside == 0) &&
         energy.worstFraction() <= kLargestEnergyRise;
}

FinishedRun runScene(SceneDef def, const RunOptions& options) {
  const StopWatch watch;
  FinishedRun run;
  run.scene = std::make_unique<BuiltScene>(std::move(def), options.threads);
  run.result.setUpSeconds = watch.seconds();
  if (options.onBuilt) options.onBuilt(*run.scene);
  run.result.grains = run.scene->grains().grainCount();
  run.result.grainParticles = run.scene->grains().particleCount() - run.scene->coveringParticles();
  Runner(*run.scene, options, run.result).run();
  run.result.stateHash = run.scene->stateHash();
  run.result.totalSeconds = watch.seconds();
  return run;
}

}  // namespace granular_demo
