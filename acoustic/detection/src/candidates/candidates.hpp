// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "bouncelab/audio/dsp/linear_prediction.hpp"
#include "bouncelab/core/progress.hpp"

namespace bouncelab::detection {

/// A moment at which the innovations become louder than they were: an impact, or something like it.
struct Candidate {
  double t_s = 0.0;                   ///< to about a sample
  double amplitude = 0.0;             ///< root of the energy that came in addition, in units of the noise's innovations
  double reach_s = 0.0;               ///< how far off t_s may be: the window in which the rise was noticed
  double log_likelihood_ratio = 0.0;  ///< rise against no rise
};

/// Candidates in time order.
///
/// Statistic: the likelihood ratio of "variance s2 after n, s1 before" against one variance, for Gaussian innovations,
/// in windows of 0.4, 1.5 and 6 ms after n and three times that before; local maxima within 0.5 ms. Under noise alone
/// twice the ratio is chi-squared with one degree of freedom; the threshold lets through about one false candidate in 3
/// s. The background is what rings just before, so that a weak impact counts as much on silence as on the tail of a
/// strong one.
std::vector<Candidate> find_candidates(const audio::AudioSource& sound, const audio::ArModel& model,
                                       const ProgressCallback& progress);

}  // namespace bouncelab::detection
