// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/track_search.hpp"

#include <cmath>
#include <optional>
#include <utility>

namespace bouncelab::detection {

void append(TimedTrack& track, const TimedImpact& impact) {
  track.search.timer.subtract_from_later(impact.fit);
  track.impacts.push_back(impact);
}

ImpactFit find_impact(Search& search, double t_s, double reach_s, double until_s) {
  const double step_s = search_step_s(search);
  ImpactFit best = search.timer.time(t_s, reach_s, until_s);
  if (reach_s < step_s) return best;
  for (double from_s = t_s - reach_s; from_s < t_s + reach_s; from_s += step_s) {
    std::optional<ImpactFit> here = search.timer.time_if_over(best.log_likelihood_ratio, from_s, step_s, until_s);
    if (here && here->log_likelihood_ratio > best.log_likelihood_ratio && std::abs(here->t_s - t_s) <= reach_s)
      best = *std::move(here);
  }
  return best;
}

double search_step_s(const Search& search) { return 0.25 * search.template_s; }

}  // namespace bouncelab::detection
