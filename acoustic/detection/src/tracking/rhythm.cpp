// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rhythm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

/// An interval in beats.
double beats_of(double ratio) {
  if (ratio < 0.5 * std::numbers::sqrt2) return 0.5;
  return std::clamp(std::round(ratio), 1.0, kMostMissing + 1.0);
}

/// Probability of so many beats: those left out, or divided.
double probability_of(double n_beats) {
  const int n_unusual = n_beats < 1.0 ? 1 : static_cast<int>(n_beats) - 1;
  return kTracking.detection_probability * power(1.0 - kTracking.detection_probability, n_unusual);
}

/// Density of an interval [1/s].
double density_of(double core, double n_beats, double interval_s) {
  return probability_of(n_beats) / interval_s *
         ((1.0 - kTracking.outliers) * core + kTracking.outliers * kTracking.any_interval);
}

}  // namespace

Rhythm::Rhythm(double log_interval, double log_amplitude)
    : level_(log_interval), period_s_(exp(log_interval)), loudness_(log_amplitude) {}

std::array<double, kRhythmKinds> Rhythm::follow(double interval_s, double log_amplitude, double sigma_s) {
  const double of_amplitude = loudness_.density(log_amplitude, 0.0);
  loudness_.learn(log_amplitude, 0.0);
  const std::array<double, kRhythmKinds> densities{of_amplitude * follow_by_hand(interval_s, sigma_s),
                                                   of_amplitude * follow_by_machine(interval_s, sigma_s)};
  n_sounds_ += 1;
  return densities;
}

double Rhythm::follow_by_hand(double interval_s, double sigma_s) {
  const double expected = level_ + trend_;
  const double n_beats = beats_of(interval_s * exp(-expected));
  const double deviation = log(interval_s / n_beats) - expected;
  const double n_known = std::min(n_sounds_ - 2, kTracking.memory);
  const double learned =
      (kTracking.beat_weight * square(kTracking.beat_scatter) + sum_squares_) / (kTracking.beat_weight + n_known);
  const double width = std::sqrt(learned + square(sigma_s / interval_s));
  const double step = std::clamp(deviation, -kTracking.most_of_one * width, kTracking.most_of_one * width);
  sum_squares_ += square(step) - (n_sounds_ - 2 >= kTracking.memory ? sum_squares_ / kTracking.memory : 0.0);
  level_ = n_beats < 1.0 ? log(interval_s) : expected + kTracking.tempo_gain * step;
  trend_ += kTracking.trend_gain * step;
  return density_of(student3(deviation, width), n_beats, interval_s);
}

double Rhythm::follow_by_machine(double interval_s, double sigma_s) {
  const double n_beats = beats_of((interval_s + late_s_) / period_s_);
  const double deviation_s = interval_s + late_s_ - n_beats * period_s_;
  const double n = std::min(n_sounds_, kTracking.memory);  // sounds that beat and interval are known from
  const double position_gain = 2.0 * (2.0 * n + 1.0) / ((n + 1.0) * (n + 2.0));
  const double period_gain = 6.0 / ((n + 1.0) * (n + 2.0));
  const double learned = (kTracking.beat_weight * square(kTracking.machine_scatter) + sum_squares_of_lateness_) /
                         (kTracking.beat_weight + n - 2.0);
  // a line through n points predicts the next with the variance 1/(1 - gain) of that of one
  const double width_s =
      std::sqrt((learned * square(period_s_) + square(sigma_s)) / std::max(0.1, 1.0 - position_gain));
  const double step_s = std::clamp(deviation_s, -kTracking.most_of_one * width_s, kTracking.most_of_one * width_s);
  sum_squares_of_lateness_ += (1.0 - position_gain) * square(step_s / period_s_) -
                              (n_sounds_ >= kTracking.memory ? sum_squares_of_lateness_ / kTracking.memory : 0.0);
  late_s_ = deviation_s - position_gain * step_s;
  period_s_ = std::max(0.5 * period_s_, period_s_ + period_gain * step_s / n_beats);  // intervals are positive
  const double core = student3(deviation_s / interval_s, width_s / interval_s);
  return density_of(core, n_beats, interval_s);
}

}  // namespace bouncelab::detection
