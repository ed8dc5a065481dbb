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
constexpr double kScatter = 0.015;         // of log eps from impact to impact, before the train itself is seen
constexpr double kScatterWeight = 3.0;     // impacts that this prior is worth: 0.003 and 0.06 are both plausible
constexpr double kAmplitudeScatter = 0.4;  // of log amplitude from impact to impact: the place struck varies
constexpr double kClutterAmplitude = 0.6;  // of the second impact to the first
constexpr double kUsualLoss = 0.25;
constexpr double kOutlier = 0.05;  // share of single losses and gains
constexpr double kGains = 0.1;     // share of impacts after which eps may be above 1: a spinning ball
constexpr double kDetected = 0.93;
constexpr double kMostScatter = 1.0;       // of log eps, over the mean loss: one that scatters more is no ball
constexpr double kFirstScatter = 0.08;     // of log eps of the first impacts against those that follow
constexpr int kMemory = 8;                 // impacts over which eps is taken as constant
constexpr double kLeastLoss = 0.008;       // of log eps on the mean: steel on glass has 0.011 at 2 cm/s, a clock none
constexpr double kStartCost = 0.5;         // prior log odds against a train within some seconds
const double kLogUsualFlight = log(0.4);   // the first: a ball dropped from some 30 cm
constexpr double kFlightScatter = 0.8;     // of its logarithm
constexpr double kRhythm = 1.0;            // prior log odds of a rhythm against a ball
constexpr double kBeatScatter = 0.05;      // of log interval: drummers 2 %, hands and feet 3 to 8 %
constexpr double kMachineScatter = 0.003;  // of log interval of a machine, half of all rhythms
constexpr double kBeatWeight = 2.0;        // intervals that this prior is worth
constexpr double kSwitch = 3.0;            // prior log odds against a rhythm that begins in the middle of a train
constexpr double kTempo = 0.5;             // weight of the last interval in the tempo that follows
constexpr double kTempoDrift = 0.15;       // and in its trend
constexpr double kRhythmAmplitude = 0.6;   // of log amplitude from beat to beat

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
bool is_plausible(double gap, int n_missing) {
  return gap >= gap_of_eps(kLeastEps, n_missing) && gap <= gap_of_eps(kLargestEps, n_missing);
}

/// What errors of the times add to log eps, variance.
double jitter2(const TrainState& train, const HeardSound& next) {
  const double twice_s = 2.0 * train.last[0].sigma_s;
  const double before_s = train.last[1].sigma_s;
  return (next.sigma_s * next.sigma_s + twice_s * twice_s + before_s * before_s) / (train.flight_s * train.flight_s);
}

/// Standard deviation of the next log eps about the running mean of the train.
struct Spread {
  double learned = 0.0;  ///< as the train itself shows it
  double of_ball = 0.0;  ///< no more than a ball has that loses as much
};

Spread spread(const TrainState& train, int n_missing, double jitter2) {
  const double n = std::clamp(train.n_eps, 1, kMemory);
  const double factor = (1.0 + 1.0 / n) * (1.0 + n_missing);
  const double learned = (kScatterWeight * kScatter * kScatter + train.sum_squares) / (kScatterWeight + train.n_eps);
  const double of_ball = std::min(learned, square(kMostScatter * std::max(kLeastLoss, -train.mean_log_eps)));
  return {std::sqrt(learned * factor + jitter2), std::sqrt(of_ball * factor + jitter2)};
}

/// Density of eps where nothing is known of the ball.
double prior_of_eps(double eps) {
  if (eps < kLeastEps || eps > kLargestEps) return 0.0;
  return (1.0 - kGains) * (eps <= 1.0 ? 1.0 / (1.0 - kLeastEps) : 0.0) + kGains / (kLargestEps - kLeastEps);
}

/// Density of log eps given the train so far.
double density(double eps, double log_eps, const TrainState& train, double width) {
  const double prior = eps * prior_of_eps(eps);
  if (train.n_eps == 0) return prior;
  return (1.0 - kOutlier) * student3(log_eps - train.mean_log_eps, width) + kOutlier * prior;
}

/// Odds that it sounds like the train against its own kind's: what chance offers is of its own kind.
double odds_of_timbre(const HeardSound& s) { return same_source_weight(s.alike.value_or(1.0)); }

double probability_missing(int n_missing) {
  constexpr std::array<double, kMostMissing + 1> kProbability{kDetected, kDetected * (1.0 - kDetected),
                                                              kDetected * (1.0 - kDetected) * (1.0 - kDetected)};
  return kProbability[static_cast<std::size_t>(n_missing)];
}

TrainState::Heard to_heard(const HeardSound& s) { return {s.candidate.t_s, s.log_amplitude, s.sigma_s}; }

/// What the train's own impacts add to the density of rivals of the next one.
double own_density(const TrainState& train, const HeardSound& next, double flight_s) {
  if (!next.own_are_rivals) return 0.0;
  const double window_s = rival_window_s(flight_s);
  double sum = 0.0;
  for (const TrainState::Heard& h : train.last)
    if (next.candidate.t_s - h.t_s <= window_s) sum += amplitude_kernel(h.log_amplitude - next.log_amplitude);
  return sum * same_source_weight(next.alike.value_or(1.0));
}

/// Takes the ratio of intervals into what is known of the train.
void learn_eps(TrainState& s, double log_eps, double width) {
  const bool is_first = s.n_eps == 0;
  const double deviation = is_first ? 0.0 : log_eps - s.mean_log_eps;
  // one loss or gain must not carry the mean away
  const double step = is_first ? log_eps : std::clamp(deviation, -3.0 * width, 3.0 * width);
  s.n_eps += 1;
  if (!is_first) s.sum_squares += step * step * (s.n_eps - 1) / s.n_eps;
  // single losses must not make a ball of a rhythm, nor single gains hide that it is one
  s.log_loss -= is_first ? log_eps : s.mean_log_eps + step;
  s.mean_log_eps += step / std::min(s.n_eps, kMemory);
  s.mean_eps = exp(s.mean_log_eps);
}

/// Intervals of a rhythm in beats.
double beats(double ratio) {
  if (ratio < std::numbers::sqrt2 / 2.0) return 0.5;
  return std::clamp(std::round(ratio), 1.0, kMostMissing + 1.0);
}

/// Densities of the next sound's time as that of a rhythm [1/s], which it then follows: by hand, a local level and
/// trend of the log interval; by a machine, the interval before. Beats are left out as impacts are, or one is divided
/// by two.
std::array<double, 2> follow_rhythm(TrainState& s, const HeardSound& next, double gap_s) {
  const double expected = s.log_beat + s.log_beat_drift;
  const double n_beats = beats(gap_s * exp(-expected));
  const double log_interval = log(gap_s / n_beats);
  const double deviation = log_interval - expected;
  const double jitter2 = (square(next.sigma_s) + square(s.last[0].sigma_s)) / square(gap_s);
  const double learned =
      (kBeatWeight * kBeatScatter * kBeatScatter + s.sum_squares_beat) / (kBeatWeight + std::min(s.n_eps, kMemory));
  const double width = std::sqrt(learned + jitter2);
  const double step = std::clamp(deviation, -3.0 * width, 3.0 * width);
  s.sum_squares_beat += step * step - (s.n_eps >= kMemory ? s.sum_squares_beat / kMemory : 0.0);
  s.log_beat = n_beats < 1.0 ? log(gap_s) : expected + kTempo * step;
  s.log_beat_drift += kTempoDrift * step;
  const double by_machine = student3(log_interval - s.last_log_beat, std::sqrt(square(kMachineScatter) + jitter2));
  s.last_log_beat = n_beats < 1.0 ? log(gap_s) : log_interval;
  constexpr double kAnyInterval = 1.0 / 3.0;  // of log interval, within a factor of 4.5 either way
  const double of_beats = probability_missing(n_beats < 1.0 ? 1 : static_cast<int>(n_beats) - 1) / gap_s;
  const auto density = [&](double core) { return of_beats * ((1.0 - kOutlier) * core + kOutlier * kAnyInterval); };
  return {density(student3(deviation, width)), density(by_machine)};
}

/// Takes the amplitude into what is known of the train.
void learn_amplitude(TrainState& s, double log_amplitude, double log_flight) {
  const double n = std::clamp<double>(static_cast<double>(s.n_heard), 1.0, kMemory);
  s.mean_log_loudness += (log_amplitude - log_flight - s.mean_log_loudness) / n;
  s.mean_log_amplitude += (log_amplitude - s.mean_log_amplitude) / n;
}

}  // namespace

double TrainState::log_odds_of_ball() const {
  if (n_eps == 0) return log_odds;
  // that it loses energy on the whole: the mean of log eps against its standard error
  const double variance = (kScatterWeight * kScatter * kScatter + sum_squares) / (kScatterWeight + n_eps);
  const double loss = std::min(log_loss, log(first_flight_s / flight_s)) / n_eps;
  const double z = (loss - kLeastLoss) / std::sqrt(variance / n_eps);
  const double log_loses = z > -5.0 ? log(0.5 * erfc(-z / std::numbers::sqrt2)) : -0.5 * z * z - 2.5;
  return log_odds + log_loses -
         log1p(exp(kRhythm + kStartCost + log_odds_rhythm[0]) + exp(kRhythm + kStartCost + log_odds_rhythm[1]));
}

double log_odds_of_first(const Rivals& rivals, double log_rise_odds) {
  return log_rise_odds - kStartCost - log(chance_of_first(rivals));
}

TrainState begin_train(const HeardSound& first, const HeardSound& second) {
  TrainState s;
  s.first_s = first.candidate.t_s;
  s.flight_s = second.candidate.t_s - s.first_s;
  s.first_flight_s = s.flight_s;
  s.log_beat = log(s.flight_s);
  s.last_log_beat = s.log_beat;
  s.last = {to_heard(second), to_heard(first)};
  s.mean_log_amplitude = 0.5 * (first.log_amplitude + second.log_amplitude);
  // the flight before the first impact is not known; it is taken for as long as that after it
  s.mean_log_loudness = s.mean_log_amplitude - s.log_beat;
  const double log_ratio = second.log_amplitude - first.log_amplitude;
  const double own =
      second.own_are_rivals ? amplitude_kernel(log_ratio) * same_source_weight(second.alike.value_or(1.0)) : 0.0;
  s.log_odds = first.log_odds_first + second.log_rise_odds -
               log(s.flight_s / student3(s.log_beat - kLogUsualFlight, kFlightScatter) *
                   clutter_intensity(second.rivals, s.flight_s, own) / odds_of_timbre(second) /
                   student3(log_ratio + kUsualLoss, kClutterAmplitude));
  s.log_odds_rhythm.fill(s.log_odds);
  return s;
}

std::optional<TrainState> extend_train(const TrainState& from, int n_missing, const HeardSound& next,
                                       double least_log_odds) {
  const double gap_s = next.candidate.t_s - from.last[0].t_s;
  const double gap = gap_s / from.flight_s;
  if (!is_plausible(gap, n_missing)) return {};
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
  const Spread width = spread(from, n_missing, jitter2(from, next));
  const double per_second = density(eps, log_eps, from, width.of_ball) / (eps * slope * from.flight_s);
  const double chance =
      clutter_intensity(next.rivals, flight_s, own_density(from, next, flight_s)) / odds_of_timbre(next);
  const double log_flight = log(flight_s);
  const double of_amplitude = student3(next.log_amplitude - from.mean_log_loudness - log_flight, kAmplitudeScatter);
  const double odds = probability_missing(n_missing) * per_second * of_amplitude;
  const double base = from.log_odds + next.log_rise_odds;
  if (base + largest_log(odds / chance) < least_log_odds) return {};  // most are far from it
  const double log_odds = base + log(odds / chance);
  if (log_odds < least_log_odds) return {};
  TrainState s = from;
  s.flight_s = flight_s;
  s.log_odds = log_odds;
  const std::array<double, 2> of_rhythm = follow_rhythm(s, next, gap_s);
  const double of_beat = student3(next.log_amplitude - from.mean_log_amplitude, kRhythmAmplitude) / chance;
  for (std::size_t r = 0; r < of_rhythm.size(); ++r) {
    if (from.log_odds - kSwitch > from.log_odds_ball_then_rhythm[r]) {
      s.log_odds_ball_then_rhythm[r] = from.log_odds - kSwitch;
      s.n_of_ball[r] = from.n_heard;
    }
    const double gain = next.log_rise_odds + log(of_rhythm[r] * of_beat);
    s.log_odds_rhythm[r] += gain;
    s.log_odds_ball_then_rhythm[r] += gain;
  }
  learn_eps(s, log_eps, width.learned);
  s.impact += n_missing + 1;
  s.n_heard += 1;
  learn_amplitude(s, next.log_amplitude, log_flight);
  s.last = {to_heard(next), from.last[0], from.last[1]};
  return s;
}

double log_odds_before(const HeardSound& before, const HeardSound& first, double flight_s, double mean_log_eps,
                       double scatter) {
  const double interval_s = first.candidate.t_s - before.candidate.t_s;
  const double eps = flight_s / interval_s;
  const double log_eps = log(eps);
  const double jitter = hypot(before.sigma_s, 2.0 * first.sigma_s) / interval_s;
  // at its first impacts a ball may lose more than later
  const double core = 0.5 * (student3(log_eps - mean_log_eps, hypot(std::max(scatter, kScatter), jitter)) +
                             student3(log_eps - mean_log_eps, hypot(scatter, kFirstScatter, jitter)));
  const double own = before.own_are_rivals ? amplitude_kernel(first.log_amplitude - before.log_amplitude) *
                                                 same_source_weight(before.alike.value_or(1.0))
                                           : 0.0;
  const double chance = clutter_intensity(before.rivals, interval_s, own) / odds_of_timbre(before);
  return before.log_rise_odds +
         log(kDetected * ((1.0 - kOutlier) * core + kOutlier * eps * prior_of_eps(eps)) / interval_s / chance *
             student3(first.log_amplitude - before.log_amplitude - log_eps, kAmplitudeScatter));
}

}  // namespace bouncelab::detection
