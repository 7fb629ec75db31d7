// SPDX-License-Identifier: MIT
// The program granular_demo from outside: exit status, what it prints, Ctrl-C.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

namespace {

std::filesystem::path scratchFolder(const std::string& name) {
  const auto folder = std::filesystem::path(::testing::TempDir()) / ("granular_program_" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

std::string textOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

std::ptrdiff_t linesIn(const std::filesystem::path& file) {
  const std::string text = textOf(file);
  return std::count(text.begin(), text.end(), '\n');
}

/// One run of the program, its two outputs in files of a folder.
class Program {
 public:
  Program(const std::filesystem::path& folder, std::vector<std::string> arguments) : folder_(folder) {
    arguments.insert(arguments.begin(), GRANULAR_DEMO_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    process_ = fork();
    if (process_ == 0) {
      redirect(STDOUT_FILENO, "stdout");
      redirect(STDERR_FILENO, "stderr");
      execv(argv[0], argv.data());
      _exit(127);
    }
  }

  void send(int signal) const { kill(process_, signal); }

  /// Exit status, or -1 if it did not end by itself.
  int wait() const {
    int status = 0;
    waitpid(process_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::string output() const { return textOf(folder_ / "stdout"); }
  std::string errors() const { return textOf(folder_ / "stderr"); }

 private:
  void redirect(int descriptor, const char* name) const {
    const int file = open((folder_ / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(file, descriptor);
  }

  std::filesystem::path folder_;
  pid_t process_ = 0;
};

TEST(Program, ListsTheScenes) {
  const Program program(scratchFolder("list"), {"list"});
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.output().find("splash"), std::string::npos);
  EXPECT_EQ(program.errors(), "");
}

TEST(Program, RefusesAnUnknownSceneInOneLine) {
  const auto folder = scratchFolder("unknown");
  const Program program(folder, {"run", "beach"});
  EXPECT_EQ(program.wait(), 2);
  EXPECT_EQ(program.output(), "");
  EXPECT_TRUE(program.errors().starts_with("beach: no such file or scene; scenes: ")) << program.errors();
  EXPECT_EQ(linesIn(folder / "stderr"), 1);
}

TEST(Program, RefusesAWrongSceneFileInOneLine) {
  const auto folder = scratchFolder("wrong");
  std::ofstream(folder / "bad.json") << R"({"name": "bad", "duration": 0})";
  const Program program(folder, {"run", (folder / "bad.json").string()});
  EXPECT_EQ(program.wait(), 2);
  EXPECT_EQ(program.errors(),
            (folder / "bad.json").string() + ": duration: value 0; allowed: a number > 0\n");
}

TEST(Program, RefusesABadArgumentWithStatusTwo) {
  EXPECT_EQ(Program(scratchFolder("argument"), {"run", "splash", "--frames", "-3"}).wait(), 2);
}

TEST(Program, EndsWithStatusThreeAndOneLineWhenACheckFails) {
  const auto folder = scratchFolder("check");
  // No floor under the grain: after 0.5 s it is 1.2 m below where it started, and the ground is 1 m below.
  std::ofstream(folder / "hole.json") << R"({
    "name": "hole", "duration": 0.5, "groundHeight": 0, "materials": {"sand": {}},
    "shapes": {"ball": {"type": "sphere", "particleRadius": 0.01}},
    "grains": {"stone": {"shape": "ball", "material": "sand", "position": [0, 1, 0]}}})";
  const Program program(folder,
                        {"run", (folder / "hole.json").string(), "--no-pictures", "--out", folder.string()});
  EXPECT_EQ(program.wait(), 3);
  // The last of the error output; the progress comes before it.
  const std::string errors = program.errors();
  const std::string line = errors.substr(std::min(errors.find("checks FAILED: "), errors.size()));
  EXPECT_NE(line.find(" 1 below ground"), std::string::npos) << errors;
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << errors;
  const auto report = nlohmann::json::parse(textOf(folder / "report.json"));
  EXPECT_EQ(report["result"], "completed");
  EXPECT_EQ(report["checks"]["passed"], false);
}

TEST(Program, ExportsASceneForLammpsAndTellsWhatItLeftOut) {
  const auto folder = scratchFolder("export");
  std::ofstream(folder / "two.json") << R"({
    "name": "two", "duration": 0.1, "materials": {"sand": {}},
    "shapes": {"ball": {"type": "sphere", "particleRadius": 0.01}},
    "bodies": {"alone": {"shape": {"type": "sphere", "radius": 0.1}, "motion": "dynamic", "density": 1000,
                         "material": "sand", "position": [5, 0, 0]}},
    "grains": {"left": {"shape": "ball", "material": "sand", "position": [0, 1, 0]},
               "right": {"shape": "ball", "material": "sand", "position": [1, 1, 0]}}})";
  const auto lammps = folder / "lammps";
  const Program program(
      folder, {"export", (folder / "two.json").string(), "--lammps", lammps.string(), "--time-step", "1e-5"});
  EXPECT_EQ(program.wait(), 0) << program.errors();
  EXPECT_NE(program.output().find("2 particles (0 held), 0 rigid bodies"), std::string::npos);
  EXPECT_NE(textOf(lammps / "particles.data").find("\n2 atoms\n"), std::string::npos);
  // 0.1 s at 30 frames a second: three frames of 3333 steps.
  EXPECT_NE(textOf(lammps / "in.granular").find("\nrun 9999\n"), std::string::npos);
  EXPECT_NE(textOf(lammps / "README.md").find("1 body that Bullet alone moves is left out"),
            std::string::npos);
}

TEST(Program, TellsItsExitStatusesInTheHelp) {
  const Program program(scratchFolder("help"), {"run", "--help"});
  EXPECT_EQ(program.wait(), 0);
  EXPECT_NE(program.output().find("3 completed, but a check failed"), std::string::npos) << program.output();
}

TEST(Program, PrintsItsAdviceBeforeItRuns) {
  const auto folder = scratchFolder("advice");
  // So soft that whatever hits anything goes right through it.
  std::ofstream(folder / "soft.json") << R"({
    "name": "soft", "duration": 0.01, "materials": {"jelly": {"density": 1000, "youngsModulus": 1000}},
    "shapes": {"ball": {"type": "sphere", "particleRadius": 0.01}},
    "grains": {"drop": {"shape": "ball", "material": "jelly", "position": [0, 1, 0], "velocity": [0, -8, 0]}},
    "bodies": {"ground": {"shape": {"type": "halfSpace"}, "material": "jelly", "contact": "exact"}}})";
  const Program program(folder,
                        {"run", (folder / "soft.json").string(), "--no-pictures", "--out", folder.string()});
  EXPECT_EQ(program.wait(), 0) << program.errors();
  const std::string output = program.output();
  EXPECT_TRUE(
      output.starts_with("advice: reckoned for impacts at 8 m/s (the largest speed at the start)\nadvice: "))
      << output;
  EXPECT_NE(output.find("advice: jelly on jelly: impacts at 8 m/s overlap by up to "), std::string::npos)
      << output;
}

TEST(Program, RunsTheFramesAskedForAndReports) {
  const auto folder = scratchFolder("run");
  const Program program(folder,
                        {"run", "splash", "--scale", "small", "--frames", "2", "--no-pictures", "--out",
                         (folder / "out").string(), "--report", (folder / "my.json").string()});
  EXPECT_EQ(program.wait(), 0) << program.errors();
  const auto report = nlohmann::json::parse(textOf(folder / "my.json"));
  EXPECT_EQ(report["result"], "completed");
  EXPECT_EQ(report["frames"], 2);
  EXPECT_FALSE(std::filesystem::exists(folder / "out/frames"));
}

TEST(Program, WritesPicturesAndAFilm) {
  const auto folder = scratchFolder("pictures");
  const Program program(folder, {"run", "pile", "--scale", "small", "--frames", "2", "--width", "64",
                                 "--height", "36", "--out", folder.string()});
  EXPECT_EQ(program.wait(), 0) << program.errors();
  for (const char* file : {"frames/frame_00000.png", "frames/frame_00002.png", "film.mp4"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / file)) << file;
  }
}

class ProgramSignal : public ::testing::TestWithParam<int> {};

TEST_P(ProgramSignal, EndsARunCleanly) {
  const auto folder = scratchFolder("signal_" + std::to_string(GetParam()));
  const Program program(folder, {"run", "splash", "--scale", "small", "--frames", "100000", "--no-pictures",
                                 "--out", folder.string()});
  // Column names, the row of the start, the first frame's row: it is stepping now. CTest ends a test that
  // hangs.
  while (linesIn(folder / "frames.csv") < 3) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  program.send(GetParam());
  EXPECT_EQ(program.wait(), 130);
  EXPECT_EQ(nlohmann::json::parse(textOf(folder / "report.json"))["result"], "interrupted");
  const std::string table = textOf(folder / "frames.csv");
  EXPECT_EQ(table.back(), '\n');  // whole rows only
}

INSTANTIATE_TEST_SUITE_P(InterruptAndTerminate, ProgramSignal, ::testing::Values(SIGINT, SIGTERM));

}  // namespace
