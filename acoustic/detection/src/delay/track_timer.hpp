// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "candidates/candidates.hpp"
#include "delay/impact_timer.hpp"
#include "delay/timed_impact.hpp"
#include "template/impact_template.hpp"
#include "tracking/tracker.hpp"

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

/// Where impacts are against the rises of their sound: Student's t with four degrees of freedom about a constant delay,
/// or anywhere within 27 ms, behind a codec's noise before the attack, at an echo, in front of a louder sound.
struct RisePrior {
  double far_share = 0.1;  ///< of the impacts that are anywhere, 0 ... 1
  double late_s = 0.0;     ///< of the impact behind its rise
  double width = 0.25;     ///< of the density about that, over the reach of the rise
};

/// Posterior probabilities of the hypotheses of a chain of impacts: the sound speaks for each time by its log odds
/// margin, and ln(T_{k+1}/T_k) scatters about what is expected like Student's t with four degrees of freedom. By the
/// forward-backward algorithm over pairs of neighbours.
/// @param track  at least two impacts, in time order
/// Source: Rabiner, Proc. IEEE 77, 257 (1989), doi:10.1109/5.18626
std::vector<HypothesisProbabilities> chain_posterior(const std::vector<TimedImpact>& track,
                                                     const std::vector<ExpectedLogEps>& expected,
                                                     const RisePrior& prior);

/// The same with what is expected and where impacts are against their rises estimated from the track, in three rounds:
/// first from the fits' times, then from the most probable ones. Tracks of fewer than seven impacts have no ln eps to
/// expect: the sound and its rise alone decide.
std::vector<HypothesisProbabilities> delay_posterior(const std::vector<TimedImpact>& track);

/// The most probable hypothesis.
std::size_t most_probable(const HypothesisProbabilities& p);

/// What the other hypotheses say of the chosen time: that it is doubtful, less probable, and less sure.
/// @param impact  timed anew by the chosen hypothesis
void set_doubt(const TimedImpact& hypotheses, const HypothesisProbabilities& p, std::size_t chosen,
               TimedImpact& impact);

/// The better of two fits of one impact, with the places of both as hypotheses: each place once, the most likely first.
/// @param same_s  places nearer than this are one
ImpactFit merged(const ImpactFit& a, const ImpactFit& b, double same_s);

/// The fit with its three most likely alternatives only.
ImpactFit with_fewer_places(ImpactFit fit);

/// Times the impacts of one track with the template, in this order:
///
/// 1. each candidate, in time order, the ringing of the impacts before it subtracted; where impacts are missing between
///    two candidates they are searched for at the times that a geometric series of intervals predicts (fill_gap);
/// 2. the track is continued beyond its last impact as long as the sound supports the next one (extend);
/// 3. of the places where each impact may have been the most probable is chosen (delay_posterior); the others'
///    probabilities add to its variance.
///
/// @param end_s  the next track, or the end of the recording: impacts are searched for up to it [s]
std::vector<TimedImpact> time_track(WhiteSound& white, const ImpactTemplate& learned, const Track& track,
                                    const std::vector<Candidate>& candidates, double end_s);

}  // namespace bouncelab::detection
