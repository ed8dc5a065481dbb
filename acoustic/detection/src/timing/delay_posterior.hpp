// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "timing/timed_impact.hpp"

namespace bouncelab::detection {

/// Hypotheses of one impact's time: 0 is its fit's, k > 0 its fit's alternatives[k - 1].
std::size_t n_hypotheses(const TimedImpact& impact);

/// Time of a hypothesis [s].
double hypothesis_time(const TimedImpact& impact, std::size_t hypothesis);

/// Probability of each hypothesis of one impact; the sum is 1.
using HypothesisProbabilities = std::vector<double>;

/// Where ln eps of an impact is expected, and how far it scatters; width 0 = not known.
struct ExpectedLogEps {
  double centre = 0.0;
  double width = 0.0;
};

/// From the track itself: the median of ln(T_{k+1}/T_k) over the impacts around, and their median deviation from it.
/// @param t_s  the time of each impact
std::vector<ExpectedLogEps> expected_log_eps(const std::vector<TimedImpact>& track, const std::vector<double>& t_s);

/// Posterior probabilities of the hypotheses of a chain of impacts: the sound speaks for each time by its log odds
/// margin, and ln(T_{k+1}/T_k) scatters about what is expected like Student's t with four degrees of freedom. By the
/// forward-backward algorithm over pairs of neighbours.
/// @param track      at least two impacts, in time order
/// @param far_share  of the impacts that are further from where the sound rises than that is uncertain, 0 ... 1
/// Source: Rabiner, Proc. IEEE 77, 257 (1989), doi:10.1109/5.18626
std::vector<HypothesisProbabilities> chain_posterior(const std::vector<TimedImpact>& track,
                                                     const std::vector<ExpectedLogEps>& expected, double far_share);

/// The same with what is expected and the share of far impacts estimated from the track, in three rounds: first from
/// the fits' times, then from the most probable ones. Tracks of fewer than seven impacts have no ln eps to expect: the
/// sound and its rise alone decide.
std::vector<HypothesisProbabilities> delay_posterior(const std::vector<TimedImpact>& track);

}  // namespace bouncelab::detection
