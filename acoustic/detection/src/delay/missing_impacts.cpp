// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/missing_impacts.hpp"

#include <algorithm>
#include <optional>

#include "bouncelab/core/elementary.hpp"
#include "delay/delay_model.hpp"
#include "delay/track_search.hpp"
#include "tracking/impact_odds.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kLagsPerSample = 4.0;  // of a search, both sides of the centre in steps of half a sample

/// Log likelihood ratio that noise alone exceeds in one of a hundred searches over n lags, as the maximum of n squared
/// normals. A hundredth is enough, since a track goes on more often than not.
double noise_threshold(double n_lags) { return log(n_lags) + 4.6; }

/// Where an impact without candidate is searched for, and what it must have to be accepted.
struct Prediction {
  std::int64_t impact = 0;
  double after_s = 0.0;  // from the last impact
  double reach_s = 0.0;
  double until_s = 0.0;        // sound from here on belongs to the next impact
  double min_llr_ratio = 0.0;  // log likelihood ratio over residual variance
};

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
  return ratio > 1.0 / kDelay.most_amplitude_ratio && ratio < kDelay.most_amplitude_ratio;
}

/// Largest log likelihood ratio in the second part of the interval before t_s, where there is no impact; 0 where that
/// part is too short.
double llr_before(TimedTrack& track, double t_s, double min_half_s) {
  const double last_s = track.impacts.back().fit.t_s;
  const double half_s = 0.5 * (1.0 - kDelay.ringing_part) * (t_s - last_s);
  return half_s > min_half_s ? find_impact(track.search, t_s - half_s, half_s, t_s).log_likelihood_ratio : 0.0;
}

/// A peak beside the one found that is so much higher that the latter is its side lobe: a single gain or loss that the
/// search did not reach.
std::optional<ImpactFit> sidelobe_check(Search& search, const ImpactFit& found, double after_s, double until_s) {
  if (after_s < 4.0 * kDelay.side_lobes_s) return std::nullopt;  // so near it is a neighbour's
  const ImpactFit best = find_impact(search, found.t_s, kDelay.side_lobes_s, until_s);
  if (best.log_likelihood_ratio < kDelay.higher * found.log_likelihood_ratio) return std::nullopt;
  return best;
}

/// Searches for an impact without candidate, and appends it where it is supported.
bool search_missing(TimedTrack& track, const Prediction& p) {
  const double rate_hz = track.search.white.source().rate_hz;
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
    min_llr_ratio = std::max(min_llr_ratio, kDelay.least_of_outlier);
  }
  if (!has_amplitude_of(impact, last) ||
      !is_supported(track.search, impact, last, kLagsPerSample * reach_s * rate_hz, min_llr_ratio))
    return false;
  // within the last impact's ringing everything correlates with the template
  const bool is_isolated = p.after_s > track.search.template_s;
  if (is_isolated && min_llr_ratio >= kDelay.least_beyond_end &&
      impact.fit.log_likelihood_ratio < kDelay.least_prominence * llr_before(track, t_s - reach_s, reach_s))
    return false;
  impact.probability = probability_of_inferred(
      impact.fit.log_likelihood_ratio / std::max(impact.fit.noise, impact.fit.residual_variance),
      kLagsPerSample * reach_s * rate_hz);
  append(track, impact);
  return true;
}

}  // namespace

void fill_gap(TimedTrack& track, std::int64_t next_impact, double next_s) {
  while (track.impacts.back().impact + 1 < next_impact) {
    const std::int64_t impact = track.impacts.back().impact + 1;
    const double last_s = track.impacts.back().fit.t_s;
    const double eps_reach = predicted_eps_reach(track.impacts);
    const auto search_after = [&](double after_s) {
      return search_missing(track, {impact, after_s, eps_reach * after_s, next_s, kDelay.least_in_gap});
    };
    const bool found =
        search_after(first_of_missing(track.impacts, static_cast<double>(next_impact - impact), next_s - last_s)) ||
        // the next candidate may be late: a knock, an echo
        (track.impacts.size() >= 3 && search_after(predict_beyond_end(track.impacts, 0).t_s - last_s));
    if (!found) return;
  }
}

void extend(TimedTrack& track, double end_s) {
  const Search& search = track.search;
  const double shortest_s =
      std::max(kDelay.least_interval_s,
               kDelay.fewest_cycles / (search.learned.filter.rms_frequency() * search.white.source().rate_hz));
  for (int failures = 0; failures < kDelay.most_failures && track.impacts.size() >= 3;) {
    const double last_s = track.impacts.back().fit.t_s;
    const PredictedImpact predicted = predict_beyond_end(track.impacts, failures);
    const double after_s = predicted.t_s - last_s, flight_s = predicted.flight_s;
    if (std::min(flight_s, after_s) < shortest_s || predicted.t_s + 0.5 * flight_s > end_s) break;
    const std::int64_t next = track.impacts.back().impact + 1 + failures;
    const double until_s = predicted.t_s + 0.9 * flight_s;
    // what the last impacts predict may differ by more than eps scatters: one of them has gained or lost, or is wrong
    const double reach_s = predicted_eps_reach(track.impacts) * after_s + predicted.spread_s;
    const bool found =
        search_missing(track, {next, after_s, reach_s, until_s, kDelay.least_beyond_end}) ||
        (failures == 0 && search_missing(track, {next, kDelay.outlier_centre * after_s, kDelay.outlier_reach * after_s,
                                                 until_s, kDelay.least_of_outlier}));
    failures = found ? 0 : failures + 1;
  }
}

}  // namespace bouncelab::detection
