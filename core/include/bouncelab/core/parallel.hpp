// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <future>
#include <thread>
#include <vector>

namespace bouncelab {

/// 0 means all cores.
inline int resolved_threads(int n_threads) {
  return n_threads > 0 ? n_threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Runs task(k) for k = 0 ... n-1 on so many threads, each on a stretch of its own. Rethrows what a task threw.
template <class Task>
void in_parallel(std::size_t n, int n_threads, const Task& task) {
  const std::size_t n_stretches =
      std::clamp<std::size_t>(static_cast<std::size_t>(n_threads), 1, std::max<std::size_t>(n, 1));
  std::vector<std::future<void>> running;
  for (std::size_t s = 0; s < n_stretches; ++s)
    running.push_back(
        std::async(n_stretches == 1 ? std::launch::deferred : std::launch::async, [&task, n, s, n_stretches] {
          for (std::size_t k = n * s / n_stretches; k < n * (s + 1) / n_stretches; ++k) task(k);
        }));
  for (auto& stretch : running) stretch.get();
}

}  // namespace bouncelab
