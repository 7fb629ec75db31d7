// SPDX-License-Identifier: MIT
// Runs work that may crash, hang or eat memory in a child process with limits, and brings back the bytes it
// makes. POSIX only; elsewhere the work runs in the caller.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace granular::detail {

struct ChildLimits {
  double seconds = 60.0;                             ///< of wall time
  std::int64_t memoryBytes = std::int64_t{4} << 30;  ///< beyond what the process has already
};

/// What work() returned. If it throws, a std::runtime_error with the same text. If the child dies, runs too
/// long or needs too much memory, a std::runtime_error that says which. The child is a fork: it sees all
/// memory as it is, changes none of the caller's, prints nothing, and runs no exit handlers.
std::string runInChild(const ChildLimits& limits, const std::function<std::string()>& work);

}  // namespace granular::detail
