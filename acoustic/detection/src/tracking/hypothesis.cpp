// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/hypothesis.hpp"

#include <algorithm>

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

/// Density of the flight after the first impact of a drop from a known height: that of its eps. The height may be
/// wrong, or the first impact not heard.
/// @param of_any  density where no height is known
double density_after_fall(double flight_s, double elastic_flight_s, double of_any) {
  return (1.0 - kTracking.outliers) * prior_of_eps(flight_s / elastic_flight_s) / elastic_flight_s +
         kTracking.outliers * of_any;
}

}  // namespace

std::optional<Hypothesis::Step> Hypothesis::first_step(const Observation& first, const Observation& second,
                                                       double same_source, bool is_counted, double least_log_odds) {
  Step step;
  step.flight_s = second.t_s - first.t_s;
  const double change = second.log_amplitude - first.log_amplitude;
  const Flight flight{kTracking.usual_eps, step.flight_s, 0.0};
  const double of_clutter =
      is_counted ? clutter_intensity(
                       second.neighbours, step.flight_s,
                       (amplitude_kernel(change) + density_to_come(flight, log(kTracking.usual_eps))) * same_source)
                 : clutter_intensity(second.neighbours, step.flight_s);
  const double of_amplitude = student3(change - kTracking.usual_first_change, kTracking.first_change_scatter);
  const double before = first.log_odds_of_first + second.log_rise_odds;
  const auto per_second = [&](double deviation) {
    const double of_any = student3(deviation, kTracking.first_flight_scatter) / step.flight_s;
    return first.elastic_flight_s ? density_after_fall(step.flight_s, *first.elastic_flight_s, of_any) : of_any;
  };
  const double largest = per_second(0.0) * of_amplitude * same_source / of_clutter;
  if (before + largest_log(largest) < least_log_odds) return {};  // most are far from it
  step.log_flight = log(step.flight_s);
  const double of_flight = per_second(step.log_flight - log(kTracking.usual_first_flight_s));
  step.log_odds = before + log(of_flight * of_amplitude * same_source / of_clutter);
  if (step.log_odds < least_log_odds) return {};
  return step;
}

Hypothesis::Hypothesis(const Observation& first, const Observation& second, const Step& step)
    : log_odds(step.log_odds),
      flight_s(step.flight_s),
      last_{Impact{second.t_s, second.log_amplitude, second.sigma_s}, {first.t_s, first.log_amplitude, first.sigma_s}},
      log_flight_(step.log_flight),
      bounces_(step.log_flight, 0.5 * (first.log_amplitude + second.log_amplitude),
               first.elastic_flight_s ? std::optional(step.flight_s / *first.elastic_flight_s) : std::nullopt),
      rhythm_(step.log_flight, 0.5 * (first.log_amplitude + second.log_amplitude)),
      log_odds_rhythm_{step.log_odds, step.log_odds} {}

Hypothesis Hypothesis::begin(const Observation& first, const Observation& second, double same_source, bool is_counted) {
  return {first, second, *first_step(first, second, same_source, is_counted)};
}

double Hypothesis::own_density(const Observation& next, const Flight& flight, double log_eps,
                               double same_source) const {
  const double window_s = clutter_window_s(flight.flight_s);
  double sum = density_to_come(flight, log_eps);
  for (const Impact& other : last_)
    if (next.t_s - other.t_s <= window_s) sum += amplitude_kernel(other.log_amplitude - next.log_amplitude);
  return sum * same_source;
}

double Hypothesis::jitter2(const Observation& next) const {
  return (square(next.sigma_s) + square(2.0 * last_[0].sigma_s) + square(last_[1].sigma_s)) / square(flight_s);
}

std::optional<Hypothesis::Step> Hypothesis::step_to(const Observation& next, int n_missing, double same_source,
                                                    bool is_counted, double least_log_odds) const {
  const std::optional<Flight> flight = flight_of(next.t_s - last_[0].t_s, flight_s, n_missing);
  if (!flight) return {};
  Step step;
  step.flight_s = flight->flight_s;
  step.n_missing = n_missing;
  step.jitter2 = jitter2(next);
  const double before = log_odds + next.log_rise_odds;
  const double largest = bounces_.largest_density(*flight, n_missing, step.jitter2) * same_source /
                         least_clutter_intensity(flight->flight_s);
  if (before + largest_log(largest) < least_log_odds) return {};  // most are far from it
  step.log_eps = log(flight->eps);
  step.log_flight = log_flight_ + (n_missing + 1) * step.log_eps;
  const double density =
      bounces_.density(*flight, step.log_eps, step.log_flight, next.log_amplitude, n_missing, step.jitter2);
  step.of_clutter = is_counted ? clutter_intensity(next.neighbours, flight->flight_s,
                                                   own_density(next, *flight, step.log_eps, same_source))
                               : clutter_intensity(next.neighbours, flight->flight_s);
  step.of_clutter /= same_source;
  step.log_odds = before + log(density / step.of_clutter);
  if (step.log_odds < least_log_odds) return {};
  return step;
}

void Hypothesis::take(const Step& step, const Observation& next) {
  const auto densities =
      rhythm_.follow(next.t_s - last_[0].t_s, next.log_amplitude, hypot(next.sigma_s, last_[0].sigma_s));
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    log_odds_rhythm_[kind] += next.log_rise_odds + log(densities[kind] / step.of_clutter);
    most_log_odds_rhythm_[kind] = std::max(most_log_odds_rhythm_[kind], log_odds_rhythm_[kind]);
  }
  log_odds = step.log_odds;
  flight_s = step.flight_s;
  log_flight_ = step.log_flight;
  bounces_.learn(step.log_eps, step.log_flight, next.log_amplitude, step.n_missing, step.jitter2);
  log_probability_of_loss_ = bounces_.log_probability_of_loss(log_flight_);
  impact += step.n_missing + 1;
  n_impacts += 1;
  last_ = {Impact{next.t_s, next.log_amplitude, next.sigma_s}, last_[0], last_[1]};
}

double Hypothesis::log_odds_of_rhythm() const {
  return std::max(most_log_odds_rhythm_[0], most_log_odds_rhythm_[1]) + kTracking.rhythm_log_odds -
         kTracking.start_log_odds;
}

double Hypothesis::log_odds_of_ball() const {
  return log_odds_of_losing_ball() - log_of_sum(0.0, log_odds_of_rhythm());
}

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
