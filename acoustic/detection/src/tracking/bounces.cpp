// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/bounces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

/// Time that n_missing + 1 flights take, over the flight before them: eps + eps^2 + ...
double gap_of_eps(double eps, int n_missing) {
  double gap = eps;
  for (int k = 0; k < n_missing; ++k) gap = eps * (1.0 + gap);
  return gap;
}

/// The eps of gap_of_eps().
double eps_of_gap(double gap, int n_missing) {
  if (n_missing == 0) return gap;
  if (n_missing == 1) return std::sqrt(0.25 + gap) - 0.5;
  static_assert(kMostMissing == 2);
  double eps = gap / 3.0;
  for (int iteration = 0; iteration < 4; ++iteration)  // Newton's, from within 0.3: to 1e-13
    eps -= (eps * (1.0 + eps * (1.0 + eps)) - gap) / (1.0 + eps * (2.0 + 3.0 * eps));
  return eps;
}

/// log of the probability that a normal value is below z.
double log_normal_probability(double z) {
  if (z > 8.5) return 0.0;  // 1 to rounding
  // beyond 5 standard deviations by the first term of the asymptotic series
  if (z < -5.0) return -0.5 * square(z) - log(-z * std::sqrt(2.0 * kPi));
  return log(0.5 * erfc(-z / std::numbers::sqrt2));
}

}  // namespace

std::optional<Flight> flight_of(double interval_s, double flight_s, int n_missing) {
  const double gap = interval_s / flight_s;
  if (gap < gap_of_eps(kLeastEps, n_missing) || gap > gap_of_eps(kLargestEps, n_missing)) return {};
  Flight flight{eps_of_gap(gap, n_missing), flight_s, 0.0};
  for (int m = 0; m <= n_missing; ++m) {
    flight.slope_s += (m + 1) * flight.flight_s;
    flight.flight_s *= flight.eps;
  }
  if (flight.flight_s < kShortestFlight_s) return {};
  return flight;
}

double prior_of_eps(double eps) {
  if (eps < kLeastEps || eps > kLargestEps) return 0.0;
  const double losses = eps <= 1.0 ? 1.0 / (1.0 - kLeastEps) : 0.0;
  return (1.0 - kTracking.gains) * losses + kTracking.gains / (kLargestEps - kLeastEps);
}

double probability_of_missing(int n_missing) {
  return kTracking.detection_probability * power(1.0 - kTracking.detection_probability, n_missing);
}

Bounces::Bounces(double log_flight, double log_amplitude, std::optional<double> eps_of_fall)
    : first_log_flight_(log_flight),
      // the flight before the first impact is not known; it is taken for as long as that after it
      loudness_(log_amplitude, log_flight) {
  has_fall_ = eps_of_fall && prior_of_eps(*eps_of_fall) > 0.0;
  if (has_fall_) mean_log_eps_ = log(*eps_of_fall);
}

double Bounces::learned_variance() const {
  return (kTracking.scatter_weight * square(kTracking.scatter) + sum_squares_) /
         (kTracking.scatter_weight + n_of_mean_);
}

double Bounces::variance(double most_of_loss) const {
  const double most = most_of_loss * std::max(kTracking.least_loss, -mean_log_eps_);
  return std::min(learned_variance(), square(most));
}

double Bounces::variance_of_next(int n_missing) const {
  if (n_eps_ == 0) return square(kTracking.first_scatter) * (1.0 + n_missing);
  const double of_mean = (1.0 + 1.0 / std::min(n_of_mean_, kTracking.memory)) * (1.0 + n_missing);
  return variance(kTracking.most_scatter) * of_mean;
}

double Bounces::density(const Flight& flight, double log_eps, double log_flight, double log_amplitude, int n_missing,
                        double jitter2) const {
  const double prior = prior_of_eps(flight.eps);
  double of_eps = prior;
  if (expects_eps()) {
    const double width = std::sqrt(variance_of_next(n_missing) + jitter2);
    double of_outlier = prior;
    if (changed_log_eps_) {
      const double of_change = std::sqrt(2.0 * square(kTracking.scatter) * (1.0 + n_missing) + jitter2);
      of_outlier = 0.5 * (prior + student3(log_eps - *changed_log_eps_, of_change) / flight.eps);
    }
    of_eps = (1.0 - kTracking.outliers) * student3(log_eps - mean_log_eps_, width) / flight.eps +
             kTracking.outliers * of_outlier;
  }
  return probability_of_missing(n_missing) * of_eps / flight.slope_s * loudness_.density(log_amplitude, log_flight);
}

double Bounces::largest_density(const Flight& flight, int n_missing, double jitter2) const {
  double of_eps = prior_of_eps(flight.eps);
  if (expects_eps()) {
    const double width = std::sqrt(variance_of_next(n_missing) + jitter2);
    // 1 - 1/x <= log x <= x - 1
    const double mean_eps = exp(mean_log_eps_);
    const double least_deviation = std::abs(flight.eps - mean_eps) / std::max(flight.eps, mean_eps);
    double of_outlier = of_eps;
    if (changed_log_eps_) of_outlier += student3(0.0, kTracking.scatter) / flight.eps;
    of_eps = student3(least_deviation, width) / flight.eps + kTracking.outliers * of_outlier;
  }
  return probability_of_missing(n_missing) * of_eps / flight.slope_s * loudness_.largest_density();
}

void Bounces::learn(double log_eps, double log_flight, double log_amplitude, int n_missing, double jitter2) {
  loudness_.learn(log_amplitude, log_flight);
  n_eps_ += 1;
  const double deviation = log_eps - mean_log_eps_;
  const bool has_changed = changed_log_eps_ && std::abs(log_eps - *changed_log_eps_) < std::abs(deviation);
  if (n_of_mean_ == 0 || has_changed) {
    const double other = has_changed ? *changed_log_eps_ : log_eps;
    mean_log_eps_ = 0.5 * (other + log_eps);
    sum_squares_ = 0.5 * square(log_eps - other);
    n_of_mean_ = has_changed ? 2 : 1;
    loss_ -= log_eps;
    changed_log_eps_.reset();
    return;
  }
  const double n_before = std::min(n_of_mean_, kTracking.memory);
  const double width = std::sqrt(learned_variance() * (1.0 + 1.0 / n_before) * (1.0 + n_missing) + jitter2);
  // one loss or gain must not carry the mean away
  const double step = std::clamp(deviation, -kTracking.most_of_one * width, kTracking.most_of_one * width);
  changed_log_eps_.reset();
  if (step != deviation) changed_log_eps_ = log_eps;
  n_of_mean_ += 1;
  sum_squares_ += square(step) * (n_of_mean_ - 1) / n_of_mean_;
  // single losses must not make a ball of a rhythm, nor single gains hide that it is one
  loss_ -= mean_log_eps_ + step;
  mean_log_eps_ += step / std::min(n_of_mean_, kTracking.memory);
  if (n_of_mean_ % kTracking.memory == 0)
    log_probability_of_losses_ += log_normal_probability(widths_above_least(-mean_log_eps_, kTracking.memory));
}

double Bounces::log_probability_of_loss(double log_flight) const {
  if (n_eps_ == 0) return 0.0;
  const double of_all = std::min(loss_, first_log_flight_ - log_flight) / n_eps_;
  const double of_last = -mean_log_eps_;  // since eps changed
  const double z = std::min(widths_above_least(of_all, n_eps_), widths_above_least(of_last, n_of_mean_));
  return std::min(log_probability_of_losses_, log_normal_probability(z));
}

double Bounces::widths_above_least(double loss, int n_eps) const {
  // what scatters by more than it loses may be anything: it is asked for the more
  return (loss - kTracking.least_loss) / std::sqrt(variance(1.0) / n_eps);
}

}  // namespace bouncelab::detection
