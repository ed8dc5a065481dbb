// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/time_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {
namespace {

constexpr double kTolerance_steps = 0.25;  // half a step would be another sample
constexpr std::int64_t kEvery = 1024;      // of the times are kept, to see a drift

}  // namespace

void TimeGrid::refuse(std::size_t line, double t_s, double expected_s, double step_s) const {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), "time %.9g s, where steps of %.6g s lead to %.9g s", t_s, step_s, expected_s);
  throw FileError(name_,
                  "line " + std::to_string(line) + ": " + text.data() +
                      "; samples must follow at one rate: record again, or leave the column out and give --rate");
}

void TimeGrid::add(double t_s, double rounding_s, std::size_t line) {
  rounding_s_ = std::max(rounding_s_, rounding_s);
  if (n_ == 0) first_s_ = t_s;
  if (n_ > 0 && !(t_s > first_s_)) refuse(line, t_s, last_s_, 0.0);
  if (n_ > 1) {
    // the line through the first time and the one before: their roundings and its own
    const double k = static_cast<double>(n_ - 1);
    const double step_s = (last_s_ - first_s_) / k;
    const double expected_s = last_s_ + step_s;
    if (std::abs(t_s - expected_s) > kTolerance_steps * step_s + 2.0 * rounding_s_ * (1.0 + 1.0 / k))
      refuse(line, t_s, expected_s, step_s);
  }
  if (n_ % kEvery == 0) some_.push_back({n_, t_s, line});
  last_s_ = t_s;
  ++n_;
}

double TimeGrid::rate_hz() const {
  if (n_ < 2) throw FileError(name_, "holds " + std::to_string(n_) + " samples; record again");
  const double step_s = (last_s_ - first_s_) / static_cast<double>(n_ - 1);
  for (const Entry& entry : some_) {
    const double expected_s = first_s_ + static_cast<double>(entry.k) * step_s;
    if (std::abs(entry.t_s - expected_s) > 2.0 * kTolerance_steps * step_s + 2.0 * rounding_s_)
      refuse(entry.line, entry.t_s, expected_s, step_s);
  }
  const double rate_hz = 1.0 / step_s;
  const double error_hz = 2.0 * rounding_s_ / (last_s_ - first_s_) * rate_hz;
  return std::abs(rate_hz - std::round(rate_hz)) <= std::max(error_hz, 1e-9 * rate_hz) ? std::round(rate_hz) : rate_hz;
}

}  // namespace bouncelab::audio
