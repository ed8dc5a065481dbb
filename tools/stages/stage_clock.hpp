// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace bouncelab::stages {

/// Wall and processor time of each stage, in order.
class StageClock {
 public:
  /// Runs one stage and notes its time under `name`.
  template <class Work>
  auto time(const std::string& name, Work&& work) {
    const Timer timer{*this, name};
    return work();
  }
  const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; }
  /// Of all threads.
  const std::vector<std::pair<std::string, double>>& processor_seconds() const { return processor_seconds_; }

 private:
  using Clock = std::chrono::steady_clock;
  static double processor_time_s() {
    std::timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }
  struct Timer {
    StageClock& clock;
    std::string name;
    Clock::time_point start = Clock::now();
    double processor_start_s = processor_time_s();
    ~Timer() {
      clock.seconds_.emplace_back(name, std::chrono::duration<double>(Clock::now() - start).count());
      clock.processor_seconds_.emplace_back(name, processor_time_s() - processor_start_s);
    }
  };
  std::vector<std::pair<std::string, double>> seconds_, processor_seconds_;
};

}  // namespace bouncelab::stages
