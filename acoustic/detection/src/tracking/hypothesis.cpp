// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/hypothesis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"
#include "tracking/tracking_model.hpp"

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
  // a gain and a missing impact at once are less likely than a new drop
  const double largest_eps = n_missing > 0 ? 1.0 : kLargestEps;
  if (gap < gap_of_eps(kLeastEps, n_missing) || gap > gap_of_eps(largest_eps, n_missing)) return {};
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
