// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/parallel.hpp"
#include "bouncelab/loop/closed_loop.hpp"
#include "stages/run.hpp"

namespace bouncelab::stages {

/// From now on the next progress call after Ctrl-C, SIGTERM or SIGHUP throws Interrupted; a second signal, more than
/// 0.2 s later, ends the program at once. A limit of the size of files, and a pipe that nobody reads, make writing
/// fail.
void notice_signals();

/// A line on standard error with work done, rate and time left, where that is a terminal and --quiet was not given;
/// nothing otherwise; run.on_progress where that is set. Either way the callback throws Interrupted once the user asked
/// to stop.
/// @param label  what is being done ("simulate")
/// @param unit   what is counted ("drops", "s of sound")
ProgressCallback progress_line(const Run& run, const std::string& label, const std::string& unit);

/// The same for the stages of a loop.
loop::StageProgress stage_progress(const Run& run);
/// For the stages of a loop: shows nothing, throws Interrupted once the user asked to stop.
ProgressCallback interrupts_only(const std::string& label, const std::string& unit);

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
