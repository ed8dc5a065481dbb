// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "timing/timed_impact.hpp"

namespace bouncelab::detection {

/// The time chosen for one impact: hypothesis 0 is its fit's, hypothesis k > 0 its fit's alternatives[k - 1].
struct CycleChoice {
  std::size_t hypothesis = 0;
  std::vector<double> log_odds_margin;  ///< of the chosen against each hypothesis, by sound and track together
};

/// Time of a hypothesis [s].
double hypothesis_time(const TimedImpact& impact, std::size_t hypothesis);

/// Resolves cycle slips by the smoothness of the track: ln(T_{k+1}/T_k) scatters about the median of its neighbours
/// like Student's t with four degrees of freedom, its width estimated from the track. The most probable sequence of
/// hypotheses by Viterbi's algorithm over pairs of neighbours; each margin holds with the neighbours as chosen. Tracks
/// of fewer than seven impacts keep the times of their fits.
/// @return one choice an impact
/// Source: Viterbi, IEEE Trans. Inf. Theory 13, 260 (1967), doi:10.1109/TIT.1967.1054010
std::vector<CycleChoice> resolve_cycle_slips(const std::vector<TimedImpact>& track);

}  // namespace bouncelab::detection
