// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace bouncelab::detection {

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
