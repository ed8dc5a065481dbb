// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "model_number.hpp"

namespace bouncelab::detection {

/// The numbers of the template and of the delays of one impact by it (docs/detector.md, "Times").
struct TemplateModel {
  // which impacts it is the mean of, and how long it is
  double short_s = 15e-3;
  double long_s = 40e-3;   ///< where impacts follow closely, whose tails matter
  double close_s = 20e-3;  ///< intervals that are close
  std::size_t many_close = 20;
  std::size_t many_far = 12;            ///< impacts whose tails nothing disturbs, that a long template needs
  std::size_t most_training = 32;       ///< what more of them add to the template is less than their own variation
  std::ptrdiff_t fewest_unclipped = 5;  ///< with fewer, clipped ones are used too
  double lead_s = 0.5e-3;               ///< quiet part of a window before the rough time
  double rough_time_error_s = 1e-3;     ///< of the candidates
  double taper_s = 2e-3;                ///< at the template's end
  double least_correlation = 0.5;       ///< with the template, from which an impact is averaged
  double recut_samples = 8.0;           ///< from the middle of its window, from which an impact gets a window anew
  double attack_share = 0.2;            ///< of the energy of a window, which has come at an attack
  std::size_t most_starts = 5;          ///< impacts from which a template is tried
  float onset_of_peak = 0.1F;           ///< a plate's first motion is above, noise and a converter's pre-ringing below

  // what disturbs an impact
  /// Share of an impact's power that is different each time, before the residuals show how much it is: that of modes
  /// whose amplitudes scatter by a tenth, and of a codec's errors where they are just masked.
  double unrepeated = 1e-2;
  /// Of the impacts' mean spectral density, which counts as noise at all frequencies: what is 70 dB below it is the
  /// work of codecs and converters, and no sound.
  double floor = 1e-7;
  std::size_t residual_order = 32;       ///< of the prediction that whitens the residuals
  std::size_t fewest_for_coherence = 4;  ///< impacts; with fewer, halves are too noisy to be compared
  std::size_t coherence_bins = 8;        ///< on either side, over which it is smoothed
  double coherence_of_noise = 0.5;       ///< what 17 bins of noise reach at one and a half standard deviations

  // sub-bands
  std::size_t fewest_bins = 6;            ///< of one: three to four of what a window of this length resolves
  double least_information_share = 0.25;  ///< of the mean information of a sub-band; less is merged
  std::size_t edge_search_share = 20;     ///< an edge is looked for within 1/20 of the occupied bins
  double amplitude_prior = 10.0;          ///< weight of the common amplitude in one, as a signal-to-noise ratio
  /// Prior of chi2 of the delays' disagreement, as of so many sub-bands that agree: eleven differences alone give their
  /// scatter to 20 % only.
  double prior_subbands = 8.0;
  std::size_t fewest_subbands = 2;  ///< whose disagreement gives the jitter
  /// Least share of its variance that a sub-band's deviations from the mean keep: a mean that rests on one sub-band
  /// alone follows it altogether.
  double least_residual_share = 0.2;
  double least_of_median = 0.5;  ///< phase variance of a sub-band over the median one
  double prior_impacts = 4.0;    ///< weight of the median phase variance, in impacts
  double most_of_one = 9.0;      ///< square of a deviation in standard deviations: robust against disturbed impacts
};

BOUNCELAB_MODEL TemplateModel kTemplate;

}  // namespace bouncelab::detection
