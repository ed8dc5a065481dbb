// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "tracking/densities.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {

/// The flight that an interval is, if it is that of a ball after a flight of which the length is known.
struct Flight {
  double eps = 0.0;       ///< the same at each impact of the interval
  double flight_s = 0.0;  ///< the last flight in the interval
  double slope_s = 0.0;   ///< d interval / d eps [s]
};

/// @param interval_s  > 0
/// @param flight_s    of the flight before
/// @param n_missing   impacts within the interval that were not detected, 0 ... kMostMissing
/// @return absent where eps is outside kLeastEps ... kLargestEps, or the flight shorter than kShortestFlight_s
std::optional<Flight> flight_of(double interval_s, double flight_s, int n_missing);

/// What is known of a ball's log eps and loudness up to an impact: running means, and the scatter of log eps with a
/// conjugate prior, so that a few impacts already tell a smooth ball from a rough one. A single loss or gain leaves the
/// mean; if the next coefficient is like it, the mean begins anew.
class Bounces {
 public:
  /// @param log_flight     of the first flight [ln s]
  /// @param log_amplitude  of the first two impacts, their mean
  /// @param eps_of_fall    of the first impact, after a fall from a known height
  Bounces(double log_flight, double log_amplitude, std::optional<double> eps_of_fall = {});

  /// Density of the next impact [1/s, per unit of log amplitude].
  /// @param jitter2  variance that errors of the times add to log eps
  double density(const Flight& flight, double log_eps, double log_flight, double log_amplitude, int n_missing,
                 double jitter2) const;
  /// No less than that, whatever the loudness; without a logarithm.
  double largest_density(const Flight& flight, int n_missing, double jitter2) const;
  void learn(double log_eps, double log_flight, double log_amplitude, int n_missing, double jitter2);

  /// log of the probability that it loses energy, as no rhythm does: on the whole, since eps changed, and over each
  /// kTracking.memory impacts.
  /// @param log_flight  of the last flight [ln s]
  double log_probability_of_loss(double log_flight) const;

 private:
  /// By how many standard errors of its mean a loss is above the least.
  double widths_above_least(double loss, int n_eps) const;
  double learned_variance() const;
  double variance(double most_of_loss) const;  ///< what of it a ball can have
  /// Of the next log eps about the mean, itself known from a few, but for errors of the times.
  double variance_of_next(int n_missing) const;
  bool expects_eps() const { return n_eps_ > 0 || has_fall_; }

  int n_eps_ = 0;  ///< ratios of intervals
  int n_of_mean_ = 0;
  double mean_log_eps_ = 0.0;
  bool has_fall_ = false;                   ///< the mean is that of the fall until a ratio of intervals is known
  double sum_squares_ = 0.0;                ///< of the deviations of log eps from its running mean, large ones cut
  std::optional<double> changed_log_eps_;   ///< the last one, where it was far from the mean: it may stay
  double loss_ = 0.0;                       ///< -sum of log eps, large deviations cut
  double log_probability_of_losses_ = 0.0;  ///< over each kTracking.memory impacts of constant eps
  double first_log_flight_;
  Loudness loudness_;  ///< amplitude over the flight before
};

/// Density of eps where nothing is known of the ball.
double prior_of_eps(double eps);

/// Probability that n_missing impacts are not detected, and the next one is.
double probability_of_missing(int n_missing);

}  // namespace bouncelab::detection
