// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>

#include "bouncelab/core/elementary.hpp"
#include "tracking/student.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// What is known of the loudness of one source: a running mean of its logarithm, which gain control may carry along,
/// and its scatter with a conjugate prior. The same for balls and rhythms, so that neither is preferred for being even
/// or uneven; they differ in what loudness is counted against, the speed of impact or nothing.
class Loudness {
 public:
  /// @param mean  log loudness of the first two sounds
  explicit Loudness(double mean) : mean_(mean) {}
  Loudness() = default;

  /// Density of the next log loudness.
  double density(double log_loudness, const TrackingModel& model) const {
    return student3(log_loudness - mean_, std::sqrt(variance(model)));
  }

  /// At the mean.
  double largest_density(const TrackingModel& model) const { return student3(0.0, std::sqrt(variance(model))); }

  void learn(double log_loudness, const TrackingModel& model) {
    const double width = std::sqrt(variance(model));
    const double step = std::clamp(log_loudness - mean_, -kMostOfOne * width, kMostOfOne * width);
    n_sounds_ = std::min(n_sounds_ + 1, model.memory);
    sum_squares_ = (sum_squares_ + square(step)) * (n_sounds_ < model.memory ? 1.0 : 1.0 - 1.0 / model.memory);
    mean_ += step / n_sounds_;
  }

 private:
  double variance(const TrackingModel& model) const {
    return (model.loudness_weight * square(model.loudness_scatter) + sum_squares_) /
           (model.loudness_weight + n_sounds_ - 2);
  }

  double mean_ = 0.0;
  double sum_squares_ = 0.0;
  int n_sounds_ = 2;
};

}  // namespace bouncelab::detection
