// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/ball_hypothesis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/densities.hpp"

namespace bouncelab::detection {
namespace {

/// What the track's impacts to come contribute to the density of log amplitudes, as if they were clutter.
/// @param flight   the last one; the next takes eps times as long
/// @param log_eps  of its eps
double density_to_come(const Flight& flight, double log_eps) {
  const double window_s = clutter_window_s(flight.flight_s);
  double density = 0.0;
  double flight_s = flight.eps * flight.flight_s;
  double log_ratio = log_eps;
  for (double t_s = flight_s; t_s <= window_s && flight_s > kShortestFlight_s; t_s += flight_s) {
    density += kTracking.detection_probability * amplitude_kernel(log_ratio);
    flight_s *= flight.eps;
    log_ratio += log_eps;
  }
  return density;
}

}  // namespace

double log_odds_of_first(const Observation& first) {
  return kTracking.start_log_odds + first.log_rise_odds - log_odds_against_first(first.neighbours);
}

std::optional<BallHypothesis::Step> BallHypothesis::first_step(double least_log_odds, const Birth& birth,
                                                               const Observation& first, const Observation& second,
                                                               double same_source, bool is_counted) {
  const double flight_s = second.t_s - first.t_s;
  const double change = second.log_amplitude - first.log_amplitude;
  const Flight flight{kTracking.usual_eps, flight_s, 0.0};
  const double own =
      is_counted ? (amplitude_kernel(change) + density_to_come(flight, birth.log_usual_eps)) * same_source : 0.0;
  const double of_clutter =
      is_counted ? clutter_intensity(second.neighbours, flight_s, own) : clutter_intensity(second.neighbours, flight_s);
  const double of_amplitude = student3(change - kTracking.usual_first_change, kTracking.first_change_scatter);
  const double before = birth.log_odds_of_first + second.log_rise_odds;
  const double most =
      student3(0.0, kTracking.first_flight_scatter) / flight_s * of_amplitude * same_source / of_clutter;
  if (before + largest_log(most) < least_log_odds) return {};  // most are far from it
  const double log_flight = log(flight_s);
  const double per_second =
      student3(log_flight - log(kTracking.usual_first_flight_s), kTracking.first_flight_scatter) / flight_s;
  Step step;
  step.log_odds = before + log(per_second * of_amplitude * same_source / of_clutter);
  if (step.log_odds < least_log_odds) return {};
  step.flight_s = flight_s;
  step.log_flight = log_flight;
  return step;
}

BallHypothesis::BallHypothesis(const Observation& first, const Observation& second, const Step& step)
    : log_odds(step.log_odds),
      flight_s(step.flight_s),
      last_{Impact{second.t_s, second.log_amplitude, second.sigma_s}, {first.t_s, first.log_amplitude, first.sigma_s}},
      log_flight_(step.log_flight),
      bounces_(step.log_flight, 0.5 * (first.log_amplitude + second.log_amplitude)) {}

double BallHypothesis::own_density(const Observation& next, const Flight& flight, double log_eps,
                                   double same_source) const {
  const double window_s = clutter_window_s(flight.flight_s);
  double sum = density_to_come(flight, log_eps);
  for (const Impact& other : last_)
    if (next.t_s - other.t_s <= window_s) sum += amplitude_kernel(other.log_amplitude - next.log_amplitude);
  return sum * same_source;
}

double BallHypothesis::jitter2(const Observation& next) const {
  return (square(next.sigma_s) + square(2.0 * last_[0].sigma_s) + square(last_[1].sigma_s)) / square(flight_s);
}

std::optional<BallHypothesis::Step> BallHypothesis::step_to(const Observation& next, int n_missing, double same_source,
                                                            bool is_counted, double least_log_odds) const {
  const std::optional<Flight> flight = flight_of(next.t_s - last_[0].t_s, flight_s, n_missing);
  if (!flight) return {};
  const double before = log_odds + next.log_rise_odds;
  Step step;
  step.jitter2 = jitter2(next);
  if (least_log_odds > -INFINITY) {
    const double largest = bounces_.largest_density(*flight, n_missing, step.jitter2) * same_source /
                           least_clutter_intensity(flight->flight_s);
    if (before + largest_log(largest) < least_log_odds) return {};  // most are far from it
  }
  step.log_eps = log(flight->eps);
  step.log_flight = log_flight_ + (n_missing + 1) * step.log_eps;
  const double density =
      bounces_.density(*flight, step.log_eps, step.log_flight, next.log_amplitude, n_missing, step.jitter2);
  step.of_clutter = is_counted ? clutter_intensity(next.neighbours, flight->flight_s,
                                                   own_density(next, *flight, step.log_eps, same_source))
                               : clutter_intensity(next.neighbours, flight->flight_s);
  step.of_clutter /= same_source;
  if (before + largest_log(density / step.of_clutter) < least_log_odds) return {};
  step.log_odds = before + log(density / step.of_clutter);
  if (step.log_odds < least_log_odds) return {};
  step.flight_s = flight->flight_s;
  step.n_missing = n_missing;
  return step;
}

void BallHypothesis::take(const Step& step, const Observation& next) {
  log_odds = step.log_odds;
  flight_s = step.flight_s;
  log_flight_ = step.log_flight;
  bounces_.learn(step.log_eps, step.log_flight, next.log_amplitude, step.n_missing, step.jitter2);
  impact += step.n_missing + 1;
  n_impacts += 1;
  last_ = {Impact{next.t_s, next.log_amplitude, next.sigma_s}, last_[0], last_[1]};
}

double BallHypothesis::largest_gain() const {
  return log(bounces_.largest_share_of_flight() * 4.0 * std::numbers::sqrt2 /
             (kTracking.unseen * amplitude_kernel(0.0)));
}

double BallHypothesis::log_factor_of_missing(int n_missing) { return log(largest_factor_of_missing(n_missing)); }

double log_odds_before(const Observation& before, const Observation& first, double same_source, double flight_s,
                       double mean_log_eps, double scatter) {
  const double interval_s = first.t_s - before.t_s;
  const double eps = flight_s / interval_s;
  const double log_eps = log(eps);
  const double deviation = log_eps - mean_log_eps;
  const double jitter = hypot(before.sigma_s, 2.0 * first.sigma_s) / interval_s;
  // at its first impacts a ball may lose more than later
  const double core = 0.5 * (student3(deviation, hypot(std::max(scatter, kTracking.scatter), jitter)) +
                             student3(deviation, hypot(scatter, kTracking.first_scatter, jitter)));
  const double of_eps = (1.0 - kTracking.outliers) * core + kTracking.outliers * eps * prior_of_eps(eps);
  const double density = kTracking.detection_probability * of_eps / interval_s *
                         student3(first.log_amplitude - before.log_amplitude - log_eps, kTracking.first_change_scatter);
  return before.log_rise_odds + log(density * same_source / clutter_intensity(before.neighbours, interval_s, 0.0));
}

}  // namespace bouncelab::detection
