// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// Sets the jitter variance of each sub-band and the correlation of neighbours' jitter, by variance components: the
/// squared deviations from the mean, corrected for what the mean follows, minus those that noise explains. Each jitter
/// is shrunk towards the median phase variance of all sub-bands, since the deviations of one that dominates the mean
/// are small whatever its jitter. Leaves all as it is with fewer than three estimates or two sub-bands.
/// @param estimates  of many impacts of one recording
/// @param filter     that of the estimates
void estimate_jitter(const std::vector<DelayEstimate>& estimates, const MatchedFilter& filter, Subbands& subbands);

}  // namespace bouncelab::detection
