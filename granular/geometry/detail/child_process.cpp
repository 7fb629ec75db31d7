// SPDX-License-Identifier: MIT
#include "granular/geometry/detail/child_process.h"

#if defined(__unix__)

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string_view>

namespace granular::detail {
namespace {

constexpr char kResult = 'R', kError = 'E';  // first byte of an answer; then 8 bytes of length, then the text
constexpr std::size_t kHead = 9;

/// Address space of this process, bytes; 0 where it cannot be told.
std::uint64_t addressSpace() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limitMemory(std::int64_t more) {
  const std::uint64_t now = addressSpace();
  if (now == 0) return;
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, now + static_cast<std::uint64_t>(more));
  setrlimit(RLIMIT_AS, &limit);
}

/// A crash here must end the child, not call the host's handlers, and say nothing on its screen.
void beQuiet() {
  for (int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTERM, SIGINT}) std::signal(signal, SIG_DFL);
  const rlimit noCore{0, 0};
  setrlimit(RLIMIT_CORE, &noCore);
  const int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere < 0) return;
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
}

bool writeAll(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

void answer(int file, char kind, std::string_view text) {
  std::array<char, kHead> head{kind};
  const std::uint64_t length = text.size();
  std::memcpy(head.data() + 1, &length, sizeof length);
  writeAll(file, {head.data(), head.size()}) && writeAll(file, text);
}

[[noreturn]] void workAsChild(int file, const ChildLimits& limits, const std::function<std::string()>& work) {
  beQuiet();
  limitMemory(limits.memoryBytes);
  try {
    answer(file, kResult, work());
  } catch (const std::bad_alloc&) {
    answer(file, kError, "it needs more than " + std::to_string(limits.memoryBytes >> 20) + " MiB of memory");
  } catch (const std::exception& error) {
    answer(file, kError, error.what());
  } catch (...) {
    answer(file, kError, "it failed for no reason given");
  }
  _exit(0);
}

/// Reads until the other end is closed. Returns whether that came in time.
bool readAll(int file, double seconds, std::string& bytes) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  std::array<char, 1 << 16> buffer;
  while (true) {
    const std::chrono::duration<double, std::milli> left = end - std::chrono::steady_clock::now();
    if (left.count() <= 0.0) return false;
    pollfd ready{file, POLLIN, 0};
    const int count = poll(&ready, 1, static_cast<int>(std::min(left.count() + 1.0, 1e6)));
    if (count <= 0) continue;  // interrupted, or the time is up
    const ssize_t got = read(file, buffer.data(), buffer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    bytes.append(buffer.data(), static_cast<std::size_t>(got));
  }
}

/// The text of an answer, if all of it came.
bool isWhole(const std::string& bytes) {
  std::uint64_t length = 0;
  if (bytes.size() < kHead) return false;
  std::memcpy(&length, bytes.data() + 1, sizeof length);
  return bytes.size() - kHead == length;
}

int waitFor(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 0;  // the host ignores its children: how this one ended is not known
  }
  return status;
}

}  // namespace

std::string runInChild(const ChildLimits& limits, const std::function<std::string()>& work) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  const pid_t child = fork();
  if (child < 0) {
    const std::string why = std::strerror(errno);
    close(ends[0]);
    close(ends[1]);
    throw std::runtime_error("no child process: " + why);
  }
  if (child == 0) {
    close(ends[0]);
    workAsChild(ends[1], limits, work);
  }
  close(ends[1]);
  std::string bytes;
  const bool inTime = readAll(ends[0], limits.seconds, bytes);
  close(ends[0]);
  if (!inTime) kill(child, SIGKILL);
  const int status = waitFor(child);
  if (!inTime) throw std::runtime_error("it takes longer than " + std::to_string(limits.seconds) + " s");
  if (!isWhole(bytes)) {
    throw std::runtime_error(WIFSIGNALED(status) ? std::string("it crashes: ") + strsignal(WTERMSIG(status))
                                                 : "it ends without an answer");
  }
  std::string text = bytes.substr(kHead);
  if (bytes.front() == kError) throw std::runtime_error(text);
  return text;
}

}  // namespace granular::detail

#else

namespace granular::detail {

std::string runInChild(const ChildLimits&, const std::function<std::string()>& work) {
  return work();
}

}  // namespace granular::detail

#endif
