// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "tracking/observations.hpp"
#include "tracking/tracker.hpp"

namespace bouncelab::detection {

/// Sets the probability of each impact of a track to be one of the ball's, given that the track is that of a ball.
///
/// The track is weighed against its nearest others, each by the score of a hypothesis (hypothesis.hpp) over the few
/// impacts in which the two differ:
///
/// - without the impact, which then is clutter, while the ball's own was not detected;
/// - with another candidate in its place;
/// - ended before it; begun after it.
///
///   p = sum of the weights of those with the impact / sum of all weights
void set_impact_probabilities(const Observations& observations, Track& track);

/// Probability of an impact found where its track predicts one, from its significance. There either is an impact, whose
/// log likelihood ratio may be any, or the largest of n_places squared normals is taken for one, odds of exp(LLR) /
/// n_places, or another sound that no candidate stands for, at odds of kTracking.other_sound.
/// @param llr       over the variance of noise and unexplained sound there
/// @param n_places  independent ones of the search, > 0
double probability_of_inferred(double llr, double n_places);

/// Whether there is a candidate within its reach of a time. An inferred impact there has the probability
/// kTracking.refused: the candidate was weighed in the search for tracks, and left out.
bool is_at_candidate(const std::vector<Candidate>& candidates, double t_s);

/// p(a mark is an impact of this ball) = p(track) p(impact | track), to six decimals.
/// @param log_odds  of the track
double probability_of_mark(double log_odds, double of_impact);

}  // namespace bouncelab::detection
