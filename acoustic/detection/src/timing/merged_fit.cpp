// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/merged_fit.hpp"

#include <algorithm>
#include <cmath>

#include "timing/impact_timer.hpp"

namespace bouncelab::detection {

ImpactFit merged(const ImpactFit& a, const ImpactFit& b, double same_s) {
  const bool a_is_better = a.log_likelihood_ratio >= b.log_likelihood_ratio;
  ImpactFit best = a_is_better ? a : b;
  const ImpactFit& other = a_is_better ? b : a;
  const double margin = log_odds_margin(best.log_likelihood_ratio, other.log_likelihood_ratio, best.disturbance);
  const auto add = [&](double t_s, double log_odds_margin) {
    const auto is_there = [&](const DelayHypothesis& h) { return std::abs(h.t_s - t_s) < same_s; };
    if (log_odds_margin >= kUnambiguousLogOdds || std::abs(best.t_s - t_s) < same_s ||
        std::any_of(best.alternatives.begin(), best.alternatives.end(), is_there))
      return;
    best.alternatives.push_back({t_s, log_odds_margin});
  };
  add(other.t_s, margin);
  for (const DelayHypothesis& h : other.alternatives)
    add(h.t_s, margin + h.log_odds_margin * other.disturbance / best.disturbance);
  std::sort(best.alternatives.begin(), best.alternatives.end(),
            [](const DelayHypothesis& x, const DelayHypothesis& y) { return x.log_odds_margin < y.log_odds_margin; });
  return best;
}

ImpactFit with_fewer_places(ImpactFit fit) {
  constexpr std::size_t kMost = 3;  // two fits have eight places then, whose trellis takes little time
  if (fit.alternatives.size() > kMost) fit.alternatives.resize(kMost);
  return fit;
}

}  // namespace bouncelab::detection
