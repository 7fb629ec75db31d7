// SPDX-License-Identifier: MIT
// The core's loops on the threads of a Bullet task scheduler (LinearMath/btThreads.h), so that a program
// whose world runs on one has no second pool of threads:
//
//   bullet_bridge::TaskSchedulerExecutor executor(*btGetTaskScheduler());
//   bullet_bridge::GranularLayer sand(world, {.executor = &executor});
//
// A Bullet built without BT_THREADSAFE (Debian's) has the sequential scheduler only.
#pragma once

#include <LinearMath/btThreads.h>

#include "bullet_bridge/precision.h"
#include "granular/base/parallel.h"

namespace bullet_bridge {
inline namespace BULLET_BRIDGE_PRECISION {

class TaskSchedulerExecutor : public granular::HostExecutor {
 public:
  /// The scheduler must outlive the executor.
  explicit TaskSchedulerExecutor(btITaskScheduler& scheduler) : scheduler_(scheduler) {}

  void run(std::int32_t pieces, const std::function<void(std::int32_t)>& body) override {
    scheduler_.parallelFor(0, pieces, 1, Loop(body));
  }

 private:
  class Loop : public btIParallelForBody {
   public:
    explicit Loop(const std::function<void(std::int32_t)>& body) : body_(body) {}
    void forLoop(int begin, int end) const override {
      for (int piece = begin; piece < end; ++piece) body_(piece);
    }

   private:
    const std::function<void(std::int32_t)>& body_;
  };

  btITaskScheduler& scheduler_;
};

}  // namespace BULLET_BRIDGE_PRECISION
}  // namespace bullet_bridge
