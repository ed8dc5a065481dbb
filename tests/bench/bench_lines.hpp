// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

/// What every benchmark here prints: one number a line, as JSON, which tools/bench collects.
namespace bouncelab::bench {

/// {"part": ..., "case": ..., "what": ..., "value": ..., "unit": ...}; texts without quotes and backslashes.
inline void print_line(const char* part, const std::string& of, const std::string& what, double value,
                       const char* unit) {
  if (!std::isfinite(value)) return;
  std::printf(R"({"part": "%s", "case": "%s", "what": "%s", "value": %.9g, "unit": "%s"})"
              "\n",
              part, of.c_str(), what.c_str(), value, unit);
  std::fflush(stdout);
}

/// Processor time of this thread, so that other programs disturb less than on the clock [s].
inline double thread_s() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Seconds of one call.
template <class Call>
double seconds_of(Call&& call) {
  const double begin_s = thread_s();
  call();
  return thread_s() - begin_s;
}

/// Seconds of a call and of its baseline.
struct Pair {
  double ours_s = 1e300, baseline_s = 1e300;
};

/// The least of so many rounds, in each of which both take turns for about round_s, so that both meet the same machine.
template <class Ours, class Baseline>
Pair alternating(Ours&& ours, Baseline&& baseline, int n_rounds = 30, double round_s = 1e-3) {
  const auto n_calls = [&](double once_s) {
    return std::clamp(static_cast<int>(round_s / (once_s + 1e-9)), 1, 100000);
  };
  const int n_ours = n_calls(seconds_of(ours)), n_baseline = n_calls(seconds_of(baseline));
  const auto repeated = [](auto& call, int n) {
    return seconds_of([&] {
             for (int k = 0; k < n; ++k) call();
           }) /
           n;
  };
  Pair least;
  for (int round = 0; round < n_rounds; ++round) {
    least.ours_s = std::min(least.ours_s, repeated(ours, n_ours));
    least.baseline_s = std::min(least.baseline_s, repeated(baseline, n_baseline));
  }
  return least;
}

/// Seconds of one call, the least of so many rounds of about round_s.
template <class Call>
double least_s(Call&& call, int n_rounds = 30, double round_s = 1e-3) {
  const int n = std::clamp(static_cast<int>(round_s / (seconds_of(call) + 1e-9)), 1, 100000);
  double least = 1e300;
  for (int round = 0; round < n_rounds; ++round)
    least = std::min(least, seconds_of([&] {
                              for (int k = 0; k < n; ++k) call();
                            }) / n);
  return least;
}

}  // namespace bouncelab::bench
