// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/track_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "delay/timed_impact.hpp"
#include "tracking/tracker.hpp"
#include "tracking/tracking_model.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kLagsPerSample = 4.0;  // of a search, both sides of the centre in steps of half a sample

using TimedImpacts = std::vector<TimedImpact>;

/// A track while it is being timed.
struct TimedTrack {
  ImpactTimer timer;  ///< with the impacts known so far
  TimedImpacts impacts;

  /// Its ringing is subtracted from then on.
  void append(const TimedImpact& impact) {
    timer.subtract_from_later(impact.fit);
    impacts.push_back(impact);
  }
};

/// The flight that ends at impact k; where impacts are missing in it, its last part.
double flight_before(const TimedImpacts& track, std::size_t k, double eps) {
  const auto n = static_cast<double>(track[k].impact - track[k - 1].impact);
  return (track[k].fit.t_s - track[k - 1].fit.t_s) * pow(eps, n - 1.0) * (1.0 - eps) / (1.0 - pow(eps, n));
}

/// Coefficient of restitution of the next impact: the median of the last nine ratios of intervals, 0.3 ... 0.999;
/// 0.97 where there is none.
double predicted_eps(const TimedImpacts& track) {
  constexpr std::size_t kMost = 9;
  std::vector<double> ratios;
  for (std::size_t k = track.size(); k-- > 2 && ratios.size() < kMost;)
    if (track[k].impact - track[k - 2].impact == 2)
      ratios.push_back((track[k].fit.t_s - track[k - 1].fit.t_s) / (track[k - 1].fit.t_s - track[k - 2].fit.t_s));
  // at most 0.999, so that a geometric series of it has a finite sum
  return ratios.empty() ? 0.97 : std::clamp(upper_median(std::move(ratios)), 0.3, 0.999);
}

/// Where an impact without candidate is searched for, and what it must have to be accepted.
struct Prediction {
  std::int64_t impact = 0;
  double after_s = 0.0;  // from the last impact
  double reach_s = 0.0;
  double until_s = 0.0;        // sound from here on belongs to the next impact
  double min_llr_ratio = 0.0;  // log likelihood ratio over what is left
};

/// Whether the template supports an impact about as loud as its neighbour.
/// @param n_lags         of the search that found it
/// @param min_llr_ratio  least log likelihood ratio over what is left
bool is_supported(const ImpactTimer& timer, const TimedImpact& impact, const TimedImpact& neighbour, double n_lags,
                  double min_llr_ratio) {
  const double ratio = impact.fit.amplitude / neighbour.fit.amplitude;
  if (!(ratio > 1.0 / kDelay.most_amplitude_ratio && ratio < kDelay.most_amplitude_ratio)) return false;
  // that noise alone exceeds in one of a hundred searches, as the maximum of n squared normals; a hundredth is enough,
  // since a track goes on more often than not
  const double least_llr = log(n_lags) + 4.6;
  // within the neighbour's ringing the noise was estimated from just that, for which min_llr_ratio stands
  const bool is_isolated = impact.fit.t_s - neighbour.fit.t_s > timer.template_s();
  return impact.fit.log_likelihood_ratio > least_llr * (is_isolated ? impact.fit.noise : 1.0) &&
         impact.fit.log_likelihood_ratio > min_llr_ratio * impact.fit.rest;
}

/// Searches for an impact without candidate, and appends it where it is supported.
bool search_missing(TimedTrack& track, const Prediction& p) {
  const double rate_hz = track.timer.rate_hz();
  const TimedImpact& last = track.impacts.back();
  const double t_s = last.fit.t_s + p.after_s;
  const double reach_s = p.reach_s + 2.0 / rate_hz;
  const double n_lags = kLagsPerSample * reach_s * rate_hz;
  TimedImpact impact;
  impact.impact = p.impact;
  impact.fit = track.timer.search(t_s, reach_s, p.until_s);
  impact.until_s = p.until_s;
  impact.inferred = true;
  impact.overlap = p.until_s - t_s < track.timer.template_s();
  if (!is_supported(track.timer, impact, last, n_lags, p.min_llr_ratio)) return false;
  impact.probability =
      probability_of_inferred(impact.fit.log_likelihood_ratio / std::max(impact.fit.noise, impact.fit.rest), n_lags);
  track.append(impact);
  return true;
}

/// An impact to come.
struct PredictedImpact {
  double t_s = 0.0;
  double flight_s = 0.0;  ///< before it
};

/// The next impact, by the eps of the last ones: the median of what the last impact, the one before it and the one
/// before that predict, each with the flight that ends there: one of them may be in a wrong place. Needs two impacts,
/// in time order.
PredictedImpact predict_next(const TimedImpacts& track) {
  const double eps = predicted_eps(track);
  std::vector<PredictedImpact> predicted;
  for (std::size_t back = 1; back <= kDelay.anchors && back < track.size(); ++back) {
    const std::size_t k = track.size() - back;
    PredictedImpact p{track[k].fit.t_s, flight_before(track, k, eps)};
    for (std::int64_t impact = track[k].impact; impact <= track.back().impact; ++impact) p.t_s += p.flight_s *= eps;
    predicted.push_back(p);
  }
  std::sort(predicted.begin(), predicted.end(),
            [](const PredictedImpact& a, const PredictedImpact& b) { return a.t_s < b.t_s; });
  return predicted[predicted.size() / 2];
}

/// Searches for the impacts between the last one and the next candidate.
void fill_gap(TimedTrack& track, std::int64_t next_impact, double next_s) {
  while (track.impacts.back().impact + 1 < next_impact) {
    const std::int64_t impact = track.impacts.back().impact + 1;
    const double last_s = track.impacts.back().fit.t_s;
    // a geometric series of intervals of the predicted eps, that together take the time to the next candidate
    const double eps = predicted_eps(track.impacts), n = static_cast<double>(next_impact - impact);
    const double first_s = (next_s - last_s) * (1.0 - eps) / (1.0 - pow(eps, n + 1.0));
    if (!search_missing(track, {impact, first_s, kDelay.eps_reach * first_s, next_s, kDelay.least_in_gap})) return;
  }
}

/// Continues the track beyond its last impact, which may be a single loss or gain.
/// @param end_s  impacts are searched for up to it
void extend(TimedTrack& track, double end_s) {
  const double shortest_s =
      std::max(kDelay.least_interval_s,
               kDelay.fewest_cycles / (track.timer.learned().filter.rms_frequency() * track.timer.rate_hz()));
  while (track.impacts.size() >= 3) {
    const PredictedImpact predicted = predict_next(track.impacts);
    const double after_s = predicted.t_s - track.impacts.back().fit.t_s, flight_s = predicted.flight_s;
    if (std::min(flight_s, after_s) < shortest_s || predicted.t_s + 0.5 * flight_s > end_s) return;
    const Prediction next{track.impacts.back().impact + 1, kDelay.outlier_centre * after_s,
                          kDelay.outlier_reach * after_s, predicted.t_s + 0.9 * flight_s, kDelay.least_of_outlier};
    if (!search_missing(track, next)) return;
  }
}

/// All places where the impact of a candidate may be: as far before it as the longest window in which a rise is found,
/// and as far behind as a codec's noise goes before an attack.
/// @param near                     the best fit within its reach, with all places there
/// @param most_before_s, _after_s  of the rise
ImpactFit find_everywhere(ImpactTimer& timer, double rise_s, const ImpactFit& near, double most_before_s,
                          double most_after_s, double until_s) {
  const double from_s = rise_s - std::min(kDelay.late_s, most_before_s),
               to_s = rise_s + std::min(kDelay.pre_echo_s, most_after_s);
  const double same_s = 1.0 / timer.rate_hz();
  ImpactFit far = near;
  const double step_s = timer.step_s();
  for (double t_s = from_s; t_s < to_s; t_s += step_s) {  // each place lies behind the beginning of one window
    // of no other place than could be merged
    const double least = far.log_likelihood_ratio - kDelay.unambiguous * far.disturbance;
    ImpactFit fit = timer.time(t_s, std::min(step_s, to_s - t_s), until_s, least);
    std::erase_if(fit.alternatives, [&](const DelayHypothesis& h) { return h.t_s < from_s; });
    if (fit.t_s >= from_s) far = merged(far, fit, same_s);
  }
  // of many far places none may push out those where the sound rises
  return merged(with_fewer_places(near), with_fewer_places(far), same_s);
}

/// Whether the residual is that of noise and what an impact has of its own, over what the template explains of it: that
/// of the training impacts.
bool is_explained(const ImpactTimer& timer, const ImpactFit& fit) {
  if (square(fit.correlation) > kDelay.most_explained) return true;
  const double explained = square(timer.learned().correlation);
  const double explained_variance = 2.0 * fit.log_likelihood_ratio / static_cast<double>(timer.learned().n_template);
  const double expected = std::min(1.0, timer.noise()) + (1.0 - explained) / explained * explained_variance;
  return fit.residual_variance <= kDelay.much_left * expected;
}

/// The fit with the sound up to the next candidate alone, where that is an impact by the template: what follows is
/// another sound then, a knock of the same plate perhaps, however loud.
std::optional<ImpactFit> before_another_sound(ImpactTimer& timer, const std::vector<Candidate>& candidates,
                                              std::size_t k, double reach_s) {
  const Candidate& c = candidates[k];
  const double from_s =
      c.t_s + std::max(c.reach_s, kDelay.least_interval_s);  // before that it is the same sound, noticed twice
  const auto other = std::find_if(candidates.begin() + static_cast<std::ptrdiff_t>(k), candidates.end(),
                                  [&](const Candidate& later) { return later.t_s >= from_s; });
  // so late that no window of find_everywhere() reaches it: there is no other sound
  if (other == candidates.end() || other->t_s >= c.t_s + kDelay.pre_echo_s + timer.template_s()) return {};
  const double until_s = std::min(other->t_s, c.t_s + kDelay.of_template * timer.template_s());
  const ImpactFit fit = timer.search(c.t_s, reach_s, until_s);
  if (fit.log_likelihood_ratio < kDelay.unambiguous || !is_explained(timer, fit)) return {};
  return fit;
}

void add_candidate(TimedTrack& track, const std::vector<Candidate>& candidates, const TrackImpact& of_track,
                   double next_s) {
  const Candidate& c = candidates[of_track.candidate];
  const double last_s = track.impacts.empty() ? -1.0 : track.impacts.back().fit.t_s;
  const double before_s = kDelay.search_share * (c.t_s - last_s), after_s = kDelay.search_share * (next_s - c.t_s);
  TimedImpact timed;
  timed.impact = of_track.impact;
  timed.probability = of_track.probability;
  timed.rise_s = c.t_s;
  timed.rise_reach_s = c.reach_s;
  timed.until_s = next_s;
  const double reach_s = std::min({c.reach_s, before_s, after_s});
  timed.fit = track.timer.search(c.t_s, reach_s, next_s);
  // another impact's sound in the window is reason enough for a low correlation
  const bool is_alone = std::min(c.t_s - last_s, next_s - c.t_s) > track.timer.template_s();
  if (is_alone && !is_explained(track.timer, timed.fit)) {
    const auto alone = before_another_sound(track.timer, candidates, of_track.candidate, reach_s);
    timed.fit = alone ? *alone : find_everywhere(track.timer, c.t_s, timed.fit, before_s, after_s, next_s);
  }
  timed.overlap = next_s - c.t_s < track.timer.template_s();
  track.append(timed);
}

/// Puts each impact on its most probable time, and times anew those that moved or whose window reached an impact found
/// later.
std::vector<TimedImpact> resolve_delays(ImpactTimer timer, const std::vector<TimedImpact>& track) {
  const std::vector<HypothesisProbabilities> posterior = delay_posterior(track);
  std::vector<TimedImpact> resolved = track;
  for (std::size_t k = 0; k < track.size(); ++k) {
    TimedImpact& impact = resolved[k];
    const std::size_t chosen = most_probable(posterior[k]);
    const double next_s = k + 1 < track.size() ? track[k + 1].fit.t_s : INFINITY;
    const bool next_was_unknown =
        next_s - impact.fit.t_s < timer.template_s() && impact.until_s > next_s + kDelay.least_interval_s;
    if (chosen > 0 || next_was_unknown) {
      impact.until_s = std::min(impact.until_s, next_s);
      impact.fit = timer.time(hypothesis_time(track[k], chosen), 0.0, impact.until_s);
      impact.overlap = impact.overlap || next_was_unknown;
    }
    set_doubt(track[k], posterior[k], chosen, impact);
    timer.subtract_from_later(impact.fit);
  }
  return resolved;
}

/// Time of the next impact, whether or not it has a candidate; a second later where there is none.
double next_time(const Track& tracked, const std::vector<Candidate>& candidates, std::size_t k) {
  const double t_s = candidates[tracked.impacts[k].candidate].t_s;
  if (k + 1 == tracked.impacts.size()) return t_s + 1.0;
  const TrackImpact& next = tracked.impacts[k + 1];
  return t_s + (candidates[next.candidate].t_s - t_s) / static_cast<double>(next.impact - tracked.impacts[k].impact);
}

/// Of a row of inferred impacts each is searched for where the one before it predicts it: they are the ball's up to one
/// of them, and other sounds from there on. With the odds q_k of another sound against an impact at k, as each by
/// itself has them, the row is the ball's up to j with weight
///
///   w_j = product of q_k over k > j,   p_k = sum of w_j over j >= k / sum of all w_j
///
/// so that those that follow in their places speak for those before.
/// @param begin, end  of the row
void set_probabilities_of_row(std::size_t begin, std::size_t end, std::vector<TimedImpact>& track) {
  constexpr double kLeast = 1e-6;  // of a probability
  double weight = 1.0, sum = 0.0;
  for (std::size_t k = end; k-- > begin;) {
    const double other_sound = 1.0 / std::max(kLeast, track[k].probability) - 1.0;
    track[k].probability = sum += weight;
    weight *= other_sound;
  }
  for (std::size_t k = begin; k < end; ++k) track[k].probability /= sum + weight;
}

/// Beyond the significance that search_missing() has set.
void set_probabilities_of_inferred(const std::vector<Candidate>& candidates, std::vector<TimedImpact>& track) {
  for (TimedImpact& impact : track)
    if (impact.inferred && is_at_candidate(candidates, impact.fit.t_s)) impact.probability *= kTracking.refused;
  for (std::size_t begin = 0; begin < track.size();) {
    std::size_t end = begin;
    while (end < track.size() && track[end].inferred) ++end;
    if (end > begin) set_probabilities_of_row(begin, end, track);
    begin = end + 1;
  }
}

/// The track ends where what is inferred beyond is less probable an impact than not: in a room's echoes, in the noise
/// of a codec and in a rolling ball's sound the template finds something wherever it is searched for. A last one at a
/// candidate that the tracker refused is about as often an impact as not, and is kept with its probability.
void end_where_improbable(std::vector<TimedImpact>& track) {
  const double kLeast = 0.9 * kTracking.refused;
  while (track.size() > 3 && track.back().inferred && track.back().probability < kLeast) track.pop_back();
}

}  // namespace

std::vector<TimedImpact> time_track(WhiteSound& white, const ImpactTemplate& learned, const Track& tracked,
                                    const std::vector<Candidate>& candidates, double end_s) {
  TimedTrack track{ImpactTimer(white, learned), {}};
  for (std::size_t k = 0; k < tracked.impacts.size(); ++k) {
    const TrackImpact& impact = tracked.impacts[k];
    const Candidate& c = candidates[impact.candidate];
    if (k > 0 && impact.impact > tracked.impacts[k - 1].impact + 1) fill_gap(track, impact.impact, c.t_s);
    add_candidate(track, candidates, impact, next_time(tracked, candidates, k));
  }
  extend(track, end_s);
  std::vector<TimedImpact> timed = resolve_delays(ImpactTimer(white, learned), track.impacts);
  set_probabilities_of_inferred(candidates, timed);
  end_where_improbable(timed);
  return timed;
}

}  // namespace bouncelab::detection
