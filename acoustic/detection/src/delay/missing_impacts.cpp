// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/missing_impacts.hpp"

#include <algorithm>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"
#include "delay/delay_model.hpp"
#include "tracking/impact_odds.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kLagsPerSample = 4.0;  // of a search, both sides of the centre in steps of half a sample

using TimedImpacts = std::vector<TimedImpact>;

/// Ratios of the last intervals, sorted.
std::vector<double> last_ratios(const TimedImpacts& track) {
  std::vector<double> ratios;
  for (std::size_t k = track.size(); k-- > 2 && ratios.size() < kDelay.most_ratios;)
    if (track[k].impact - track[k - 2].impact == 2)
      ratios.push_back((track[k].fit.t_s - track[k - 1].fit.t_s) / (track[k - 1].fit.t_s - track[k - 2].fit.t_s));
  std::sort(ratios.begin(), ratios.end());
  return ratios;
}

/// The flight that ends at impact k; where impacts are missing in it, its last part.
double flight_before(const TimedImpacts& track, std::size_t k, double eps) {
  const auto n = static_cast<double>(track[k].impact - track[k - 1].impact);
  return (track[k].fit.t_s - track[k - 1].fit.t_s) * pow(eps, n - 1.0) * (1.0 - eps) / (1.0 - pow(eps, n));
}

/// Coefficient of restitution of the next impact: the median of the last nine ratios of intervals, 0.3 ... 0.999;
/// 0.97 where there is none.
double predicted_eps(const TimedImpacts& track) {
  const std::vector<double> ratios = last_ratios(track);
  // at most 0.999, so that a geometric series of it has a finite sum
  return ratios.empty() ? kDelay.default_eps : std::clamp(ratios[ratios.size() / 2], 0.3, 0.999);
}

/// How far the next interval may be from the predicted one, as a share of it: four standard deviations of the last
/// ratios (from their quartiles), within 0.015 ... 0.06.
double predicted_eps_reach(const TimedImpacts& track) {
  constexpr double kQuartilesToSigma = 0.74;  // the quartiles of a normal distribution are 1.35 sigma apart
  const std::vector<double> ratios = last_ratios(track);
  if (ratios.size() < kDelay.fewest_ratios) return kDelay.most_eps_reach;
  const double quartiles = ratios[3 * ratios.size() / 4] - ratios[ratios.size() / 4];
  return std::clamp(4.0 * kQuartilesToSigma * quartiles, kDelay.least_eps_reach, kDelay.most_eps_reach);
}

/// Where an impact without candidate is searched for, and what it must have to be accepted.
struct Prediction {
  std::int64_t impact = 0;
  double after_s = 0.0;  // from the last impact
  double reach_s = 0.0;
  double until_s = 0.0;        // sound from here on belongs to the next impact
  double min_llr_ratio = 0.0;  // log likelihood ratio over residual variance
};

/// Whether the template supports an impact about as loud as its neighbour.
/// @param n_lags         of the search that found it
/// @param min_llr_ratio  least log likelihood ratio over residual variance
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
         impact.fit.log_likelihood_ratio > min_llr_ratio * impact.fit.residual_variance;
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
  impact.probability = probability_of_inferred(
      impact.fit.log_likelihood_ratio / std::max(impact.fit.noise, impact.fit.residual_variance), n_lags);
  append(track, impact);
  return true;
}

}  // namespace

void append(TimedTrack& track, const TimedImpact& impact) {
  track.timer.subtract_from_later(impact.fit);
  track.impacts.push_back(impact);
}

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

void fill_gap(TimedTrack& track, std::int64_t next_impact, double next_s) {
  while (track.impacts.back().impact + 1 < next_impact) {
    const std::int64_t impact = track.impacts.back().impact + 1;
    const double last_s = track.impacts.back().fit.t_s;
    const double eps_reach = predicted_eps_reach(track.impacts);
    const auto search_after = [&](double after_s) {
      return search_missing(track, {impact, after_s, eps_reach * after_s, next_s, kDelay.least_in_gap});
    };
    // a geometric series of intervals of the predicted eps, that together take the time to the next candidate
    const double eps = predicted_eps(track.impacts), n = static_cast<double>(next_impact - impact);
    const double first_s = (next_s - last_s) * (1.0 - eps) / (1.0 - pow(eps, n + 1.0));
    const bool found = search_after(first_s) ||
                       // the next candidate may be late: a knock, an echo
                       (track.impacts.size() >= 3 && search_after(predict_next(track.impacts).t_s - last_s));
    if (!found) return;
  }
}

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

}  // namespace bouncelab::detection
