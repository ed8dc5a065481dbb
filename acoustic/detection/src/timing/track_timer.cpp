// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/track_timer.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "timing/delay_posterior.hpp"
#include "timing/impact_timer.hpp"
#include "timing/merged_fit.hpp"
#include "timing/track_prediction.hpp"

namespace bouncelab::detection {
namespace {

// where nothing is found at the predicted time, a single loss or gain may be the reason: 0.73 to 1.07 of the interval
constexpr double kOutlierCentre = 0.9;
constexpr double kOutlierReach = 0.17;
constexpr double kStepOfTemplate = 0.25;  // of a search wider than it
constexpr double kMinInterval_s = 1.2e-3;
constexpr double kMinCycles = 3.0;      // of the template; nearer impacts cannot be separated from its ringing
constexpr double kClearRise = 20.0;     // log likelihood ratio of a candidate that noise does not reach in hours
constexpr double kReliable = 0.7;       // correlation: the template explains half of an impact's energy
constexpr double kMuchLeft = 1.25;      // of the expected residual: then the impact may be at another place
constexpr double kLate_s = 6e-3;        // of a candidate behind its impact: the longest window of candidates.cpp
constexpr double kPreEcho_s = 21.4e-3;  // of a candidate before its impact: a block of 1024 samples at 48 kHz
constexpr double kMinDoubt = 1e-2;      // probability of other times from which an impact is flagged doubtful
constexpr int kMaxFailures = 3;         // impacts in a row that are not found, then the track has ended

constexpr double kLagsPerSample = 4.0;  // of a search, both sides of the centre in steps of half a sample

// Least log likelihood ratio over the residual variance. Inside another impact's ringing the residual is not white, so
// that `noise_threshold` does not apply: an impact with a candidate needs least, one between two impacts more, one
// beyond the track's end most.
constexpr double kMinOfCandidate = 1.3;
constexpr double kMinInGap = 2.0;
constexpr double kMinBeyondEnd = 3.0;
constexpr double kMinOfOutlier = 6.0;
// ratio of the log likelihood ratio beyond the end to the largest in the sound before, where there is no impact:
// echoes, a rolling ball and voices correlate with the template here and there
constexpr double kMinProminence = 2.0;

/// Log likelihood ratio that noise alone exceeds in one of a hundred searches over n lags, as the maximum of n squared
/// normals. A hundredth is enough, since a track goes on more often than not.
double noise_threshold(double n_lags) { return log(n_lags) + 4.6; }

/// What one search needs: the sound and the template with the impacts known so far.
struct Search {
  const audio::AudioSource& sound;
  const ImpactTemplate& learned;
  ImpactTimer timer;
  double template_s = 0.0;  // duration of the template
};

/// A track while it is being timed.
struct TimedTrack {
  Search search;
  std::vector<TimedImpact> impacts;
};

/// Where an impact without candidate is searched for, and what it must have to be accepted.
struct Prediction {
  std::int64_t impact = 0;
  double after_s = 0.0;  // from the last impact
  double reach_s = 0.0;
  double until_s = 0.0;        // sound from here on belongs to the next impact
  double min_llr_ratio = 0.0;  // log likelihood ratio over residual variance
};

void append(TimedTrack& track, const TimedImpact& impact) {
  track.search.timer.subtract_from_later(impact.fit);
  track.impacts.push_back(impact);
}

/// The most likely impact within reach_s of t_s. A window that begins after an impact misses its strongest part, so
/// that a wide search takes several windows.
ImpactFit find_impact(Search& search, double t_s, double reach_s, double until_s) {
  const double step_s = kStepOfTemplate * search.template_s;
  ImpactFit best = search.timer.time(t_s, reach_s, until_s);
  if (reach_s < step_s) return best;
  for (double from_s = t_s - reach_s; from_s < t_s + reach_s; from_s += step_s) {
    const ImpactFit here = search.timer.time(from_s, step_s, until_s);
    if (here.log_likelihood_ratio > best.log_likelihood_ratio && std::abs(here.t_s - t_s) <= reach_s) best = here;
  }
  return best;
}

/// All places where the impact of a candidate may be: as far before it as the longest window in which a rise is found,
/// and as far behind as a codec's noise goes before an attack.
ImpactFit find_everywhere(Search& search, const Candidate& c, const ImpactFit& near, double most_before_s,
                          double most_after_s, double until_s) {
  const double step_s = kStepOfTemplate * search.template_s;
  const double from_s = c.t_s - std::min(kLate_s, most_before_s), to_s = c.t_s + std::min(kPreEcho_s, most_after_s);
  const double same_s = 1.0 / search.sound.rate_hz;
  ImpactFit far = near;
  for (double t_s = from_s; t_s < to_s; t_s += step_s) {  // each place lies behind the beginning of one window
    ImpactFit here = search.timer.time(t_s, std::min(step_s, to_s - t_s), until_s);
    std::erase_if(here.alternatives, [&](const DelayHypothesis& h) { return h.t_s < from_s; });
    if (here.t_s >= from_s) far = merged(far, here, same_s);
  }
  // of many far places none may push out those where the sound rises
  return merged(with_fewer_places(near), with_fewer_places(far), same_s);
}

/// Residual variance that a fit at the right place leaves: noise, and of the impact the share that the training impacts
/// have of their own.
double expected_residual(const Search& search, const ImpactFit& fit) {
  const double explained = square(search.learned.correlation);
  return std::min(1.0, search.timer.noise()) + (1.0 - explained) / explained * 2.0 * fit.log_likelihood_ratio /
                                                   static_cast<double>(search.learned.n_template);
}

void add_candidate(TimedTrack& track, const Candidate& c, std::int64_t impact, double next_s) {
  constexpr double kShare = 0.25;  // of the intervals on either side, over which an impact may be searched for
  const double last_s = track.impacts.empty() ? -1.0 : track.impacts.back().fit.t_s;
  const double before_s = kShare * (c.t_s - last_s), after_s = kShare * (next_s - c.t_s);
  TimedImpact timed;
  timed.impact = impact;
  timed.rise_s = c.t_s;
  timed.rise_reach_s = c.reach_s;
  timed.fit = find_impact(track.search, c.t_s, std::min({c.reach_s, before_s, after_s}), next_s);
  // another impact's sound in the window is reason enough for a low correlation
  const bool is_alone = std::min(c.t_s - last_s, next_s - c.t_s) > track.search.template_s;
  if (is_alone && timed.fit.residual_variance > kMuchLeft * expected_residual(track.search, timed.fit))
    timed.fit = find_everywhere(track.search, c, timed.fit, before_s, after_s, next_s);
  timed.until_s = next_s;
  timed.overlap = next_s - c.t_s < track.search.template_s;
  append(track, timed);
}

/// Whether the template supports an impact.
/// @param n_lags         of the search that found it
/// @param min_llr_ratio  least log likelihood ratio over residual variance
bool is_supported(const Search& search, const TimedImpact& impact, const TimedImpact& neighbour, double n_lags,
                  double min_llr_ratio) {
  // within the neighbour's ringing the noise was estimated from just that, for which min_llr_ratio stands
  const bool is_isolated = impact.fit.t_s - neighbour.fit.t_s > search.template_s;
  const double noise = is_isolated ? impact.fit.noise : 1.0;
  return impact.fit.log_likelihood_ratio > noise_threshold(n_lags) * noise &&
         impact.fit.log_likelihood_ratio > min_llr_ratio * impact.fit.residual_variance;
}

bool has_amplitude_of(const TimedImpact& impact, const TimedImpact& neighbour) {
  const double ratio = impact.fit.amplitude / neighbour.fit.amplitude;
  return ratio > 1.0 / kMaxAmplitudeRatio && ratio < kMaxAmplitudeRatio;
}

/// Largest log likelihood ratio in the second part of the interval before t_s, where there is no impact; 0 where that
/// part is too short.
double llr_before(TimedTrack& track, double t_s, double min_half_s) {
  constexpr double kSkipped = 0.4;  // of the interval: what rings there is the last impact
  const double last_s = track.impacts.back().fit.t_s;
  const double half_s = 0.5 * (1.0 - kSkipped) * (t_s - last_s);
  return half_s > min_half_s ? find_impact(track.search, t_s - half_s, half_s, t_s).log_likelihood_ratio : 0.0;
}

/// A peak beside the one found that is so much higher that the latter is its side lobe: a single gain or loss that the
/// search did not reach.
std::optional<ImpactFit> sidelobe_check(Search& search, const ImpactFit& found, double after_s, double until_s) {
  constexpr double kSideLobes_s = 1.5e-3;
  constexpr double kHigher = 2.0;
  if (after_s < 4.0 * kSideLobes_s) return std::nullopt;  // so near it is a neighbour's
  const ImpactFit best = find_impact(search, found.t_s, kSideLobes_s, until_s);
  if (best.log_likelihood_ratio < kHigher * found.log_likelihood_ratio) return std::nullopt;
  return best;
}

/// Searches for an impact without candidate, and appends it where it is supported.
bool search_missing(TimedTrack& track, const Prediction& p) {
  const double rate_hz = track.search.sound.rate_hz;
  const TimedImpact& last = track.impacts.back();
  const double t_s = last.fit.t_s + p.after_s;
  const double reach_s = p.reach_s + 2.0 / rate_hz;
  TimedImpact impact;
  impact.impact = p.impact;
  impact.fit = find_impact(track.search, t_s, reach_s, p.until_s);
  impact.until_s = p.until_s;
  impact.inferred = true;
  impact.overlap = p.until_s - t_s < track.search.template_s;
  double min_llr_ratio = p.min_llr_ratio;
  if (const auto higher = sidelobe_check(track.search, impact.fit, p.after_s, p.until_s)) {
    impact.fit = *higher;
    min_llr_ratio = std::max(min_llr_ratio, kMinOfOutlier);
  }
  if (!has_amplitude_of(impact, last) ||
      !is_supported(track.search, impact, last, kLagsPerSample * reach_s * rate_hz, min_llr_ratio))
    return false;
  // within the last impact's ringing everything correlates with the template
  const bool is_isolated = p.after_s > track.search.template_s;
  if (is_isolated && min_llr_ratio >= kMinBeyondEnd &&
      impact.fit.log_likelihood_ratio < kMinProminence * llr_before(track, t_s - reach_s, reach_s))
    return false;
  if (p.impact == last.impact + 1 &&
      !is_predicted_amplitude(track.impacts, impact.fit.amplitude, impact.fit.t_s - last.fit.t_s))
    return false;
  append(track, impact);
  return true;
}

/// Searches for the impacts between the last one and the next candidate.
void fill_gap(TimedTrack& track, std::int64_t next_impact, double next_s) {
  const std::int64_t n_missing = next_impact - track.impacts.back().impact - 1;
  for (std::int64_t m = 0; m < n_missing; ++m) {
    const auto n_left = static_cast<double>(n_missing - m);
    const double after_s = first_of_missing(track.impacts, n_left, next_s - track.impacts.back().fit.t_s);
    const double reach_s = predicted_eps_reach(track.impacts) * after_s;
    if (!search_missing(track, {track.impacts.back().impact + 1, after_s, reach_s, next_s, kMinInGap})) return;
  }
}

/// Continues the track beyond its last impact.
void extend(TimedTrack& track, double end_s) {
  const Search& search = track.search;
  const double shortest_s =
      std::max(kMinInterval_s, kMinCycles / (search.learned.filter.rms_frequency() * search.sound.rate_hz));
  for (int failures = 0; failures < kMaxFailures && track.impacts.size() >= 3;) {
    const double eps = predicted_eps(track.impacts);
    double flight_s = last_flight(track.impacts);
    double after_s = 0.0;
    for (int k = 0; k <= failures; ++k) after_s += flight_s *= eps;
    const double last_s = track.impacts.back().fit.t_s;
    if (flight_s < shortest_s || last_s + after_s + 0.5 * flight_s > end_s) break;
    const std::int64_t next = track.impacts.back().impact + 1 + failures;
    const double until_s = last_s + after_s + 0.9 * flight_s;
    const double reach_s = predicted_eps_reach(track.impacts) * after_s;
    const bool found = search_missing(track, {next, after_s, reach_s, until_s, kMinBeyondEnd}) ||
                       (failures == 0 && search_missing(track, {next, kOutlierCentre * after_s, kOutlierReach * after_s,
                                                                until_s, kMinOfOutlier}));
    failures = found ? 0 : failures + 1;
  }
}

/// Whether the last impact stays. A rise out of quiet is an impact though it may not correlate with the template; in
/// the ringing of the one before it may be an echo.
/// @param c  its candidate
bool keeps_last(const TimedTrack& track, const Candidate& c) {
  const TimedImpact& last = track.impacts.back();
  const TimedImpact& before = track.impacts[track.impacts.size() - 2];
  const double interval_s = last.fit.t_s - before.fit.t_s;
  const double template_s = track.search.template_s;
  const bool is_reliable = track.search.learned.correlation > kReliable;
  const bool is_clear = c.log_likelihood_ratio > kClearRise;
  if (!is_reliable && (is_clear || interval_s > template_s)) return true;
  const bool rises_out_of_quiet = is_clear && interval_s > template_s;
  return (rises_out_of_quiet || has_amplitude_of(last, before)) &&
         is_supported(track.search, last, before, kLagsPerSample * c.reach_s * track.search.sound.rate_hz,
                      kMinOfCandidate);
}

/// Removes impacts at the end that the template does not support.
void trim_tail(TimedTrack& track, const Track& tracked, const std::vector<Candidate>& candidates) {
  for (std::size_t k = tracked.impacts.size(); k-- > 0 && track.impacts.size() > 3;) {
    if (keeps_last(track, candidates[tracked.impacts[k].candidate])) return;
    track.impacts.pop_back();
    track.search.timer.forget_last();  // extend() searches where it was
  }
}

/// Adds to the variance what the other times, with their probabilities, have about the chosen one.
void set_doubt(const TimedImpact& hypotheses, const HypothesisProbabilities& p, std::size_t chosen,
               TimedImpact& impact) {
  double p_others = 0.0, squares = 0.0;
  for (std::size_t h = 0; h < p.size(); ++h) {
    if (h == chosen) continue;
    p_others += p[h];
    squares += p[h] * square(hypothesis_time(hypotheses, h) - impact.fit.t_s);
  }
  impact.doubtful = p_others > kMinDoubt;
  impact.doubt_s = std::sqrt(squares);
}

/// Puts each impact on its most probable time, and times anew those that moved or whose window reached an impact found
/// later.
std::vector<TimedImpact> resolve_delays(const Search& search, const std::vector<TimedImpact>& track) {
  const std::vector<HypothesisProbabilities> posterior = delay_posterior(track);
  ImpactTimer timer(search.sound, search.learned);
  std::vector<TimedImpact> resolved = track;
  for (std::size_t k = 0; k < track.size(); ++k) {
    TimedImpact& impact = resolved[k];
    const auto chosen =
        static_cast<std::size_t>(std::max_element(posterior[k].begin(), posterior[k].end()) - posterior[k].begin());
    const double next_s = k + 1 < track.size() ? track[k + 1].fit.t_s : INFINITY;
    const bool next_was_unknown =
        next_s - impact.fit.t_s < search.template_s && impact.until_s > next_s + kMinInterval_s;
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

}  // namespace

std::vector<TimedImpact> time_track(const audio::AudioSource& sound, const ImpactTemplate& learned,
                                    const Track& tracked, const std::vector<Candidate>& candidates, double end_s) {
  TimedTrack track{
      {sound, learned, ImpactTimer(sound, learned), static_cast<double>(learned.n_template) / sound.rate_hz}, {}};
  for (std::size_t k = 0; k < tracked.impacts.size(); ++k) {
    const TrackImpact& here = tracked.impacts[k];
    const Candidate& c = candidates[here.candidate];
    if (k > 0 && here.impact > tracked.impacts[k - 1].impact + 1) fill_gap(track, here.impact, c.t_s);
    add_candidate(track, c, here.impact, next_time(tracked, candidates, k));
  }
  trim_tail(track, tracked, candidates);
  extend(track, end_s);
  return resolve_delays(track.search, track.impacts);
}

}  // namespace bouncelab::detection
