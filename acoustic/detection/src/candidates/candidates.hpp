// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/parallel.hpp"
#include "candidates/band_energies.hpp"
#include "candidates/candidate_model.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// A time at which the variance of the innovations rises: an impact, or another sound.
struct Candidate {
  double t_s = 0.0;                   ///< to about a sample
  double amplitude = 0.0;             ///< root of the energy added, in units of the standard deviation of the noise
  double reach_s = 0.0;               ///< how far off t_s may be: the window in which the rise was found
  double log_likelihood_ratio = 0.0;  ///< rise against no rise
};

/// The LLR of a candidate beyond the threshold.
inline double rise(const Candidate& candidate) { return candidate.log_likelihood_ratio - kCandidates.threshold; }

/// The candidates of a recording in time order, and the energies of the sound around each: both from the one time that
/// the recording is read.
struct CandidatesOfSound {
  std::vector<Candidate> candidates;
  std::vector<BandEnergies> band_energies;  ///< of each candidate
};

/// Finds them.
///
/// Statistic: the generalised likelihood ratio of "variance s2 from sample n on, s1 before" against one variance, for
/// Gaussian innovations,
///
///   LLR = (n1 + n2)/2 ln s^2 - n1/2 ln s1^2 - n2/2 ln s2^2,
///
/// in windows of 3, 12 and 48 hops after n and three times that before, and its local maxima within four hops. A hop is
/// 0.125 ms but at least one sample: windows of 0.4, 1.5 and 6 ms in a full band, of 0.75, 3 and 12 ms at a rate of 4
/// kHz, of 3, 12 and 48 ms at 1 kHz. A longer window gives candidates only where no shorter one has. Under noise alone
/// 2 LLR is chi-squared with one degree of freedom; the threshold LLR > 8 lets through about one false candidate in 3
/// s. The background is the sound just before, so that a weak impact counts as much in silence as on the tail of a
/// strong one.
/// @param sound      may be read by several threads where n_threads is not 1
/// @param model      of the sound, from learn_ar_models; no candidates where its quiet variance is 0
/// @param n_threads  they take blocks of a second; the candidates do not depend on it
/// Source: Sleeman & van Eck, Phys. Earth Planet. Inter. 113, 265 (1999), doi:10.1016/S0031-9201(99)00007-2
CandidatesOfSound find_candidates(const audio::AudioSource& sound, const ArModel& model, int n_threads,
                                  const ProgressCallback& progress);

}  // namespace bouncelab::detection
