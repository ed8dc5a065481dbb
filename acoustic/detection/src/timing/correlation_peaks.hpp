// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// A local maximum of the cross-correlation of a sound with the template.
struct CorrelationPeak {
  double shift = 0.0;                 ///< of the template within the window [samples]
  double log_likelihood_ratio = 0.0;  ///< of an impact there against none, noise variance 1
};

/// Local maxima of the cross-correlation for shifts in [from, to], step 0.5 sample: the highest first, then at most
/// seven others in falling order. The likelihood is maximised over a positive amplitude,
/// LLR(s) = max(0, r(s))^2 / (2 E), E the energy of the template.
std::vector<CorrelationPeak> find_correlation_peaks(const MatchedFilter& filter, const audio::Spectrum& sound,
                                                    double from, double to);

}  // namespace bouncelab::detection
