// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/track_search.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "delay/delay_model.hpp"

namespace bouncelab::detection {
namespace {

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

}  // namespace

void append(TimedTrack& track, const TimedImpact& impact) {
  track.search.timer.subtract_from_later(impact.fit);
  track.impacts.push_back(impact);
}

ImpactFit find_impact(Search& search, double t_s, double reach_s, double until_s) {
  const double step_s = search_step_s(search);
  ImpactFit best = search.timer.time(t_s, reach_s, until_s);
  if (reach_s < step_s) return best;
  for (double from_s = t_s - reach_s; from_s < t_s + reach_s; from_s += step_s) {
    ImpactFit fit = search.timer.time(from_s, step_s, until_s);
    if (fit.log_likelihood_ratio > best.log_likelihood_ratio && std::abs(fit.t_s - t_s) <= reach_s)
      best = std::move(fit);
  }
  return best;
}

double search_step_s(const Search& search) { return 0.25 * search.template_s; }

double predicted_eps(const TimedImpacts& track) {
  const std::vector<double> ratios = last_ratios(track);
  // at most 0.999, so that a geometric series of it has a finite sum
  return ratios.empty() ? kDelay.default_eps : std::clamp(ratios[ratios.size() / 2], 0.3, 0.999);
}

double predicted_eps_reach(const TimedImpacts& track) {
  constexpr double kQuartilesToSigma = 0.74;  // the quartiles of a normal distribution are 1.35 sigma apart
  const std::vector<double> ratios = last_ratios(track);
  if (ratios.size() < kDelay.fewest_ratios) return kDelay.most_eps_reach;
  const double quartiles = ratios[3 * ratios.size() / 4] - ratios[ratios.size() / 4];
  return std::clamp(4.0 * kQuartilesToSigma * quartiles, kDelay.least_eps_reach, kDelay.most_eps_reach);
}

PredictedImpact predict_beyond_end(const TimedImpacts& track, int n_left_out) {
  const double eps = predicted_eps(track);
  const std::int64_t next = track.back().impact + 1 + n_left_out;
  std::vector<PredictedImpact> predicted;
  for (std::size_t back = 1; back <= kDelay.anchors && back < track.size(); ++back) {
    const std::size_t k = track.size() - back;
    PredictedImpact p{track[k].fit.t_s, flight_before(track, k, eps), 0.0};
    for (std::int64_t impact = track[k].impact; impact < next; ++impact) p.t_s += p.flight_s *= eps;
    predicted.push_back(p);
  }
  std::sort(predicted.begin(), predicted.end(),
            [](const PredictedImpact& a, const PredictedImpact& b) { return a.t_s < b.t_s; });
  PredictedImpact median = predicted[predicted.size() / 2];
  median.spread_s = std::max(predicted.back().t_s - median.t_s, median.t_s - predicted.front().t_s);
  return median;
}

double first_of_missing(const TimedImpacts& track, double n_missing, double total_s) {
  const double eps = predicted_eps(track);
  return total_s * (1.0 - eps) / (1.0 - pow(eps, n_missing + 1.0));
}

}  // namespace bouncelab::detection
