// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// Where a wave may lie.
struct CorrelationPeak {
  double shift = 0.0;
  double log_likelihood_ratio = 0.0;  ///< log likelihood ratio against no impact, noise variance 1
};

/// Shifts from ... to, in steps of a half, at which the likelihood, maximised over a positive amplitude, has a
/// local maximum: the best first, then at most seven others in falling order.
std::vector<CorrelationPeak> find_correlation_peaks(const MatchedFilter& wave, const audio::Spectrum& sound,
                                                    double from, double to);

}  // namespace bouncelab::detection
