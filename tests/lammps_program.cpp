// SPDX-License-Identifier: MIT
#include "tests/lammps_program.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>
#include <stdexcept>

namespace granular_test {
namespace {

/// The line of the log that begins with `start`; empty if there is none.
std::string logLine(const std::filesystem::path& folder, const std::string& start) {
  std::ifstream log(folder / "log.lammps");
  for (std::string line; std::getline(log, line);) {
    if (line.starts_with(start)) return line;
  }
  return "";
}

/// In the child: nothing here may allocate or throw.
[[noreturn]] void becomeLammps(const char* program, const char* folder) {
  const int nothing = open("/dev/null", O_RDWR);
  if (chdir(folder) == 0 && nothing >= 0) {
    dup2(nothing, STDIN_FILENO);
    dup2(nothing, STDOUT_FILENO);
    dup2(nothing, STDERR_FILENO);
    setenv("OMP_NUM_THREADS", "1", 1);
    execl(program, program, "-in", "in.granular", "-log", "log.lammps", "-screen", "none", nullptr);
  }
  _exit(127);
}

}  // namespace

LammpsRun runLammps(const std::filesystem::path& program, const std::filesystem::path& folder) {
  std::filesystem::remove(folder / "log.lammps");
  const std::string programName = program.string(), folderName = folder.string();
  const pid_t child = fork();
  if (child == 0) becomeLammps(programName.c_str(), folderName.c_str());
  int status = 0;
  rusage usage{};
  if (child < 0 || wait4(child, &status, 0, &usage) != child) {
    throw std::runtime_error(programName + " cannot be started");
  }
  const std::string complaint = logLine(folder, "ERROR"), loop = logLine(folder, "Loop time of ");
  if (!complaint.empty()) throw std::runtime_error(folderName + "/in.granular: LAMMPS says " + complaint);
  if (status != 0 || loop.empty()) {
    throw std::runtime_error(folderName + "/in.granular: LAMMPS did not come to its end");
  }
  LammpsRun run;
  const auto numberAfter = [](const std::string& line, const std::string& start, auto& number) {
    if (line.size() > start.size()) std::istringstream(line.substr(start.size())) >> number;
  };
  numberAfter(loop, "Loop time of ", run.loopSeconds);
  const std::string builds = "Neighbor list builds = ";
  numberAfter(logLine(folder, builds), builds, run.listBuilds);
  run.peakBytes = std::int64_t{1024} * usage.ru_maxrss;
  return run;
}

std::vector<DumpedState> readDump(const std::filesystem::path& folder) {
  std::ifstream file(folder / "particles.dump");
  std::vector<DumpedState> states;
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) {
    if (line == "ITEM: TIMESTEP") {
      states.emplace_back();
      file >> states.back().step;
    } else if (line == "ITEM: NUMBER OF ATOMS") {
      file >> count;
    } else if (line.starts_with("ITEM: ATOMS")) {
      std::int64_t id = 0, type = 0;
      for (std::size_t i = 0; i < count; ++i) {
        DumpedAtom atom;
        file >> id >> type;
        for (granular::Vector3* v : {&atom.position, &atom.velocity, &atom.angularVelocity, &atom.force}) {
          file >> v->x() >> v->y() >> v->z();
        }
        states.back().atoms.push_back(atom);
      }
    }
  }
  if (states.empty() || states.back().atoms.size() != count) {
    throw std::runtime_error((folder / "particles.dump").string() + " holds no whole state");
  }
  return states;
}

}  // namespace granular_test
