// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rhythm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/student.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kAnyInterval = 1.0 / 3.0;  // density of an irregular log interval, within a factor of 4.5 either way

/// An interval in beats.
double beats_of(double ratio) {
  if (ratio < 0.5 * std::numbers::sqrt2) return 0.5;
  return std::clamp(std::round(ratio), 1.0, kMostMissing + 1.0);
}

/// Probability of so many beats: those left out, or divided.
double probability_of(double n_beats, const TrackingModel& model) {
  const int n_unusual = n_beats < 1.0 ? 1 : static_cast<int>(n_beats) - 1;
  return model.detection_probability * power(1.0 - model.detection_probability, n_unusual);
}

}  // namespace

Rhythm::Rhythm(double log_interval, double log_amplitude)
    : level_(log_interval), last_(log_interval), mean_log_amplitude_(log_amplitude) {}

std::array<double, kRhythmKinds> Rhythm::follow(double interval_s, double log_amplitude, double sigma_s,
                                                const TrackingModel& model) {
  const double expected = level_ + trend_;
  const double n_beats = beats_of(interval_s * exp(-expected));
  const double log_interval = log(interval_s / n_beats);
  const double jitter2 = square(sigma_s / interval_s);
  const double n_known = std::min(n_sounds_ - 2, model.memory);
  const double learned =
      (model.beat_weight * square(model.beat_scatter) + sum_squares_) / (model.beat_weight + n_known);
  const double width = std::sqrt(learned + jitter2);
  const double deviation = log_interval - expected;
  const double of_beats =
      probability_of(n_beats, model) / interval_s * student3(log_amplitude - mean_log_amplitude_, model.accent_scatter);
  const auto density = [&](double core) {
    return of_beats * ((1.0 - model.outliers) * core + model.outliers * kAnyInterval);
  };
  const std::array<double, kRhythmKinds> densities{
      density(student3(deviation, width)),
      density(student3(log_interval - last_, std::sqrt(square(model.machine_scatter) + jitter2)))};

  const double step = std::clamp(deviation, -3.0 * width, 3.0 * width);
  sum_squares_ += square(step) - (n_sounds_ - 2 >= model.memory ? sum_squares_ / model.memory : 0.0);
  const bool is_divided = n_beats < 1.0;
  level_ = is_divided ? log(interval_s) : expected + model.tempo_gain * step;
  last_ = is_divided ? level_ : log_interval;
  trend_ += model.trend_gain * step;
  n_sounds_ += 1;
  mean_log_amplitude_ += (log_amplitude - mean_log_amplitude_) / std::min(n_sounds_, model.memory);
  return densities;
}

}  // namespace bouncelab::detection
