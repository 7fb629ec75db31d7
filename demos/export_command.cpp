// SPDX-License-Identifier: MIT
#include "demos/export_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "demos/built_scene.h"
#include "demos/scene_catalog.h"
#include "demos/scene_file.h"
#include "granular/io/lammps_writer.h"

namespace granular_demo {
namespace {

/// What Bullet and the scene do besides grains and covered bodies, which LAMMPS will not.
std::vector<std::string> leftOutOfScene(const SceneDef& scene) {
  std::vector<std::string> lines;
  const auto unseen = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                    [](const BodyPart& body) { return !body.meetsGrains(); });
  if (unseen == 1) lines.push_back("1 body that Bullet alone moves is left out");
  if (unseen > 1) lines.push_back(std::to_string(unseen) + " bodies that Bullet alone moves are left out");
  if (!scene.scripts.empty()) lines.push_back("scripts are left out: bodies do not follow them");
  return lines;
}

void writeReadme(const std::filesystem::path& file, const BuiltScene& scene, const ExportArguments& arguments,
                 const granular::LammpsDef& def, const granular::LammpsReport& report,
                 const std::vector<std::string>& leftOut) {
  std::ofstream out(file);
  out << "# " << scene.def().name << ", scale " << scene.def().scale << ", as input for LAMMPS\n\n"
      << scene.def().description << "\n\n"
      << "    lmp -in in.granular            # or: mpirun -np 8 lmp -in in.granular\n\n"
      << "Begins " << arguments.after << " s into the scene. " << def.steps << " steps of " << report.timeStep
      << " s; a state every " << def.dumpEvery
      << " steps in particles.dump. SI units, y up as in the scene.\n\n"
      << "| | |\n|---|---|\n"
      << "| `in.granular` | input script |\n"
      << "| `particles.data` | " << report.atoms << " particles, " << report.frozenAtoms
      << " of them held |\n";
  if (report.rigidBodies > 0) {
    out << "| `bodies.rigid` | mass, centre and inertia of " << report.rigidBodies << " rigid bodies |\n";
  }
  out << "\n"
      << report.types << " atom types, " << report.walls << " walls.\n\n## Left out, or otherwise there\n\n";
  for (const std::string& line : leftOut) out << "- " << line << '\n';
  if (leftOut.empty()) out << "Nothing.\n";
  out.close();
  if (!out) throw std::runtime_error(file.string() + " cannot be written");
}

}  // namespace

CLI::App* addExportCommand(CLI::App& app, ExportArguments& a) {
  CLI::App* command = app.add_subcommand("export", "Writes a scene as input for another program");
  command->add_option("scene", a.scene, "Name of a scene (see list) or a scene file")->required();
  command->add_option("--lammps", a.lammps, "Folder for LAMMPS's data file, input script and a README")
      ->required();
  command->add_option("--scale", a.scale, "Size of the scene: one of its \"scales\"")->capture_default_str();
  command->add_option("--seed", a.seed, "Seed of fills and coverings, instead of the scene's");
  command->add_option("--after", a.after, "Simulate so many seconds here first")->check(CLI::Range(0.0, 1e6));
  command
      ->add_option("--time-step", a.timeStep,
                   "LAMMPS's time step, s; default: a fiftieth of the shortest contact time")
      ->check(CLI::Range(1e-12, 1.0));
  command->add_option("--threads", a.threads, "Threads that cover bodies and simulate")
      ->check(CLI::Range(1, 1024));
  return command;
}

int runExport(const ExportArguments& arguments) {
  SceneDef def = readSceneFile(findScene(arguments.scene), arguments.scale);
  if (arguments.seed) def.seed = *arguments.seed;
  BuiltScene scene(std::move(def), arguments.threads);
  while (scene.time() < arguments.after) scene.tick();

  granular::LammpsDef lammps;
  lammps.timeStep = arguments.timeStep.value_or(granular::lammpsTimeStep(scene.grains()));
  lammps.dumpEvery = std::max<std::int64_t>(1, std::llround(scene.def().frameDuration() / lammps.timeStep));
  lammps.steps = scene.def().frameCount() * lammps.dumpEvery;
  const granular::LammpsReport report = granular::writeLammps(scene.grains(), arguments.lammps, lammps);
  std::vector<std::string> leftOut = leftOutOfScene(scene.def());
  leftOut.insert(leftOut.end(), report.notes.begin(), report.notes.end());
  writeReadme(arguments.lammps / "README.md", scene, arguments, lammps, report, leftOut);
  std::printf("%lld particles (%lld held), %lld rigid bodies, %lld walls, %d types, time step %.3g s\n",
              static_cast<long long>(report.atoms), static_cast<long long>(report.frozenAtoms),
              static_cast<long long>(report.rigidBodies), static_cast<long long>(report.walls), report.types,
              report.timeStep);
  for (const std::string& line : leftOut) std::printf("left out: %s\n", line.c_str());
  std::printf("wrote %s\n", arguments.lammps.string().c_str());
  return 0;
}

}  // namespace granular_demo
