// SPDX-License-Identifier: MIT
// ffmpeg is started with posix_spawnp and a list of arguments: no shell reads the paths.
#include "demos/render/film.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "granular/base/require.h"

extern char** environ;

namespace granular_demo {
namespace {

namespace fs = std::filesystem;

/// A pipe whose ends close themselves.
class Pipe {
 public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  }
  ~Pipe() {
    closeEnd(0);
    closeEnd(1);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;

  int writeEnd() const { return ends_[1]; }
  void closeWriteEnd() { closeEnd(1); }

  std::string readAll() const {
    std::string text;
    std::array<char, 4096> buffer;
    for (;;) {
      const ssize_t count = read(ends_[0], buffer.data(), buffer.size());
      if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
      if (count == 0 || (count < 0 && errno != EINTR)) return text;
    }
  }

 private:
  void closeEnd(std::size_t i) {
    if (ends_[i] >= 0) close(ends_[i]);
    ends_[i] = -1;
  }

  std::array<int, 2> ends_ = {-1, -1};
};

/// Where the child's three standard streams go.
class ChildFiles {
 public:
  explicit ChildFiles(int errorStream) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, errorStream, STDERR_FILENO);
  }
  ~ChildFiles() { posix_spawn_file_actions_destroy(&actions_); }
  ChildFiles(const ChildFiles&) = delete;
  ChildFiles& operator=(const ChildFiles&) = delete;

  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

struct Outcome {
  int status;         // as waitpid gives it
  std::string words;  // what it wrote to its error stream
};

Outcome runProgram(std::vector<std::string> arguments) {
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  Pipe words;
  const ChildFiles files(words.writeEnd());
  pid_t child = 0;
  const int error = posix_spawnp(&child, pointers[0], files.get(), nullptr, pointers.data(), environ);
  if (error == ENOENT)
    throw std::runtime_error("Cannot find the program '" + arguments[0] +
                             "' on PATH; it makes films of frames (Debian: apt-get install ffmpeg)");
  if (error != 0) throw std::runtime_error("Cannot start '" + arguments[0] + "': " + std::strerror(error));
  words.closeWriteEnd();
  Outcome outcome{0, words.readAll()};
  while (waitpid(child, &outcome.status, 0) < 0)
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "waitpid");
  return outcome;
}

std::string endingOf(const Outcome& outcome) {
  if (WIFSIGNALED(outcome.status)) return "was stopped by signal " + std::to_string(WTERMSIG(outcome.status));
  return "ended with code " + std::to_string(WEXITSTATUS(outcome.status));
}

/// The tail of a text on one line.
std::string lastWords(std::string text) {
  constexpr std::size_t kMost = 400;
  if (text.size() > kMost) text = "..." + text.substr(text.size() - kMost);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text.empty() ? "no message" : text;
}

std::string numberText(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

fs::path framePath(const fs::path& folder, int index) {
  std::array<char, 32> name;
  std::snprintf(name.data(), name.size(), "frame_%05d.png", index);
  return folder / name.data();
}

fs::path writeFilm(const FilmSettings& settings) {
  granular::requirePositive(settings.framesPerSecond, "FilmSettings.framesPerSecond", "1/s");
  granular::require(settings.quality >= 0 && settings.quality <= 51, "FilmSettings.quality", settings.quality,
                    "", "in [0, 51]");
  granular::require(!settings.file.empty(), "FilmSettings.file", "empty", "", "the path of the film");
  const fs::path first = framePath(settings.frameFolder, 0);
  granular::require(fs::exists(first), "FilmSettings.frameFolder", settings.frameFolder.string(), "",
                    "a folder with frame_00000.png");
  const fs::path file = fs::absolute(settings.file);
  // A percent sign in the folder would be read as a pattern: ffmpeg wants it doubled.
  std::string folder;
  for (const char c : fs::absolute(settings.frameFolder).string()) folder.append(c == '%' ? 2 : 1, c);
  const Outcome outcome = runProgram({"ffmpeg",
                                      "-hide_banner",
                                      "-loglevel",
                                      "error",
                                      "-y",
                                      "-framerate",
                                      numberText(settings.framesPerSecond),
                                      "-i",
                                      folder + "/frame_%05d.png",
                                      "-vf",
                                      "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p",
                                      "-c:v",
                                      "libx264",
                                      "-preset",
                                      "medium",
                                      "-crf",
                                      std::to_string(settings.quality),
                                      "-movflags",
                                      "+faststart",
                                      "-f",
                                      "mp4",
                                      "file:" + file.string()});
  if (outcome.status != 0)
    throw std::runtime_error("ffmpeg could not write film '" + file.string() + "': it " + endingOf(outcome) +
                             ": " + lastWords(outcome.words));
  return file;
}

}  // namespace granular_demo
