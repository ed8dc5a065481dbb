// SPDX-License-Identifier: GPL-3.0-or-later
#include "stages/run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <memory>

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

/// The terminal line; erased when the last copy of the callback goes.
class Line {
 public:
  Line(std::string label, std::string unit) : label_(std::move(label)), unit_(std::move(unit)) {}
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  ~Line() {
    if (shown_) std::fputs("\r\033[K", stderr);
  }

  void show(double done, double total) {
    const auto now = Clock::now();
    if (now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    const double elapsed_s = std::chrono::duration<double>(now - start_).count();
    const double rate = done / elapsed_s;
    std::string text = fmt::format("\r\033[K{}: {:.0f}", label_, done);
    if (total > 0) text += fmt::format(" of {:.0f}", total);
    text += fmt::format(" {}, {:.3g}/s", unit_, rate);
    if (total > 0 && rate > 0) text += fmt::format(", {} left", clock_text((total - done) / rate));
    std::fputs(text.c_str(), stderr);
    std::fflush(stderr);
    shown_ = true;
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::string label_, unit_;
  Clock::time_point start_ = Clock::now(), last_ = start_;
  bool shown_ = false;
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
