// SPDX-License-Identifier: MIT
// Work shared among threads in pieces that do not depend on how many threads there are. Every loop here
// writes to places of its own piece, so that results are the same bits for any number of threads.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>

namespace granular {

/// Threads of a host that has its own: a job system, a pool. Which pieces there are does not depend on it, so
/// results are the same bits on any.
class HostExecutor {
 public:
  virtual ~HostExecutor() = default;
  /// Calls body(piece) once for every piece in [0, pieces), in any order and on any threads, and returns when
  /// all have returned. Called from the thread that steps the system; `body` throws nothing and calls no run.
  virtual void run(std::int32_t pieces, const std::function<void(std::int32_t)>& body) = 0;
};

/// Runs loops on a fixed number of threads, or on those of a host. One thread runs everything in the caller
/// and starts nothing.
class Executor {
 public:
  /// @param host  runs every loop where it is given, and must outlive this; null: own threads
  explicit Executor(int threads, HostExecutor* host = nullptr);
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  int threads() const { return threads_; }
  bool isParallel() const { return pool_ || host_; }

  /// Runs work() with the threads at hand. Loops inside it share them without further ado; loops outside have
  /// to gather them first, each on its own.
  template <class Work>
  void gather(Work&& work) const {
    if (!pool_) {
      work();
    } else {
      enter(work);
    }
  }

  /// body(piece) for every piece in [0, pieces), in any order and on any thread.
  template <class Body>
  void forPieces(std::int32_t pieces, Body&& body) const {
    if (pieces <= 1 || !isParallel()) {
      for (std::int32_t piece = 0; piece < pieces; ++piece) body(piece);
    } else {
      runPieces(pieces, std::ref(body));
    }
  }

  /// body(begin, end) over [0, count) in pieces of `grain` items.
  template <class Body>
  void forRanges(std::int64_t count, std::int64_t grain, Body&& body) const {
    forPieces(pieceCount(count, grain), [&](std::int32_t piece) {
      const std::int64_t begin = piece * grain;
      body(begin, std::min(count, begin + grain));
    });
  }

  static std::int32_t pieceCount(std::int64_t count, std::int64_t grain) {
    return static_cast<std::int32_t>((count + grain - 1) / grain);
  }

 private:
  struct Threads;
  void enter(const std::function<void()>& work) const;
  void runPieces(std::int32_t pieces, const std::function<void(std::int32_t)>& body) const;

  int threads_;
  HostExecutor* host_;
  std::unique_ptr<Threads> pool_;  // none for one thread, or where the host has them
};

}  // namespace granular
