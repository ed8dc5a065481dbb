// SPDX-License-Identifier: GPL-3.0-or-later
#include "progress_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <memory>

#include "bouncelab/core/error.hpp"

namespace bouncelab::cli {
namespace {

volatile std::sig_atomic_t interrupted = 0;

/// The first asks to stop, which leaves nothing half-written; one that comes seconds later ends the program at once.
/// Until then others are the same request: `timeout` and some terminals send it to the program and to its group.
extern "C" void on_interrupt(int signal) {
  constexpr std::time_t kPatience_s = 2;
  static volatile std::time_t first_s = 0;
  if (interrupted == 0) {
    interrupted = 1;
    first_s = std::time(nullptr);
  } else if (std::time(nullptr) - first_s > kPatience_s) {
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

void notice_interrupts() {
  std::signal(SIGINT, on_interrupt);
  std::signal(SIGTERM, on_interrupt);
}

ProgressCallback progress_line(const Run& run, const std::string& label, const std::string& unit) {
  const bool visible = !run.common.quiet && ::isatty(STDERR_FILENO) == 1;
  const auto line = visible ? std::make_shared<Line>(label, unit) : nullptr;
  return [line](double done, double total) {
    if (interrupted) throw Interrupted();
    if (line) line->show(done, total);
  };
}

loop::StageProgress stage_progress(const Run& run) {
  return [&run](const std::string& label, const std::string& unit) { return progress_line(run, label, unit); };
}

ProgressCallback interrupts_only(const std::string&, const std::string&) {
  return [](double, double) {
    if (interrupted) throw Interrupted();
  };
}

}  // namespace bouncelab::cli
