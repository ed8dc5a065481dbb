// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string>
#include <utility>
#include <vector>

namespace bouncelab::cli {

/// Wall time of each stage, in order.
class StageClock {
 public:
  /// Runs one stage and notes its time under `name`.
  template <class Work>
  auto time(const std::string& name, Work&& work) {
    const Timer timer{*this, name};
    return work();
  }
  const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; }

 private:
  using Clock = std::chrono::steady_clock;
  struct Timer {
    StageClock& clock;
    std::string name;
    Clock::time_point start = Clock::now();
    ~Timer() { clock.seconds_.emplace_back(name, std::chrono::duration<double>(Clock::now() - start).count()); }
  };
  std::vector<std::pair<std::string, double>> seconds_;
};

}  // namespace bouncelab::cli
