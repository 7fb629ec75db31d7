// SPDX-License-Identifier: MIT
// granular_demo: lists scenes, runs them, covers meshes.
//   granular_demo list
//   granular_demo run splash --scale small --out out/splash
//   granular_demo export splash --lammps out/splash_lammps
//   granular_demo cover meshes/camel.obj --out out/camel
// Exit status: kExitStatus below.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>

#include "demos/cover_command.h"
#include "demos/export_command.h"
#include "demos/json_object.h"
#include "demos/progress_line.h"
#include "demos/run_report.h"
#include "demos/run_scene.h"
#include "demos/scene_catalog.h"
#include "demos/scene_file.h"
#include "demos/stop_signal.h"

namespace {

using namespace granular_demo;

constexpr int kFailed = 1;
constexpr int kBadInput = 2;
constexpr int kChecksFailed = 3;
constexpr int kInterrupted = 130;  // 128 + SIGINT, as shells have it

const char* const kExitStatus =
    "Exit status: 0 completed and all checks passed; 1 something failed while running; 2 bad scene file or\n"
    "arguments; 3 completed, but a check failed: grains passed through a surface, or energy came from\n"
    "nowhere; 130 interrupted.";

/// What the command line asks for beyond the scene file.
struct Arguments {
  std::string scene;
  std::string scale = "default";
  std::filesystem::path out;
  std::filesystem::path report;
  std::filesystem::path mesh;
  std::optional<int> frames;
  std::optional<double> tolerance;
  std::optional<std::uint64_t> seed;
  std::optional<int> width, height;
  std::string integrator;
  std::string quality;
  int threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  bool noPictures = false;
};

/// CLI11's own check prints the largest double in full.
CLI::Validator positive() {
  const auto complaint = [](const std::string& text) -> std::string {
    double value = 0.0;
    const bool ok = CLI::detail::lexical_cast(text, value) && std::isfinite(value) && value > 0.0;
    return ok ? "" : "value " + text + "; allowed: a finite number > 0";
  };
  return CLI::Validator(complaint, "> 0");
}

const std::vector<std::string> kQualities = {"preview", "normal", "best"};

void addRunOptions(CLI::App& run, Arguments& a) {
  constexpr int kMost = std::numeric_limits<int>::max();
  run.add_option("scene", a.scene, "Name of a scene (see list) or a scene file")->required();
  run.add_option("--out", a.out, "Folder for all files; default ./out/SCENE");
  run.add_option("--frames", a.frames, "Frames to run; default: the scene's duration")
      ->check(CLI::Range(1, kMost));
  run.add_option("--scale", a.scale, "Size of the scene: one of its \"scales\"")->capture_default_str();
  run.add_option("--threads", a.threads, "Threads; the result is the same for any number")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  run.add_option("--integrator", a.integrator, "Stepper, instead of the scene's")
      ->check(CLI::IsMember(stepperNames()));
  run.add_option("--tolerance", a.tolerance, "Error of a sub-step in particle radii, instead of the scene's")
      ->check(positive());
  run.add_option("--seed", a.seed, "Seed of fills and coverings, instead of the scene's");
  run.add_option("--report", a.report, "Report file; default report.json in the output folder");
  run.add_option("--mesh", a.mesh, "Mesh in place of the body marked \"replaceableByMesh\"")
      ->check(CLI::ExistingFile);
  run.add_option("--width", a.width, "Width of pictures")->check(CLI::Range(16, 16384));
  run.add_option("--height", a.height, "Height of pictures")->check(CLI::Range(16, 16384));
  run.add_option("--quality", a.quality, "Quality of pictures")->check(CLI::IsMember(kQualities));
  run.add_flag("--no-pictures", a.noPictures, "No pictures and no film");
}

SceneDef sceneFor(const Arguments& a) {
  SceneDef scene = readSceneFile(findScene(a.scene), a.scale);
  if (!a.integrator.empty()) {
    const auto& names = stepperNames();
    const auto place = std::find(names.begin(), names.end(), a.integrator) - names.begin();
    scene.integrator.stepper = static_cast<granular::Stepper>(place);
  }
  if (a.tolerance) scene.integrator.tolerance = *a.tolerance;
  if (a.seed) scene.seed = *a.seed;
  if (a.noPictures) scene.outputs.pictures = false;
  if (a.width) scene.outputs.width = *a.width;
  if (a.height) scene.outputs.height = *a.height;
  if (!a.quality.empty()) {
    const auto place = std::find(kQualities.begin(), kQualities.end(), a.quality) - kQualities.begin();
    scene.outputs.quality = static_cast<Quality>(place);
  }
  if (!a.mesh.empty()) replaceByMesh(scene, a.mesh);
  return scene;
}

int list() {
  for (const std::string& name : sceneNames()) {
    const std::filesystem::path file = findScene(name);
    std::printf("%-12s %s (scales: %s)\n", name.c_str(), readSceneFile(file).description.c_str(),
                joined(scalesOf(file)).c_str());
  }
  return 0;
}

void printAdvice(const BuiltScene& scene) {
  if (scene.advice().empty()) return;
  std::printf("advice: reckoned for impacts at %.3g m/s (%s)\n", scene.impactSpeed().speed,
              scene.impactSpeed().reason.c_str());
  for (const std::string& line : scene.advice()) std::printf("advice: %s\n", line.c_str());
  std::fflush(stdout);
}

/// Returns whether all checks passed; if not, their line goes to the error output.
bool printSummary(const FinishedRun& run, const std::filesystem::path& report) {
  const RunResult& r = run.result;
  const auto& container = run.scene->def().container;
  std::printf("%s: %d of %d frames, %.3f s simulated in %s (steps %.1f s, pictures %.1f s)\n",
              r.interrupted ? "interrupted" : "completed", r.frames, r.framesWanted, run.scene->time(),
              clockText(r.totalSeconds).c_str(), r.stepSeconds, r.pictureSeconds);
  std::printf("%lld grains, %lld sub-steps (%lld rejected), worst overlap %.3f radii at %.3f s\n",
              static_cast<long long>(r.grains), static_cast<long long>(r.totals.subSteps),
              static_cast<long long>(r.totals.rejectedTrials), r.totals.largestOverlap,
              r.totals.largestOverlapTime);
  const bool passed = r.passed(container && container->closed);
  std::fprintf(
      passed ? stdout : stderr,
      "checks %s: %lld particles through surfaces, %lld below ground, %lld grains escaped, %lld not finite, "
      "energy rise %.2g of the fall\n",
      passed ? "passed" : "FAILED", static_cast<long long>(r.worst.insideBodies),
      static_cast<long long>(r.worst.belowGround), static_cast<long long>(r.worst.outside),
      static_cast<long long>(r.worst.notFinite + r.totals.quarantined), r.energy.worstFraction());
  if (r.totals.flags != granular::StepFlag::None)
    std::printf("%s\n", granular::describe(r.totals.flags).c_str());
  if (!r.filmProblem.empty()) std::printf("no film: %s\n", r.filmProblem.c_str());
  for (const std::filesystem::path& path : r.outputs) std::printf("wrote %s\n", path.string().c_str());
  std::printf("report: %s\n", report.string().c_str());
  return passed;
}

int run(const Arguments& a, const std::vector<std::string>& commandLine) {
  SceneDef scene;
  try {
    scene = sceneFor(a);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kBadInput;
  }
  RunOptions options;
  options.folder = a.out.empty() ? std::filesystem::path("out") / scene.name : a.out;
  options.frames = a.frames;
  options.threads = a.threads;
  options.onBuilt = printAdvice;
  ProgressLine progress;
  options.onFrame = [&](const RunProgress& p) { progress.update(p); };
  options.shallStop = stopWasAsked;
  const std::filesystem::path report = a.report.empty() ? options.folder / "report.json" : a.report;
  listenForStopSignals();
  const FinishedRun finished = runScene(std::move(scene), options);
  progress.finish();
  writeReport(makeReport(finished, options, commandLine), report);
  const bool passed = printSummary(finished, report);
  if (finished.result.interrupted) return kInterrupted;
  return passed ? 0 : kChecksFailed;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Sand in a Bullet world: lists and runs scenes");
  app.set_version_flag("--version", GRANULAR_VERSION);
  app.require_subcommand(1);
  app.footer(kExitStatus);
  Arguments arguments;
  app.add_subcommand("list", "Scenes that come with the program");
  CLI::App* runCommand =
      app.add_subcommand("run", "Runs a scene and writes pictures, tables and a report")->footer(kExitStatus);
  addRunOptions(*runCommand, arguments);
  ExportArguments exportArguments;
  addExportCommand(app, exportArguments);
  CoverArguments cover;
  CLI::App* coverCommand =
      app.add_subcommand("cover", "Covers a mesh file with particles: pictures, particles as PLY, report");
  addCoverOptions(*coverCommand, cover);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadInput;
  }
  try {
    if (app.got_subcommand("export")) return runExport(exportArguments);
    if (app.got_subcommand(coverCommand)) {
      runCoverCommand(cover);
      return 0;
    }
    return app.got_subcommand("list") ? list() : run(arguments, {argv, argv + argc});
  } catch (const SceneError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return kBadInput;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "granular_demo: %s\n", error.what());
    return app.got_subcommand(coverCommand) ? kBadInput : kFailed;
  }
}
