// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// Density of Student's t with three degrees of freedom, scaled: a normal core, tails that forgive. Integrates to one.
/// @param width  > 0, in units of x
inline double student3(double x, double width) {
  const double width2 = width * width;
  const double core = width2 + x * x * (1.0 / 3.0);  // (1 + z^2 / 3) width^2
  return 2.0 / (kPi * std::numbers::sqrt3) * width2 * width / (core * core);
}

/// log(exp(a) + exp(b)), for any log odds: their exponentials may be beyond a double's range.
inline double log_of_sum(double a, double b) { return std::max(a, b) + log1p(exp(-std::abs(a - b))); }

/// No less than log(x), without taking it; of what is not a number no more than of 0.
inline double largest_log(double x) {
  return x > 0.0 ? std::numbers::ln2 * (std::ilogb(x) + 1) : -std::numeric_limits<double>::infinity();
}

/// What is known of the loudness of one source: a running mean of its logarithm, which gain control may carry along,
/// and its scatter with a conjugate prior. The same for balls and rhythms, so that neither is preferred for being even
/// or uneven; a ball's goes with a power of its speed, of which the exponent is not known well: hard balls have 1, soft
/// ones, whose slow impacts are long and dull, up to 4.
class Loudness {
 public:
  /// @param mean        log loudness of the first two sounds
  /// @param log_flight  of a ball, before them [ln s]; 0 of a rhythm
  explicit Loudness(double mean, double log_flight = 0.0) : mean_(mean), mean_log_flight_(log_flight) {}

  /// Density of the next log loudness.
  double density(double log_loudness, double log_flight) const {
    return student3(deviation(log_loudness, log_flight), width(log_flight));
  }

  /// At the mean.
  double largest_density() const { return student3(0.0, std::sqrt(variance())); }

  void learn(double log_loudness, double log_flight) {
    const double most = kTracking.most_of_one * width(log_flight);
    const double step = std::clamp(deviation(log_loudness, log_flight), -most, most);
    const double own = std::min(1.0, std::sqrt(variance()) / width(log_flight)) * step;
    n_sounds_ = std::min(n_sounds_ + 1, kTracking.memory);
    sum_squares_ = (sum_squares_ + square(own)) * (n_sounds_ < kTracking.memory ? 1.0 : 1.0 - 1.0 / kTracking.memory);
    const double change = log_flight - mean_log_flight_;
    mean_ += (kTracking.loudness_exponent * change + step) / n_sounds_;
    mean_log_flight_ += change / n_sounds_;
  }

 private:
  double deviation(double log_loudness, double log_flight) const {
    return log_loudness - mean_ - kTracking.loudness_exponent * (log_flight - mean_log_flight_);
  }
  double width(double log_flight) const {
    return std::sqrt(variance() + square(kTracking.exponent_scatter * (log_flight - mean_log_flight_)));
  }
  double variance() const {
    return (kTracking.loudness_weight * square(kTracking.loudness_scatter) + sum_squares_) /
           (kTracking.loudness_weight + n_sounds_ - 2);
  }

  double mean_;
  double mean_log_flight_;
  double sum_squares_ = 0.0;
  int n_sounds_ = 2;
};

}  // namespace bouncelab::detection
