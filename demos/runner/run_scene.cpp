// SPDX-License-Identifier: MIT
#include "demos/runner/run_scene.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "demos/runner/frame_plot.h"
#include "demos/runner/frame_table.h"
#include "demos/runner/meter.h"
#include "demos/runner/picture_writer.h"
#include "demos/runner/trajectory_table.h"
#include "demos/scene/json_object.h"
#include "granular/io/vtp_writer.h"

namespace granular_demo {
namespace {

// Energy may rise above its running minimum by this fraction of what has fallen: the integrator's error, not
// physics.
constexpr double kLargestEnergyRise = 1e-3;
// Energy that is not accounted for may be this fraction of the energy put in.
constexpr double kLargestBalanceError = 1e-2;

class StopWatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// particles_00012.vtp and contacts_00012.vtp with their series.
class VtpSeries {
 public:
  VtpSeries(BuiltScene& scene, std::filesystem::path folder) : scene_(scene), folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_ / "vtp");
  }

  void write(int frame) {
    std::vector<granular::ContactView> contacts;
    std::vector<granular::ParticleView> particles;
    scene_.grains().readContacts(contacts);
    scene_.grains().readParticles(particles);
    const std::string ofParticles = name("particles", frame), ofContacts = name("contacts", frame);
    granular::writeVtp(folder_ / ofParticles,
                       granular::particleCloud(scene_.grains(), scene_.cloudBodies(), contacts));
    granular::writeContactNetwork(folder_ / ofContacts, particles, contacts);
    particleFiles_.emplace_back(scene_.time(), ofParticles);
    contactFiles_.emplace_back(scene_.time(), ofContacts);
    granular::writePvd(folder_ / "particles.pvd", particleFiles_);
    granular::writePvd(folder_ / "contacts.pvd", contactFiles_);
  }

  std::vector<std::filesystem::path> files() const {
    return {folder_ / "particles.pvd", folder_ / "contacts.pvd"};
  }

 private:
  static std::string name(const char* what, int frame) {
    char text[64];
    std::snprintf(text, sizeof text, "vtp/%s_%05d.vtp", what, frame);
    return text;
  }

  BuiltScene& scene_;
  std::filesystem::path folder_;
  std::vector<std::pair<double, std::string>> particleFiles_, contactFiles_;
};

/// "neck.rate" for each column of each meter.
std::vector<std::string> meterColumns(const BuiltScene& scene,
                                      const std::vector<std::unique_ptr<Meter>>& meters) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < meters.size(); ++i) {
    for (const std::string& column : meters[i]->columns())
      names.push_back(scene.def().meters[i].name + "." + column);
  }
  return names;
}

/// The files of a run; those the scene does not ask for stay empty.
struct Files {
  Files(BuiltScene& scene, const RunOptions& options, int firstFrame,
        const std::vector<std::string>& meterColumns) {
    if (options.folder.empty()) return;
    const OutputsDef& outputs = scene.def().outputs;
    std::filesystem::create_directories(options.folder);
    table.emplace(options.folder / "frames.csv", meterColumns);
    trajectories.emplace(scene, options.folder);
    if (outputs.pictures) pictures.emplace(scene, options.folder, options.threads, firstFrame);
    if (outputs.vtp) vtp.emplace(scene, options.folder);
  }

  std::optional<FrameTable> table;
  std::optional<TrajectoryTables> trajectories;
  std::optional<PictureWriter> pictures;
  std::optional<VtpSeries> vtp;
};

void keepLargest(PlaceCounts& worst, const PlaceCounts& counts) {
  worst.insideBodies = std::max(worst.insideBodies, counts.insideBodies);
  if (worst.inside.empty()) worst.inside = counts.inside;
  worst.belowGround = std::max(worst.belowGround, counts.belowGround);
  worst.outside = std::max(worst.outside, counts.outside);
  worst.notFinite = std::max(worst.notFinite, counts.notFinite);
}

std::vector<std::unique_ptr<Meter>> makeMeters(const BuiltScene& scene) {
  std::vector<std::unique_ptr<Meter>> meters;
  for (const MeterPart& part : scene.def().meters) meters.push_back(makeMeter(part, scene));
  return meters;
}

class Runner {
 public:
  Runner(BuiltScene& scene, const RunOptions& options, RunResult& result)
      : scene_(scene),
        options_(options),
        result_(result),
        checks_(scene),
        meters_(makeMeters(scene)),
        meterColumns_(meterColumns(scene, meters_)),
        files_(scene, options, frameNow(), meterColumns_) {}

  void run() {
    result_.framesWanted = options_.frames.value_or(scene_.def().frameCount());
    result_.firstFrame = result_.frames = frameNow();
    result_.state.start = result_.state.end = scene_.grains().measure();
    addEnergy();
    if (files_.trajectories) files_.trajectories->add();
    finishFrame({});
    refuseBadStart();
    while (result_.frames < result_.framesWanted && !result_.interrupted) runFrame();
    finishMeters();
    finishFiles();
  }

 private:
  int frameNow() const { return static_cast<int>(scene_.ticksDone() / scene_.def().ticksPerFrame); }

  void addEnergy() {
    result_.energy.add(result_.state.end, scene_.outsideEnergy().sum());
    result_.balance.add(result_.state.end, scene_);
  }

  /// Fills keep clear of bodies, so only bodies and single grains can be where they must not be.
  void refuseBadStart() const {
    if (result_.worst.insideBodies == 0 || options_.state) return;
    throw SceneError(scene_.def().file.string(), "bodies." + result_.worst.inside,
                     "holds " + std::to_string(result_.worst.insideBodies) +
                         " particles of grains or other bodies at the start, deeper than their radius");
  }

  void runFrame() {
    const StopWatch watch;
    RunTotals frame;
    for (int i = 0; i < scene_.def().ticksPerFrame && !result_.interrupted; ++i) {
      result_.state.end = scene_.tick();
      frame.add(result_.state.end);
      result_.totals.add(result_.state.end);
      addEnergy();
      for (const auto& meter : meters_) meter->tick();
      if (files_.trajectories) files_.trajectories->add();
      result_.interrupted = options_.shallStop && options_.shallStop();
    }
    ++result_.frames;
    frameStepSeconds_ = watch.seconds();
    result_.stepSeconds += frameStepSeconds_;
    finishFrame(frame);
    if (options_.onFrame) {
      options_.onFrame({result_.frames, result_.framesWanted, scene_.time(), result_.state.end.contacts,
                        frame, frameStepSeconds_});
    }
  }

  /// Checks and files of the state as it stands.
  void finishFrame(const RunTotals& work) {
    FrameRecord record;
    record.frame = result_.frames;
    record.state = result_.state.end;
    record.work = work;
    record.places = checks_.count();
    record.stepSeconds = frameStepSeconds_;
    keepLargest(result_.worst, record.places);
    for (const auto& meter : meters_) {
      for (const double number : meter->frame()) record.meters.push_back(number);
    }
    const StopWatch watch;
    if (files_.pictures) files_.pictures->write(result_.frames);
    record.pictureSeconds = watch.seconds();
    result_.pictureSeconds += record.pictureSeconds;
    if (files_.vtp && result_.frames % scene_.def().outputs.vtpEvery == 0) files_.vtp->write(result_.frames);
    if (files_.table) files_.table->add(record, scene_, result_.balance);
  }

  void finishMeters() {
    for (std::size_t i = 0; i < meters_.size(); ++i)
      result_.meters.push_back({scene_.def().meters[i].name, meters_[i]->results()});
    if (result_.interrupted || result_.frames < scene_.def().frameCount()) return;
    for (const ExpectedPart& part : scene_.def().expected) {
      ExpectedResult& expected = result_.expected.emplace_back();
      expected.part = part;
      for (const MeterResult& meter : result_.meters) {
        for (const auto& [name, value] : meter.values) {
          if (meter.name != part.meter || name != part.value) continue;
          expected.measured = value;
          expected.known = true;
        }
      }
    }
  }

  void finishFiles() {
    if (files_.table) {
      plotFrames(*files_.table, scene_.def().name, meterColumns_, options_.folder / "frames.png");
      result_.outputs.push_back(options_.folder / "frames.csv");
      result_.outputs.push_back(options_.folder / "frames.png");
    }
    if (files_.table && scene_.def().outputs.state) {
      writeState(scene_.savedState(), options_.folder / "end.state");
      result_.outputs.push_back(options_.folder / "end.state");
    }
    if (files_.trajectories) {
      result_.outputs.insert(result_.outputs.end(), files_.trajectories->files().begin(),
                             files_.trajectories->files().end());
    }
    if (files_.vtp) {
      for (const auto& file : files_.vtp->files()) result_.outputs.push_back(file);
    }
    if (!files_.pictures) return;
    result_.outputs.insert(result_.outputs.end(), files_.pictures->frameFolders().begin(),
                           files_.pictures->frameFolders().end());
    if (!scene_.def().outputs.film) return;
    const StopWatch watch;
    try {
      for (const auto& film : files_.pictures->writeFilms()) result_.outputs.push_back(film);
    } catch (const std::exception& error) {  // no ffmpeg; a resumed run without its first frames
      result_.filmProblem = error.what();
    }
    result_.pictureSeconds += watch.seconds();
  }

  BuiltScene& scene_;
  const RunOptions& options_;
  RunResult& result_;
  PlaceChecks checks_;
  std::vector<std::unique_ptr<Meter>> meters_;
  std::vector<std::string> meterColumns_;
  Files files_;
  double frameStepSeconds_ = 0.0;
};

}  // namespace

bool RunResult::passed(bool containerIsClosed) const {
  return worst.insideBodies == 0 && worst.belowGround == 0 && worst.notFinite == 0 &&
         totals.quarantined == 0 && (!containerIsClosed || worst.outside == 0) &&
         energy.worstFraction() <= kLargestEnergyRise && balance.worstFraction() <= kLargestBalanceError &&
         std::all_of(expected.begin(), expected.end(), [](const ExpectedResult& e) { return e.holds(); });
}

FinishedRun runScene(SceneDef def, const RunOptions& options) {
  const StopWatch watch;
  FinishedRun run;
  run.scene = std::make_unique<BuiltScene>(std::move(def), options.threads, options.state);
  run.result.setUpSeconds = watch.seconds();
  if (options.onBuilt) options.onBuilt(*run.scene);
  Runner(*run.scene, options, run.result).run();
  run.result.grains = run.scene->grains().grainCount();
  run.result.grainParticles = run.scene->grains().particleCount() - run.scene->coveringParticles();
  run.result.stateHash = run.scene->stateHash();
  run.result.totalSeconds = watch.seconds();
  return run;
}

}  // namespace granular_demo
