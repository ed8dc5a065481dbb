// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of the impacts along a track: those that are missing, and the places where each may have been
/// (docs/detector.md, "Times").
struct DelayModel {
  double unambiguous = 15.0;         ///< log odds from which the sound alone decides between two times
  double least_interval_s = 1.2e-3;  ///< impacts that follow nearer are not told apart

  // where the next impact is expected
  double eps_reach = 0.06;            ///< of eps about the expected one: four times TrackingModel::scatter
  std::size_t anchors = 3;            ///< last impacts that predict one beyond the end: one may be in a wrong place
  double most_amplitude_ratio = 3.5;  ///< between neighbours; eps and the place struck explain up to two
  // beyond the end a single loss or gain may be the reason why the tracker has none: 0.73 to 1.17 of the interval
  double outlier_centre = 0.95;
  double outlier_reach = 0.22;

  // what is found there: log likelihood ratio over ImpactFit::rest; one between two impacts needs less than one beyond
  // the end
  double least_in_gap = 2.0;
  double least_of_outlier = 6.0;
  double fewest_cycles = 3.0;  ///< of the template; nearer impacts cannot be separated from its ringing

  // the places of an impact
  double late_s = 6e-3;                ///< of a candidate behind its impact: the longest window of the candidates
  double pre_echo_s = 21.4e-3;         ///< of a candidate before its impact: a block of 1024 samples at 48 kHz
  double far_s = late_s + pre_echo_s;  ///< over which an impact may lie that is not where the sound rises
  double most_explained = 0.9;         ///< share of the energy of its window: whatever is left, that is the impact
  double much_left = 1.25;             ///< of the expected residual: then the impact may be at another place
  double of_template = 0.75;           ///< that is judged where a window has no end: the rest is hardly above noise
  double search_share = 0.25;          ///< of the intervals on either side, over which an impact may be searched for
  double least_doubt = 1e-2;           ///< probability of other times from which an impact is flagged doubtful

  // the posterior of the places: how even a track is, and where impacts are against the rises of their sound
  std::size_t fewest_impacts = 7;  ///< that show either
  std::size_t neighbours = 7;      ///< on either side, whose median is expected of ln eps
  std::size_t scatter_reach = 15;  ///< on either side, for its width
  double least_scatter = 2e-4;     ///< of ln eps; smoother than any ball
  double rise_weight = 10.0;       ///< of the prior share of far impacts and of the width of the others, in impacts
  double least_width = 0.1;        ///< of the reach; rises are known to a hop, a third of the shortest window
};

BOUNCELAB_MODEL DelayModel kDelay;

/// Another time at which an impact may have been: a lower peak of its likelihood.
struct DelayHypothesis {
  double t_s = 0.0;
  double log_odds_margin = 0.0;  ///< log odds of the most likely time against this one, by the sound alone, >= 0
};

/// One impact by maximum likelihood, from a window of whitened sound.
struct ImpactFit {
  double t_s = 0.0;
  double sigma_s = 0.0;
  double amplitude = 0.0;                     ///< in units of the template
  double log_likelihood_ratio = 0.0;          ///< against no impact there, noise variance 1
  double residual_variance = 0.0;             ///< mean square of what the template does not explain, noise = 1
  double rest = 0.0;                          ///< the same, or at the template's frequencies where that is more
  double disturbance = 1.0;                   ///< variance of noise and unexplained sound where the template is
  double noise = 1.0;                         ///< residual noise variance after whitening (1 if perfect); at least 1
  double correlation = 0.0;                   ///< of the sound with the template, 0 ... 1
  std::vector<DelayHypothesis> alternatives;  ///< other times with a margin below kDelay.unambiguous
};

/// One impact of a track, timed.
struct TimedImpact {
  std::int64_t impact = 0;
  ImpactFit fit;
  double rise_s = 0.0;        ///< time of its candidate
  double rise_reach_s = 0.0;  ///< how far off that may be where nothing sounds before the impact; 0 = no candidate
  double until_s = 0.0;       ///< from here on the sound belongs to the next impact
  bool inferred = false;      ///< no candidate: found where the track predicts it
  bool overlap = false;       ///< its sound reaches into that of the next
  bool doubtful = false;      ///< may have been at another place
  double doubt_s = 0.0;       ///< what that adds to the standard error, in quadrature
  double probability = 1.0;   ///< that it is one of the ball's, given that the track is a ball's
  bool clipped = false;       ///< the recording is at its limit within 5 ms
  double v_mps = 0.0;         ///< from the flight before it (of the first: after it, over eps); 0 = not known
};

}  // namespace bouncelab::detection
