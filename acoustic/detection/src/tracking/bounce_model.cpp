// SPDX-License-Identifier: GPL-3.0-or-later
#include "tracking/bounce_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kShortestFlight_s = 1e-3;
constexpr double kShortestTrain_s = 0.4;  // a voice's pulses shrink for less
constexpr double kLeastOfMean = 0.7;      // single losses of 20 % are real, of 30 % not
constexpr double kMostOfMean = 1.4;
constexpr double kMostUnheard = 0.15;      // of the impacts, and one more
constexpr double kMostOutliers = 0.1;      // of the impacts, and one more
constexpr double kScatter = 0.015;         // of log eps from impact to impact, before the train itself is heard
constexpr double kScatterWeight = 3.0;     // impacts that this prior is worth: 0.003 and 0.06 are both plausible
constexpr double kAmplitudeScatter = 0.4;  // of log amplitude from impact to impact: the place struck varies
constexpr double kChanceAmplitude = 1.2;   // of log amplitude from one sound to any other
constexpr double kOutlier = 0.05;          // share of single losses and gains
constexpr double kHeard = 0.93;
constexpr int kMemory = 8;                 // impacts over which eps is taken as constant
constexpr std::int64_t kLeastImpacts = 4;  // two coefficients of restitution
constexpr double kLargestMeanEps = 0.992;  // a clock is no ball; steel on glass has 0.989 at 2 cm/s
constexpr double kLargestLosingEps = 0.997;
constexpr double kLeastLogLoss = 0.045;  // nor is one that jumped once,
constexpr double kLeastGain = 1.05;      // what spin gives back seldom is more,
constexpr double kMostGains = 0.08;      // and not in every few impacts
constexpr double kLeastLosing = 0.6;     // nor one that jumped twice: most impacts lose energy
// a rhythm drifts by less than it scatters; a ball that scatters more than it loses has in the end lost much
constexpr double kLossOverScatter = 1.0;
constexpr double kMuchLogLoss = 0.7;
constexpr double kLeastOverScatter = 0.2;
constexpr double kStartCost = 2.0;  // prior log odds against a train within some seconds

/// Time that n_missing + 1 flights take, over the flight before them: eps + eps^2 + ...
double gap_of_eps(double eps, int n_missing) {
  double gap = eps;
  for (int k = 0; k < n_missing; ++k) gap = eps * (1.0 + gap);
  return gap;
}

/// The other way.
double eps_of_gap(double gap, int n_missing) {
  if (n_missing == 0) return gap;
  if (n_missing == 1) return std::sqrt(0.25 + gap) - 0.5;
  static_assert(kMostMissing == 2);
  double eps = gap / 3.0;
  for (int iteration = 0; iteration < 4; ++iteration)  // Newton's, from within 0.3: to 1e-13
    eps -= (eps * (1.0 + eps * (1.0 + eps)) - gap) / (1.0 + eps * (2.0 + 3.0 * eps));
  return eps;
}

/// No less than log(x), without taking it.
double largest_log(double x) { return std::numbers::ln2 * (std::ilogb(x) + 1); }

/// Whether a gap may be that of n_missing + 1 flights.
bool is_plausible(const TrainState& train, double gap, int n_missing) {
  double least = kLeastEps;
  double largest = kLargestEps;
  if (train.n_eps > 0) {
    least = std::max(least, kLeastOfMean * train.mean_eps);
    largest = std::min(largest, kMostOfMean * train.mean_eps);
  }
  return gap >= gap_of_eps(least, n_missing) && gap <= gap_of_eps(largest, n_missing);
}

/// What errors of the times add to log eps, variance.
double jitter2(const TrainState& train, const HeardSound& next) {
  const double twice_s = 2.0 * train.last[0].sigma_s;
  const double before_s = train.last[1].sigma_s;
  return (next.sigma_s * next.sigma_s + twice_s * twice_s + before_s * before_s) / (train.flight_s * train.flight_s);
}

/// Standard deviation of the next log eps about the running mean of the train.
double spread(const TrainState& train, int n_missing, double jitter2) {
  const double n = std::clamp(train.n_eps, 1, kMemory);
  const double variance = (kScatterWeight * kScatter * kScatter + train.sum_squares) / (kScatterWeight + train.n_eps);
  return std::sqrt(variance * (1.0 + 1.0 / n) * (1.0 + n_missing) + jitter2);
}

/// Density of log eps given the train so far.
double density(double eps, double log_eps, const TrainState& train, double width) {
  constexpr double kFlat = kLargestEps - kLeastEps;
  const double flat = eps / kFlat;  // eps uniform
  if (train.n_eps == 0) return flat;
  return (1.0 - kOutlier) * student3(log_eps - train.mean_log_eps, width) + kOutlier * flat;
}

/// Odds that the amplitude goes with the train rather than with any sound: the sound of an impact is about as its
/// speed.
double odds_of_amplitude(double log_ratio, double log_eps) {
  const double deviation = log_ratio - log_eps;
  return student3(deviation, kAmplitudeScatter) / student3(deviation, kChanceAmplitude);
}

/// Odds that it sounds like the train against its own kind's: what chance offers is of its own kind.
double odds_of_timbre(const HeardSound& s) { return same_source_weight(s.alike.value_or(1.0)); }

/// n sounds of the train, as far as they are rivals of the next.
double as_rivals(int n, const HeardSound& next) {
  return next.own_are_rivals ? n * same_source_weight(next.alike.value_or(1.0)) : 0.0;
}

double probability_missing(int n_missing) {
  constexpr std::array<double, kMostMissing + 1> kProbability{kHeard, kHeard * (1.0 - kHeard),
                                                              kHeard * (1.0 - kHeard) * (1.0 - kHeard)};
  return kProbability[static_cast<std::size_t>(n_missing)];
}

TrainState::Heard to_heard(const HeardSound& s) { return {s.candidate.t_s, s.candidate.amplitude, s.sigma_s}; }

/// Impacts of the train that are among the stronger rivals of the next one.
int n_own_rivals(const TrainState& train, const Candidate& next, double flight_s) {
  const double window_s = rival_window_s(flight_s);
  return static_cast<int>(std::count_if(train.last.begin(), train.last.end(), [&](const TrainState::Heard& h) {
    return h.amplitude >= next.amplitude && next.t_s - h.t_s <= window_s;
  }));
}

/// Takes the ratio of intervals into what is known of the train.
void learn_eps(TrainState& s, double log_eps, double width, double jitter2) {
  const bool is_first = s.n_eps == 0;
  const double deviation = is_first ? 0.0 : log_eps - s.mean_log_eps;
  // one loss or gain must not carry the mean away
  const double step = is_first ? log_eps : std::clamp(deviation, -3.0 * width, 3.0 * width);
  s.n_eps += 1;
  if (!is_first) {
    s.sum_squares += step * step * (s.n_eps - 1) / s.n_eps;
    s.sum_jitter_squares += jitter2;
  }
  s.n_outliers += std::abs(deviation) > 4.0 * width ? 1 : 0;
  s.n_gains += log_eps > log(kLeastGain) ? 1 : 0;
  s.n_losing += log_eps < log(kLargestLosingEps) ? 1 : 0;
  s.log_loss -= s.mean_log_eps + std::clamp(step, -0.5 * kLeastLogLoss, 0.5 * kLeastLogLoss);
  s.mean_log_eps += step / std::min(s.n_eps, kMemory);
  s.mean_eps = exp(s.mean_log_eps);
}

}  // namespace

TrainState begin_train(const HeardSound& first, const HeardSound& second) {
  static const double kLogRange = log(kLongestFlight_s / kShortestFirstFlight_s);
  TrainState s;
  s.first_s = first.candidate.t_s;
  s.flight_s = second.candidate.t_s - s.first_s;
  s.first_flight_s = s.flight_s;
  s.last = {to_heard(second), to_heard(first)};
  s.log_amplitude = second.log_amplitude;
  const int n_own = first.candidate.amplitude >= second.candidate.amplitude ? 1 : 0;
  s.log_odds =
      -kStartCost - log(chance_of_first(first.rivals) * kLogRange * s.flight_s *
                        chance_rate(second.rivals, s.flight_s, as_rivals(n_own, second)) / odds_of_timbre(second));
  return s;
}

std::optional<TrainState> extend_train(const TrainState& from, int n_missing, const HeardSound& next,
                                       double least_log_odds) {
  const double gap = (next.candidate.t_s - from.last[0].t_s) / from.flight_s;
  if (!is_plausible(from, gap, n_missing)) return {};
  const double eps = eps_of_gap(gap, n_missing);
  double slope = 0.0;  // d(gap) / d(eps)
  double last_flight = 1.0;
  for (int m = 0; m <= n_missing; ++m) {
    slope += (m + 1) * last_flight;
    last_flight *= eps;
  }
  const double flight_s = from.flight_s * last_flight;
  if (flight_s < kShortestFlight_s) return {};
  const double log_eps = log(eps);
  const double timing2 = jitter2(from, next);
  const double width = spread(from, n_missing, timing2);
  const double per_flight = density(eps, log_eps, from, width) / (eps * slope);
  const double chance =
      from.flight_s / odds_of_timbre(next) *
      chance_rate(next.rivals, flight_s, as_rivals(n_own_rivals(from, next.candidate, flight_s), next));
  const double odds = probability_missing(n_missing) * per_flight *
                      odds_of_amplitude(next.log_amplitude - from.log_amplitude, (n_missing + 1) * log_eps);
  if (from.log_odds + largest_log(odds / chance) < least_log_odds) return {};  // most are far from it
  const double beats = n_missing + 1.0;
  const double log_odds = from.log_odds + log(odds / (chance + rhythm_density(gap / beats) / beats));
  if (log_odds < least_log_odds) return {};
  TrainState s = from;
  s.flight_s = flight_s;
  s.log_odds = log_odds;
  learn_eps(s, log_eps, width, timing2);
  s.impact += n_missing + 1;
  s.n_heard += 1;
  s.last = {to_heard(next), from.last[0], from.last[1]};
  s.log_amplitude = next.log_amplitude;
  return s;
}

double log_odds_before(const HeardSound& before, const HeardSound& first, double flight_s, double mean_log_eps,
                       double scatter) {
  const double interval_s = first.candidate.t_s - before.candidate.t_s;
  const double log_eps = log(flight_s / interval_s);
  const double jitter = hypot(before.sigma_s, 2.0 * first.sigma_s) / interval_s;
  const double core = student3(log_eps - mean_log_eps, hypot(std::max(scatter, kScatter), jitter));
  const int n_own = first.candidate.amplitude >= before.candidate.amplitude ? 1 : 0;
  const double chance = chance_rate(before.rivals, interval_s, as_rivals(n_own, before)) / odds_of_timbre(before) +
                        rhythm_density(interval_s / flight_s) / flight_s;
  return log(kHeard * (1.0 - kOutlier) * core / interval_s / chance *
             odds_of_amplitude(first.log_amplitude - before.log_amplitude, log_eps));
}

bool is_ball_like(const TrainState& s) {
  if (s.n_heard < kLeastImpacts || s.last[0].t_s - s.first_s < kShortestTrain_s) return false;
  const double n = s.n_eps;
  // single losses must not make a ball of a rhythm, nor single gains hide that it is one
  const double log_loss = std::min(s.log_loss, log(s.first_flight_s / s.flight_s));
  const double scatter = std::sqrt(std::max(0.0, s.sum_squares - s.sum_jitter_squares) / n);
  const double least_over_scatter =
      std::min(n * kLossOverScatter * scatter, std::max(kMuchLogLoss, n * kLeastOverScatter * scatter));
  return static_cast<double>(s.impact + 1 - s.n_heard) <= 1.0 + kMostUnheard * static_cast<double>(s.n_heard) &&
         s.n_outliers <= 1 + kMostOutliers * n && s.n_gains <= kMostGains * n && s.n_losing >= kLeastLosing * n &&
         log_loss > std::max({kLeastLogLoss, -n * log(kLargestMeanEps), least_over_scatter});
}

}  // namespace bouncelab::detection
