// SPDX-License-Identifier: MIT
// Table 1 of the paper beside ours: the five scenes, round particles, sub-steps, evaluations and minutes a
// frame (Bell 2005, section 4, on 3 GHz PCs). A frame is one of the scene file's: how long it is simulated
// for stands beside it, since the paper does not say its own.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "demos/runner/csv_file.h"
#include "demos/runner/run_scene.h"
#include "demos/scene/scene_catalog.h"
#include "demos/scene/scene_file.h"
#include "tests/benchmarks/commands.h"

namespace granular_bench {
namespace {

using namespace granular_demo;

/// A row of the paper's table.
struct PaperRow {
  const char* scene;  ///< scene file
  const char* scale;  ///< put behind the scale asked for
  double particles, frames, minutesPerFrame;
};
constexpr PaperRow kPaper[] = {{"hourglass", "", 109708, 1600, 3.18},  {"rings", "", 110000, 460, 3.73},
                               {"rings", "+rough", 110000, 460, 3.09}, {"splash", "", 186892, 480, 3.41},
                               {"avalanche", "", 294820, 720, 26.40},  {"bulldozer", "", 310149, 300, 17.40}};

struct Arguments {
  std::string scale = "small";
  std::string frames = "0:3";
  std::string only;
  std::filesystem::path state, csv;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
};

struct Frames {
  int from = 0, to = 0;  ///< frames from + 1 to to are counted
};

Frames readFrames(const std::string& text) {
  Frames frames;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d:%d%c", &frames.from, &frames.to, &rest) != 2 || frames.from < 0 ||
      frames.to <= frames.from)
    throw CLI::ValidationError("--frames", "value " + text + "; allowed: A:B with 0 <= A < B");
  return frames;
}

struct Row {
  std::int64_t grains = 0, grainParticles = 0, bodyParticles = 0, fixedParticles = 0;
  std::int64_t subSteps = 0, evaluations = 0;
  double seconds = 0.0, setUpSeconds = 0.0;
  double frameTime = 0.0;  ///< s simulated
};

/// Runs a scene to the last frame asked for. Leaves its end in `end`.
Row measure(SceneDef def, const Arguments& a, const Frames& frames, const SavedState* state,
            std::optional<SavedState>& end) {
  def.outputs.pictures = false;
  Row row;
  row.frameTime = def.frameDuration();
  RunOptions options;
  options.frames = frames.to;
  options.threads = a.threads;
  options.state = state;
  options.onFrame = [&](const RunProgress& progress) {
    if (progress.frame <= frames.from) return;
    row.subSteps += progress.work.subSteps;
    row.evaluations += progress.work.evaluations;
    row.seconds += progress.stepSeconds;
  };
  const FinishedRun run = runScene(std::move(def), options);
  end = run.scene->savedState();
  row.setUpSeconds = run.result.setUpSeconds;
  row.grains = run.result.grains;
  row.grainParticles = run.result.grainParticles;
  for (const BuiltBody& body : run.scene->bodies()) {
    const auto count = static_cast<std::int64_t>(body.covering->covering.positions.size());
    (body.part->motion == BodyKind::dynamic ? row.bodyParticles : row.fixedParticles) += count;
  }
  return row;
}

void print(const PaperRow& paper, const Row& row, const Frames& frames) {
  const double n = frames.to - frames.from;
  std::printf("%-9s%-7s %8lld %9lld %9lld %8lld %9.0f %10.0f %9.4f %10.1f %10.4f | %9.0f %6.0f %7.2f\n",
              paper.scene, paper.scale, static_cast<long long>(row.grains),
              static_cast<long long>(row.grainParticles), static_cast<long long>(row.bodyParticles),
              static_cast<long long>(row.fixedParticles), static_cast<double>(row.subSteps) / n,
              static_cast<double>(row.evaluations) / n, row.frameTime, row.setUpSeconds,
              row.seconds / 60.0 / n, paper.particles, paper.frames, paper.minutesPerFrame);
  std::fflush(stdout);
}

int run(const Arguments& a) {
  const Frames frames = readFrames(a.frames);
  std::optional<SavedState> given, avalanche;
  if (!a.state.empty()) given = readState(a.state);
  std::unique_ptr<CsvFile> csv;
  if (!a.csv.empty()) {
    csv = std::make_unique<CsvFile>(
        a.csv, std::vector<std::string>{"row", "grains", "grainParticles", "bodyParticles", "fixedParticles",
                                        "subStepsPerFrame", "evaluationsPerFrame", "frameSeconds",
                                        "minutesPerFrame", "paperParticles", "paperMinutesPerFrame"});
  }
  std::printf(
      "scale %s, frames %d to %d, %d threads; per frame: sub-steps, evaluations, minutes of wall time\n",
      a.scale.c_str(), frames.from + 1, frames.to, a.threads);
  std::printf("%-16s %8s %9s %9s %8s %9s %10s %9s %10s %10s | %9s %6s %7s\n", "scene", "grains", "on grains",
              "on bodies", "fixed", "sub-steps", "evaluations", "frame, s", "set-up, s", "min/frame",
              "particles", "frames", "min");
  for (std::size_t i = 0; i < std::size(kPaper); ++i) {
    const PaperRow& paper = kPaper[i];
    if (!a.only.empty() && a.only != paper.scene) continue;
    const std::filesystem::path file = findScene(paper.scene);
    const SavedState* state = nullptr;
    std::optional<SavedState> end;
    if (!readTitle(file).continues.empty()) {
      if (!given && !avalanche)
        measure(readSceneFile(findScene("avalanche"), a.scale), a, frames, nullptr, avalanche);
      state = given ? &*given : &*avalanche;
      std::printf("%s begins with the %s state of %s at %.2f s\n", paper.scene, state->scale.c_str(),
                  state->scene.c_str(), state->time);
    }
    const Row row = measure(readSceneFile(file, a.scale + paper.scale, state ? state->document : ""), a,
                            frames, state, end);
    print(paper, row, frames);
    if (std::string(paper.scene) == "avalanche") avalanche = std::move(end);
    const double n = frames.to - frames.from;
    if (csv) {
      csv->row({static_cast<double>(i), static_cast<double>(row.grains),
                static_cast<double>(row.grainParticles), static_cast<double>(row.bodyParticles),
                static_cast<double>(row.fixedParticles), static_cast<double>(row.subSteps) / n,
                static_cast<double>(row.evaluations) / n, row.frameTime, row.seconds / 60.0 / n,
                paper.particles, paper.minutesPerFrame});
    }
  }
  return 0;
}

}  // namespace

void addPaperTableCommand(CLI::App& app, int& status) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand("paper-table", "The five scenes beside table 1 of the paper");
  command->add_option("--scale", arguments->scale, "small, default or paper")->capture_default_str();
  command->add_option("--frames", arguments->frames, "A:B: frames A + 1 to B are counted")
      ->capture_default_str();
  command->add_option("--only", arguments->only, "One scene");
  command
      ->add_option("--state", arguments->state,
                   "State the bulldozer begins with; default: the avalanche after B frames")
      ->check(CLI::ExistingFile);
  command->add_option("--csv", arguments->csv, "Table as CSV");
  command->add_option("--threads", arguments->threads)->check(CLI::Range(1, 1024))->capture_default_str();
  command->callback([arguments, &status] { status = run(*arguments); });
}

}  // namespace granular_bench
