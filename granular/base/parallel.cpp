// SPDX-License-Identifier: MIT
#include "granular/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace granular {

struct Executor::Threads {
  explicit Threads(int threads)
      : allowed(tbb::global_control::max_allowed_parallelism, threads), arena(threads) {}

  tbb::global_control allowed;  // more threads than cores when asked for: results must not depend on it
  tbb::task_arena arena;
};

Executor::Executor(int threads, HostExecutor* host) : threads_(threads), host_(host) {
  if (threads > 1 && !host) pool_ = std::make_unique<Threads>(threads);
}
Executor::~Executor() = default;

void Executor::enter(const std::function<void()>& work) const {
  pool_->arena.execute([&] { work(); });
}

void Executor::runPieces(std::int32_t pieces, const std::function<void(std::int32_t)>& body) const {
  if (host_) {
    host_->run(pieces, body);
    return;
  }
  pool_->arena.execute([&] {  // at once where we are inside the arena already
    tbb::parallel_for(
        tbb::blocked_range<std::int32_t>(0, pieces, 1),
        [&](const tbb::blocked_range<std::int32_t>& range) {
          for (std::int32_t piece = range.begin(); piece != range.end(); ++piece) body(piece);
        },
        tbb::simple_partitioner());
  });
}

}  // namespace granular
