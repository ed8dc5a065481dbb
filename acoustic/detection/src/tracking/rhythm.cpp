// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/rhythm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"

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

/// Density of an interval [1/s].
double density_of(double core, double n_beats, double interval_s, const TrackingModel& model) {
  return probability_of(n_beats, model) / interval_s * ((1.0 - model.outliers) * core + model.outliers * kAnyInterval);
}

}  // namespace

Rhythm::Rhythm(double log_interval, double log_amplitude) : level_(log_interval), loudness_(log_amplitude) {}

double Rhythm::follow(double interval_s, double log_amplitude, double sigma_s, const TrackingModel& model) {
  const double of_amplitude = loudness_.density(log_amplitude, 0.0, model);
  loudness_.learn(log_amplitude, 0.0, model);
  const double expected = level_ + trend_;
  const double n_beats = beats_of(interval_s * exp(-expected));
  const double deviation = log(interval_s / n_beats) - expected;
  const double n_known = std::min(n_sounds_ - 2, model.memory);
  const double learned =
      (model.beat_weight * square(model.beat_scatter) + sum_squares_) / (model.beat_weight + n_known);
  const double width = std::sqrt(learned + square(sigma_s / interval_s));
  const double step = std::clamp(deviation, -kMostOfOne * width, kMostOfOne * width);
  sum_squares_ += square(step) - (n_sounds_ - 2 >= model.memory ? sum_squares_ / model.memory : 0.0);
  level_ = n_beats < 1.0 ? log(interval_s) : expected + model.tempo_gain * step;
  trend_ += model.trend_gain * step;
  n_sounds_ += 1;
  return of_amplitude * density_of(student3(deviation, width), n_beats, interval_s, model);
}

}  // namespace bouncelab::detection
