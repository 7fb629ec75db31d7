// SPDX-License-Identifier: MIT
#include "demos/runner/stop_signal.h"

#include <csignal>

namespace granular_demo {
namespace {

volatile std::sig_atomic_t stopAsked = 0;

void askToStop(int signal) {
  stopAsked = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void listenForStopSignals() {
  std::signal(SIGINT, askToStop);
  std::signal(SIGTERM, askToStop);
}

bool stopWasAsked() {
  return stopAsked != 0;
}

}  // namespace granular_demo
