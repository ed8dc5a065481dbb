// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bouncelab/detection/detect.hpp"
#include "candidates/candidates.hpp"
#include "template/subband_delay.hpp"
#include "whitening/linear_prediction.hpp"
#include "whitening/white_window.hpp"

namespace bouncelab::detection {

/// The matched-filter template of a recording's impacts, whitened by the noise. Windows begin at a sample of the
/// recording; positions within them count from there.
struct ImpactTemplate {
  std::vector<float> whitener;  ///< filter that makes the noise white with variance 1
  MatchedFilter filter;
  Subbands subbands;
  std::size_t n_template = 0;        ///< samples from the window's first after which the template is 0
  double contact_index = 0.0;        ///< start of contact, in samples from the window's first
  double n_effective = 0.0;          ///< samples that hold its energy, 3 (sum w^2)^2 / sum w^4: all of them in noise
  double correlation = 0.0;          ///< median of the training impacts with the template
  std::vector<double> training_t_s;  ///< times of the impacts that it is the mean of
  double training_weight = 0.0;      ///< sum of their squared amplitudes, in units of the template
  LearnedWave wave;                  ///< the mean as recorded, not whitened
  double peak = 0.0;                 ///< its largest magnitude
};

/// Estimates the template from the recording's own strong impacts: aligned below a sample and averaged,
/// in turns; then the noise and the jitter of its sub-bands.
/// @param white    what of it was whitened by the result's whitener is kept for what follows
/// @param impacts  with times to a millisecond or better, in time order
/// @param clipped  for each whether the recording is at its limit there; such impacts are used only where fewer than
///                 five others are
/// @return absent where no three impacts are alike
std::optional<ImpactTemplate> estimate_template(WhiteSound& white, const ArModel& noise,
                                                const std::vector<Candidate>& impacts,
                                                const std::vector<bool>& clipped);

/// Whether a template of this correlation with the impacts explains half of their energy: then what it does not support
/// is none.
inline bool is_reliable(double correlation) { return correlation > 0.7; }

/// Share of an impact's sound that the template explains, as a correlation 0 ... 1.
/// @param total  sum of squares of the window
double correlation(const DelayEstimate& estimate, double total);

/// Root mean square frequency of the impacts as recorded [cycles per sample], of what they have in common: that of the
/// template with the whitener's gain taken off. Background that the impacts do not share, hum and rumble, has no part
/// in it. At least 1e-6.
double recorded_rms_frequency(const ImpactTemplate& learned);

}  // namespace bouncelab::detection
