// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

namespace bouncelab::stages {

Description members_of(const CommonOptions*) {
  using O = CommonOptions;
  static constexpr Member options[]{
      member<&O::seed>("seed", "Seed of all random numbers"),
      member<&O::n_threads>("threads", "Threads, 0 = all cores; results do not depend on it").within(0, 1024),
      member<&O::config>("config", "TOML file of options: KEY = VALUE; the command line wins").looks_like("FILE"),
      member<&O::json>("json", "Summary as JSON on standard output"),
      member<&O::quiet>("quiet", "No progress, no summary; errors only"),
      member<&O::force>("force", "Replace outputs that exist")};
  return options;
}

Section common_section(CommonOptions& common) { return section_of(common, "Every command has"); }

Parameters parameters_of(const std::vector<Section>& sections, const Given& given) {
  Parameters parameters;
  for (const Option& option : options_of(sections)) {
    const std::string name = option_name(*option.member);
    const auto typed = given.find(name);
    parameters.push_back(
        {name, typed != given.end() ? typed->second : std::vector{default_text(*option.member, option.object)},
         option.member->is_output});
  }
  return parameters;
}

namespace {

/// The first asks to stop, which leaves nothing half-written; the second ends the program at once, also where a library
/// does not return. `timeout`, and some terminals, send one request twice, to the program and to its group, at the same
/// moment; the two arrive together, while a person who loses patience needs longer. Who sent it does not tell them
/// apart: a terminal's signals come from the kernel, those of `timeout` from one process, as two `kill` from a shell.
extern "C" void on_stop_signal(int signal) {
  constexpr std::int64_t kSameRequest_ns = 200'000'000;
  static std::atomic<std::int64_t> first_ns = 0;
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t now_ns = std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
  std::int64_t before_ns = 0;
  if (first_ns.compare_exchange_strong(before_ns, now_ns)) {
    request_stop();
  } else if (now_ns - before_ns > kSameRequest_ns) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
}

std::string clock_text(double seconds) {
  const auto s = std::lround(seconds);
  return s < 3600 ? fmt::format("{}:{:02}", s / 60, s % 60)
                  : fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
}

/// The terminal line, drawn twice a second whether work reports or is long in one step; erased when the last copy of
/// the callback goes.
class Line {
 public:
  Line(std::string label, std::string unit) : label_(std::move(label)), unit_(std::move(unit)) {}
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  ~Line() {
    drawing_.request_stop();
    drawing_.join();
    if (shown_) std::fputs("\r\033[K", stderr);
  }

  void show(double done, double total) { done_ = done, total_ = total; }

 private:
  void draw() {
    constexpr double kBar_characters = 20.0, kEnoughSteps = 10.0;  // few are of unequal length
    const double done = done_, total = total_;
    const double elapsed_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const double rate = done / elapsed_s;
    std::string text = "\r\033[K" + label_ + ": ";
    if (total > 0)
      text += fmt::format("[{:.<20}] {:.0f} of {:.0f}",
                          std::string(static_cast<std::size_t>(kBar_characters * std::min(1.0, done / total)), '#'),
                          done, total);
    else
      text += fmt::format("{:.0f}", done);
    text += " " + unit_ + ", " + (rate < 1.0 ? clock_text(elapsed_s) + " so far" : fmt::format("{:.3g}/s", rate));
    if (total >= kEnoughSteps && rate > 0) text += fmt::format(", {} left", clock_text((total - done) / rate));
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
    shown_ = true;
  }

  std::string label_, unit_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::atomic<double> done_ = 0.0, total_ = 0.0;
  bool shown_ = false;
  std::jthread drawing_{[this](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any stopped;
    std::unique_lock lock(mutex);
    while (!stopped.wait_for(lock, stop, std::chrono::milliseconds(500), [] { return false; }) &&
           !stop.stop_requested())
      draw();
  }};
};

}  // namespace

void notice_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction action {};
    // what is ignored stays so: by nohup, and in the background of a script
    if (::sigaction(signal, nullptr, &action) != 0 || action.sa_handler == SIG_IGN) continue;
    action = {};
    action.sa_handler = on_stop_signal;
    ::sigaction(signal, &action, nullptr);  // without SA_RESTART: a call that waits returns
  }
  // both are errors of the write then, with the name of what was written
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

ProgressCallback progress_line(const Run& run, const std::string& label, const std::string& unit) {
  if (run.on_progress)
    return [on_progress = run.on_progress, label, unit](double done, double total) {
      throw_if_stop_requested();
      on_progress(label, done, total, unit);
    };
  const bool visible = !run.common.quiet && ::isatty(STDERR_FILENO) == 1;
  const auto line = visible ? std::make_shared<Line>(label, unit) : nullptr;
  return [line](double done, double total) {
    throw_if_stop_requested();
    if (line) line->show(done, total);
  };
}

StageProgress stage_progress(const Run& run) {
  return [&run](const std::string& label, const std::string& unit) { return progress_line(run, label, unit); };
}

}  // namespace bouncelab::stages
