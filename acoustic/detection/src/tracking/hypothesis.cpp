// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/hypothesis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/log_sum.hpp"
#include "tracking/student.hpp"

namespace bouncelab::detection {
namespace {

/// What the track's impacts to come contribute to the density of log amplitudes, as if they were clutter.
/// @param flight   the last one; the next takes eps times as long
/// @param log_eps  of its eps
double density_to_come(const Flight& flight, double log_eps, const TrackingModel& model) {
  const double window_s = clutter_window_s(flight.flight_s);
  double density = 0.0;
  double flight_s = flight.eps * flight.flight_s;
  double log_ratio = log_eps;
  for (double t_s = flight_s; t_s <= window_s && flight_s > kShortestFlight_s; t_s += flight_s) {
    density += model.detection_probability * amplitude_kernel(log_ratio, model);
    flight_s *= flight.eps;
    log_ratio += log_eps;
  }
  return density;
}

}  // namespace

double log_odds_of_first(const Observation& first, const TrackingModel& model) {
  return model.start_log_odds + first.log_rise_odds - log_odds_against_first(first.neighbours);
}

Hypothesis Hypothesis::begin(const Observation& first, const Observation& second, double same_source, bool is_counted,
                             const TrackingModel& model) {
  return *begin_above(-INFINITY, {log_odds_of_first(first, model), log(model.usual_eps)}, first, second, same_source,
                      is_counted, model);
}

std::optional<Hypothesis> Hypothesis::begin_above(double least_log_odds, const Birth& birth, const Observation& first,
                                                  const Observation& second, double same_source, bool is_counted,
                                                  const TrackingModel& model) {
  const double flight_s = second.t_s - first.t_s;
  const double change = second.log_amplitude - first.log_amplitude;
  const Flight flight{model.usual_eps, flight_s, 0.0};
  const double own =
      is_counted ? (amplitude_kernel(change, model) + density_to_come(flight, birth.log_usual_eps, model)) * same_source
                 : 0.0;
  const double of_clutter = clutter_intensity(second.neighbours, flight_s, own, model);
  const double of_amplitude = student3(change - model.usual_first_change, model.first_change_scatter);
  const double before = birth.log_odds_of_first + second.log_rise_odds;
  const double most = student3(0.0, model.first_flight_scatter) / flight_s * of_amplitude * same_source / of_clutter;
  if (before + largest_log(most) < least_log_odds) return {};  // most are far from it
  const double log_flight = log(flight_s);
  const double per_second =
      student3(log_flight - log(model.usual_first_flight_s), model.first_flight_scatter) / flight_s;
  const double odds = before + log(per_second * of_amplitude * same_source / of_clutter);
  if (odds < least_log_odds) return {};
  Hypothesis h;
  h.flight_s = flight_s;
  h.log_flight_ = log_flight;
  const double mean_log_amplitude = 0.5 * (first.log_amplitude + second.log_amplitude);
  h.last_ = {Impact{second.t_s, second.log_amplitude, second.sigma_s}, {first.t_s, first.log_amplitude, first.sigma_s}};
  h.bounces_ = Bounces(log_flight, mean_log_amplitude);
  h.rhythm_ = Rhythm(log_flight, mean_log_amplitude);
  h.log_odds = odds;
  h.log_odds_rhythm_.fill(h.log_odds);
  h.first_log_interval_ = log_flight;
  return h;
}

double Hypothesis::own_density(const Observation& next, const Flight& flight, double log_eps, double same_source,
                               const TrackingModel& model) const {
  const double window_s = clutter_window_s(flight.flight_s);
  double sum = density_to_come(flight, log_eps, model);
  for (const Impact& other : last_)
    if (next.t_s - other.t_s <= window_s) sum += amplitude_kernel(other.log_amplitude - next.log_amplitude, model);
  return sum * same_source;
}

double Hypothesis::jitter2(const Observation& next) const {
  return (square(next.sigma_s) + square(2.0 * last_[0].sigma_s) + square(last_[1].sigma_s)) / square(flight_s);
}

template <bool with_rhythms>
std::optional<Hypothesis> Hypothesis::extended_as(const Observation& next, int n_missing, double same_source,
                                                  bool is_counted, double least_log_odds,
                                                  const TrackingModel& model) const {
  const std::optional<Flight> flight = flight_of(next.t_s - last_[0].t_s, flight_s, n_missing);
  if (!flight) return {};
  const double before = log_odds + next.log_rise_odds;
  const double timing2 = jitter2(next);
  const double largest = bounces_.largest_density(*flight, n_missing, timing2, model) * same_source /
                         least_clutter_intensity(flight->flight_s, model);
  if (before + largest_log(largest) < least_log_odds) return {};  // most are far from it
  const double log_eps = log(flight->eps);
  const double log_flight = log_flight_ + (n_missing + 1) * log_eps;
  const double density = bounces_.density(*flight, log_eps, log_flight, next.log_amplitude, n_missing, timing2, model);
  const double own = is_counted ? own_density(next, *flight, log_eps, same_source, model) : 0.0;
  const double of_clutter = clutter_intensity(next.neighbours, flight->flight_s, own, model) / same_source;
  if (before + largest_log(density / of_clutter) < least_log_odds) return {};
  const double odds = before + log(density / of_clutter);
  if (odds < least_log_odds) return {};
  Hypothesis h = *this;
  if constexpr (with_rhythms) h.follow_rhythm(next, next.log_rise_odds - log(of_clutter), model);
  h.log_odds = odds;
  h.flight_s = flight->flight_s;
  h.log_flight_ = log_flight;
  h.bounces_.learn(log_eps, log_flight, next.log_amplitude, n_missing, timing2, model);
  h.impact += n_missing + 1;
  h.n_impacts += 1;
  h.last_ = {Impact{next.t_s, next.log_amplitude, next.sigma_s}, last_[0], last_[1]};
  return h;
}

std::optional<Hypothesis> Hypothesis::extended(const Observation& next, int n_missing, double same_source,
                                               bool is_counted, double least_log_odds,
                                               const TrackingModel& model) const {
  return extended_as<true>(next, n_missing, same_source, is_counted, least_log_odds, model);
}

std::optional<Hypothesis> Hypothesis::extended_as_ball(const Observation& next, int n_missing, double same_source,
                                                       double least_log_odds, const TrackingModel& model) const {
  return extended_as<false>(next, n_missing, same_source, false, least_log_odds, model);
}

double Hypothesis::largest_gain(int n_missing, const TrackingModel& model) const {
  return log(bounces_.largest_share_of_flight(n_missing, model) * 4.0 * std::numbers::sqrt2 /
             (model.unseen * amplitude_kernel(0.0, model)));
}

void Hypothesis::follow_rhythm(const Observation& next, double log_gain_of_clutter, const TrackingModel& model) {
  const double sigma_s = hypot(next.sigma_s, last_[0].sigma_s);
  const auto before = rhythm_.log_interval();
  const auto densities = rhythm_.follow(next.t_s - last_[0].t_s, next.log_amplitude, sigma_s, model);
  const auto after = rhythm_.log_interval();
  // the tempo of a rhythm stays within its range, normally distributed
  const auto of_range = [&](double first, std::size_t kind) {
    return 0.5 * (square(before[kind] - first) - square(after[kind] - first)) / square(model.tempo_range);
  };
  const double losing = log_odds_of_losing_ball(model);
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    if (losing + model.switch_log_odds > log_odds_ball_then_rhythm_[kind]) {
      log_odds_ball_then_rhythm_[kind] = losing + model.switch_log_odds;
      n_of_ball_[kind] = n_impacts;
      first_log_interval_after_[kind] = before[kind];
    }
    const double gain = log_gain_of_clutter + log(densities[kind]);
    log_odds_rhythm_[kind] += gain + of_range(first_log_interval_, kind);
    log_odds_ball_then_rhythm_[kind] += gain + of_range(first_log_interval_after_[kind], kind);
    most_log_odds_rhythm_[kind] = std::max(most_log_odds_rhythm_[kind], log_odds_rhythm_[kind]);
  }
}

double Hypothesis::log_odds_of_rhythm(std::size_t kind, const TrackingModel& model) const {
  return most_log_odds_rhythm_[kind] + model.rhythm_log_odds - model.start_log_odds;
}

double Hypothesis::log_odds_of_losing_ball(const TrackingModel& model) const {
  return log_odds + bounces_.log_probability_of_loss(log_flight_, model);
}

double Hypothesis::log_odds_of_ball(const TrackingModel& model) const {
  double others = 0.0;  // log odds of clutter, and of rhythms
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) others = log_of_sum(others, log_odds_of_rhythm(kind, model));
  return log_odds_of_losing_ball(model) - others;
}

Hypothesis::Verdict Hypothesis::most_probable(const TrackingModel& model) const {
  Verdict most{Explanation::ball, log_odds_of_losing_ball(model), n_impacts};
  for (std::size_t kind = 0; kind < kRhythmKinds; ++kind) {
    const double rhythm = log_odds_of_rhythm(kind, model);
    if (rhythm > most.log_odds) most = {Explanation::rhythm, rhythm, 0};
    if (log_odds_ball_then_rhythm_[kind] > most.log_odds)
      most = {Explanation::ball_then_rhythm, log_odds_ball_then_rhythm_[kind], n_of_ball_[kind]};
  }
  return most;
}

double log_odds_before(const Observation& before, const Observation& first, double same_source, double flight_s,
                       double mean_log_eps, double scatter, const TrackingModel& model) {
  const double interval_s = first.t_s - before.t_s;
  const double eps = flight_s / interval_s;
  const double log_eps = log(eps);
  const double deviation = log_eps - mean_log_eps;
  const double jitter = hypot(before.sigma_s, 2.0 * first.sigma_s) / interval_s;
  // at its first impacts a ball may lose more than later
  const double core = 0.5 * (student3(deviation, hypot(std::max(scatter, model.scatter), jitter)) +
                             student3(deviation, hypot(scatter, model.first_scatter, jitter)));
  const double of_eps = (1.0 - model.outliers) * core + model.outliers * eps * prior_of_eps(eps, model);
  const double density = model.detection_probability * of_eps / interval_s *
                         student3(first.log_amplitude - before.log_amplitude - log_eps, model.first_change_scatter);
  return before.log_rise_odds +
         log(density * same_source / clutter_intensity(before.neighbours, interval_s, 0.0, model));
}

}  // namespace bouncelab::detection
