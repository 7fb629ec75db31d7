// SPDX-License-Identifier: MIT
// Independent pieces of work shared out among threads. Not TBB: Embree limits TBB to one thread while a scene
// is built (see ray_scene.cpp).
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace granular_demo {

/// Calls work(i) once for each i in [0, count), in no particular order. `work` must not throw.
template <class Work>
void parallelFor(int threads, int count, const Work& work) {
  std::atomic<int> next{0};
  const auto takePieces = [&] {
    for (int i = next++; i < count; i = next++) work(i);
  };
  std::vector<std::jthread> helpers;
  for (int t = 1; t < std::min(threads, count); ++t) helpers.emplace_back(takePieces);
  takePieces();
}

}  // namespace granular_demo
