// SPDX-License-Identifier: MIT
// Evaluations and run time against true error, for every stepper. A scene is brought to a moment in which
// much happens; from there every stepper runs the same few milliseconds at one setting after another, and
// where grains and bodies end up is compared with a reference: RKF45 at a far smaller tolerance. The
// reference is checked before anything is printed: at a tolerance ten times larger it must say the same, to a
// fraction of the smallest error shown.
//
// Spheres also by LAMMPS, if it is there, from the same state: its law of friction is not quite ours, so its
// errors are those against its own run at a fiftieth of its shortest step.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "demos/render/plot.h"
#include "granular/io/lammps_writer.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/work_precision_scenes.h"
#include "tests/lammps_program.h"

namespace granular_bench {
namespace {

using namespace granular;

struct Options {
  std::string scene = "spheres-flowing", out = "work-precision";
  std::filesystem::path lammps = GRANULAR_LAMMPS;
  int spheresPerSide = 8, repeats = 1;
};

/// One stepper at one setting after another.
struct Sweep {
  std::string name;
  std::vector<IntegratorDef> settings;
};

struct Point {
  double evaluations = 0.0, seconds = 0.0;
  double position = 0.0;  // rms over grains and bodies, radii
  double velocity = 0.0;  // rms, m/s
  double energy = 0.0;    // of the kinetic energy at the start
};

constexpr double kReferenceTolerance = 1e-9;
// The reference has to be this much better than the smallest error printed.
constexpr double kReferenceMargin = 0.2;
constexpr std::int64_t kLammpsSteps = 2048;    // most of them
constexpr std::int64_t kLammpsReference = 50;  // times as many for its reference

std::vector<Sweep> sweeps(const PrecisionScene& scene) {
  // Step bounds at their loosest, so that tolerances decide.
  const IntegratorDef base{.contactTimeFraction = 0.3, .eventContacts = 0, .turnSpheres = false};
  std::vector<Sweep> all;
  const auto add = [&](const std::string& name, Stepper stepper, bool isFixed,
                       ContactPrecision precision = ContactPrecision::Double) {
    Sweep sweep{.name = name, .settings = {}};
    IntegratorDef def = base;
    def.stepper = stepper;
    def.precision = precision;
    if (stepper == Stepper::Leapfrog) def.contactTimeFraction = 0.9;
    if (isFixed) {
      for (double steps = 16; steps < 6000; steps *= std::sqrt(2.0)) {
        def.fixedSubStep = scene.horizon / std::round(steps);
        sweep.settings.push_back(def);
      }
    } else {
      for (double power = -0.5; power > -7.01; power -= 0.5) {
        def.tolerance = std::pow(10.0, power);
        sweep.settings.push_back(def);
      }
    }
    all.push_back(sweep);
  };
  add("RKF45", Stepper::Rkf45, false);
  add("Bogacki-Shampine", Stepper::BogackiShampine, false);
  add("leapfrog", Stepper::Leapfrog, false);
  add("leapfrog, mixed precision", Stepper::Leapfrog, false, ContactPrecision::Mixed);
  add("leapfrog, fixed", Stepper::Leapfrog, true);
  add("Verlet, fixed", Stepper::Verlet, true);
  add("semi-implicit Euler, fixed", Stepper::SemiImplicitEuler, true);
  return all;
}

struct Outcome {
  SceneState state;
  double evaluations = 0.0, seconds = std::numeric_limits<double>::infinity(), kinetic = 0.0, energy = 0.0;
};

/// The fastest of some runs from the start.
Outcome runFrom(const SceneState& start, const PrecisionScene& scene, const IntegratorDef& integrator,
                int repeats) {
  Outcome outcome;
  for (int i = 0; i < repeats; ++i) {
    GranularSystem system = scene.build(integrator);
    writeState(start, system);
    outcome.kinetic = system.measure().energy.kinetic;
    const auto begin = std::chrono::steady_clock::now();
    const StepReport report = system.step(scene.horizon);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    outcome.seconds = std::min(outcome.seconds, seconds);
    outcome.evaluations = static_cast<double>(report.evaluations);
    outcome.energy = report.energy.total();
    outcome.state = readState(system);
  }
  return outcome;
}

Point compare(const Outcome& run, const Outcome& reference, double radius) {
  Point point{.evaluations = run.evaluations, .seconds = run.seconds};
  double places = 0.0, speeds = 0.0;
  const auto add = [&](const std::vector<RigidMotion>& a, const std::vector<RigidMotion>& b) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      places += (a[i].pose.position - b[i].pose.position).squaredNorm();
      speeds += (a[i].velocity - b[i].velocity).squaredNorm();
    }
  };
  add(run.state.grains, reference.state.grains);
  add(run.state.bodies, reference.state.bodies);
  const auto count = static_cast<double>(run.state.grains.size() + run.state.bodies.size());
  point.position = std::sqrt(places / count) / radius;
  point.velocity = std::sqrt(speeds / count);
  point.energy = std::abs(run.energy - reference.energy) / reference.kinetic;
  return point;
}

/// Evaluations at which the error of position is `error`, between the points around it; NaN beyond them.
double evaluationsAt(const std::vector<Point>& points, double error) {
  double found = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {  // errors fall from point to point, by and large
    const Point &a = points[i], &b = points[i + 1];
    if (!std::isfinite(a.position) || !(a.position >= error && b.position < error)) continue;
    const double part = std::log(a.position / error) / std::log(a.position / b.position);
    found = a.evaluations * std::pow(b.evaluations / a.evaluations, part);  // the last crossing counts
  }
  return found;
}

class Study {
 public:
  Study(const PrecisionScene& scene, const Options& options) : scene_(scene), options_(options) {
    GranularSystem system = scene.build({.stepper = Stepper::Leapfrog, .tolerance = 1e-3});
    scene.settle(system);
    start_ = readState(system);
    const StepReport report = system.measure();
    std::printf("%s: %s; %d grains, %lld particles, %lld contacts, %.3g s\n", scene.name.c_str(),
                scene.description.c_str(), system.grainCount(),
                static_cast<long long>(system.particleCount()), static_cast<long long>(report.contacts),
                scene.horizon);
    IntegratorDef tight{.tolerance = kReferenceTolerance, .contactTimeFraction = 0.1, .eventContacts = 0};
    reference_ = runFrom(start_, scene, tight, 1);
    tight.tolerance *= 10.0;
    const Point other = compare(runFrom(start_, scene, tight, 1), reference_, scene.radius);
    std::printf("reference: RKF45 at %.0e, %.0f evaluations; at %.0e it differs by %.1e radii\n",
                kReferenceTolerance, reference_.evaluations, tight.tolerance, other.position);
    smallestShown_ = other.position / kReferenceMargin;
    if (!(smallestShown_ < 1e-4)) {
      throw std::runtime_error(scene.name + ": the reference is known to no better than 2e-5 radii");
    }
  }

  void run(const Sweep& sweep) {
    std::vector<Point> points;
    for (const IntegratorDef& setting : sweep.settings) {
      const Point point =
          compare(runFrom(start_, scene_, setting, options_.repeats), reference_, scene_.radius);
      if (!(point.position > smallestShown_)) break;
      points.push_back(point);
      const double value = setting.fixedSubStep > 0.0 ? setting.fixedSubStep : setting.tolerance;
      rows_.push_back({sweep.name, setting.fixedSubStep > 0.0 ? "fixedSubStep" : "tolerance", value, point});
    }
    curves_.push_back({sweep.name, points});
  }

  /// LAMMPS's velocity Verlet, where the scene is one of spheres only.
  void runLammps() {
    const GranularSystem system = scene_.build({});
    if (options_.lammps.empty() || system.particleCount() != system.grainCount()) return;
    const std::filesystem::path folder = std::filesystem::path(options_.out) / "lammps";
    const LammpsOutcome reference = stepByLammps(kLammpsSteps * kLammpsReference, folder);
    std::vector<Point> points;
    for (double steps = 16; steps <= kLammpsSteps; steps *= std::sqrt(2.0)) {
      const auto count = static_cast<std::int64_t>(std::lround(steps));
      const LammpsOutcome run = stepByLammps(count, folder);
      points.push_back(
          {.evaluations = static_cast<double>(count),
           .seconds = run.seconds,
           .position = run.rootMeanSquare(reference, &granular_test::DumpedAtom::position) / scene_.radius,
           .velocity = run.rootMeanSquare(reference, &granular_test::DumpedAtom::velocity),
           .energy = std::numeric_limits<double>::quiet_NaN()});
      rows_.push_back({"LAMMPS", "fixedSubStep", scene_.horizon / static_cast<double>(count), points.back()});
    }
    curves_.push_back({"LAMMPS, fixed", points});
    std::filesystem::remove_all(folder);
  }

  void print() const {
    const std::vector<double> errors{1e-2, 1e-3, 1e-4, 1e-5};
    std::printf("%-28s", "evaluations at rms error");
    for (const double error : errors) std::printf(" %9.0e         ", error);
    std::printf("  (radii; in brackets over Verlet's)\n");
    const auto verlet = std::find_if(curves_.begin(), curves_.end(),
                                     [](const Curve& c) { return c.name == "Verlet, fixed"; });
    for (const Curve& curve : curves_) {
      std::printf("%-28s", curve.name.c_str());
      for (const double error : errors) {
        const double count = evaluationsAt(curve.points, error);
        const double ratio = count / evaluationsAt(verlet->points, error);
        std::printf(" %9.1f (%6.3f)", count, ratio);
      }
      std::printf("\n");
    }
    std::fflush(stdout);
  }

  void writeFiles() const {
    const std::filesystem::path folder = options_.out;
    std::filesystem::create_directories(folder);
    std::ofstream csv(folder / (scene_.name + ".csv"));
    csv.precision(9);
    csv << "stepper,setting,value,evaluations,seconds,position_error_radii,velocity_error_m_s,energy_error\n";
    for (const Row& row : rows_) {
      csv << '"' << row.stepper << "\"," << row.setting << ',' << row.value << ',' << row.point.evaluations
          << ',' << row.point.seconds << ',' << row.point.position << ',' << row.point.velocity << ','
          << row.point.energy << '\n';
    }
    if (!csv.flush()) throw std::runtime_error(options_.out + ": cannot be written");
    granular_demo::writeFigure(
        {.title = scene_.description,
         .panels = {panel("evaluations", &Point::evaluations, "position, radii", &Point::position),
                    panel("wall time, s", &Point::seconds, "position, radii", &Point::position),
                    panel("evaluations", &Point::evaluations, "velocity, m/s", &Point::velocity),
                    panel("evaluations", &Point::evaluations, "energy, of the kinetic", &Point::energy)},
         .columns = 2},
        folder / (scene_.name + ".png"));
  }

 private:
  struct Row {
    std::string stepper, setting;
    double value;
    Point point;
  };
  struct Curve {
    std::string name;
    std::vector<Point> points;
  };

  struct LammpsOutcome {
    std::vector<granular_test::DumpedAtom> atoms;
    double seconds = 0.0;

    double rootMeanSquare(const LammpsOutcome& other, Vector3 granular_test::DumpedAtom::*what) const {
      double sum = 0.0;
      for (std::size_t i = 0; i < atoms.size(); ++i)
        sum += (atoms[i].*what - other.atoms[i].*what).squaredNorm();
      return std::sqrt(sum / static_cast<double>(atoms.size()));
    }
  };

  LammpsOutcome stepByLammps(std::int64_t steps, const std::filesystem::path& folder) const {
    GranularSystem system = scene_.build({.stepper = Stepper::Verlet});
    writeState(start_, system);
    std::filesystem::remove_all(folder);
    writeLammps(
        system, folder,
        {.timeStep = scene_.horizon / static_cast<double>(steps), .steps = steps, .dumpEvery = steps});
    const granular_test::LammpsRun run = granular_test::runLammps(options_.lammps, folder);
    const granular_test::DumpedState state = granular_test::readDump(folder).back();
    if (state.step != steps || state.atoms.size() != start_.grains.size()) {
      throw std::runtime_error(scene_.name + ": LAMMPS's last state is not that after the last step");
    }
    return {state.atoms, run.loopSeconds};
  }

  granular_demo::Panel panel(const std::string& xLabel, double Point::*x, const std::string& yLabel,
                             double Point::*y) const {
    using granular_demo::Scale;
    granular_demo::Panel panel{.title = "rms error of " + yLabel,
                               .x = {.label = xLabel, .scale = Scale::logarithmic},
                               .y = {.label = yLabel, .scale = Scale::logarithmic}};
    for (const Curve& curve : curves_) {
      granular_demo::Series series{.name = curve.name, .marker = granular_demo::Marker::circle};
      for (const Point& point : curve.points) {
        if (!(point.position < 1.0) || !std::isfinite(point.*y)) continue;  // it flew apart, or is not known
        series.x.push_back(point.*x);
        series.y.push_back(point.*y);
      }
      panel.series.push_back(series);
    }
    return panel;
  }

  const PrecisionScene& scene_;
  const Options& options_;
  SceneState start_;
  Outcome reference_;
  double smallestShown_ = 0.0;  // radii
  std::vector<Row> rows_;
  std::vector<Curve> curves_;
};

void workPrecision(const Options& options) {
  bool found = false;
  for (const PrecisionScene& scene : precisionScenes(options.spheresPerSide)) {
    if (options.scene != "all" && options.scene != scene.name) continue;
    found = true;
    Study study(scene, options);
    for (const Sweep& sweep : sweeps(scene)) study.run(sweep);
    study.runLammps();
    study.print();
    study.writeFiles();
  }
  if (!found) throw std::invalid_argument("no scene of the name " + options.scene);
}

}  // namespace

void addWorkPrecisionCommand(CLI::App& app, int& status) {
  CLI::App* command = app.add_subcommand(
      "work-precision", "Evaluations and run time of every stepper against its true error: table, CSV, PNG");
  const auto options = std::make_shared<Options>();
  std::string names = "all";
  for (const PrecisionScene& scene : precisionScenes(2)) names += ", " + scene.name;
  command->add_option("scene", options->scene, "One of " + names)->capture_default_str();
  command->add_option("--spheres-per-side", options->spheresPerSide, "8: 512 spheres, 16: 4096, 24: 13824")
      ->capture_default_str()
      ->check(CLI::Range(2, 100));
  command->add_option("--repeats", options->repeats, "Runs a setting, the fastest of which is shown")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000));
  command->add_option("--lammps", options->lammps, "LAMMPS's program; empty: without it");
  command->add_option("--out", options->out, "Folder for the CSV and PNG files")->capture_default_str();
  command->callback([options, &status] {
    workPrecision(*options);
    status = 0;
  });
}

}  // namespace granular_bench
