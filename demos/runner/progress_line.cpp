// SPDX-License-Identifier: MIT
#include "demos/runner/progress_line.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace granular_demo {
namespace {

constexpr int kBarWidth = 30;         // characters
constexpr double kLineSpacing = 1.0;  // s between plain lines

std::string barText(double fraction) {
  const int done = static_cast<int>(std::floor(fraction * kBarWidth));
  std::string bar(kBarWidth + 2, '.');
  bar.front() = '[';
  bar.back() = ']';
  std::fill_n(bar.begin() + 1, done, '#');
  return bar;
}

}  // namespace

std::string clockText(double seconds) {
  const long s = std::lround(seconds);
  char text[32];
  if (s >= 3600) {
    std::snprintf(text, sizeof text, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
  } else {
    std::snprintf(text, sizeof text, "%ld:%02ld", s / 60, s % 60);
  }
  return text;
}

ProgressLine::ProgressLine()
    : isTerminal_(isatty(STDERR_FILENO) != 0), start_(Clock::now()), lastLine_(start_) {}

void ProgressLine::update(const RunProgress& progress) {
  const Clock::time_point now = Clock::now();
  const bool isLast = progress.frame == progress.frames;
  if (!isTerminal_ && !isLast && std::chrono::duration<double>(now - lastLine_).count() < kLineSpacing)
    return;
  lastLine_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double rate = elapsed > 0.0 ? progress.frame / elapsed : 0.0;
  const double left = rate > 0.0 ? (progress.frames - progress.frame) / rate : 0.0;
  const std::string bar = barText(static_cast<double>(progress.frame) / progress.frames);
  std::fprintf(stderr, "%s%s frame %d/%d  t = %.3f s  %lld contacts  %.2f frames/s  %s left%s",
               isTerminal_ ? "\r\033[K" : "", isTerminal_ ? bar.c_str() : "", progress.frame, progress.frames,
               progress.time, static_cast<long long>(progress.contacts), rate, clockText(left).c_str(),
               isTerminal_ ? "" : "\n");
  std::fflush(stderr);
  hasBar_ = isTerminal_;
}

void ProgressLine::finish() {
  if (hasBar_) std::fputc('\n', stderr);
  hasBar_ = false;
}

}  // namespace granular_demo
