// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// Jitter of each subband from how the readings of many impacts disagree, and how neighbours err together. No subband
/// is taken for much better than the others: one that the mean follows disagrees with nothing.
/// @param wave  that of the readings
void estimate_jitter(const std::vector<DelayEstimate>& readings, const MatchedFilter& wave, Subbands& subbands);

}  // namespace bouncelab::detection
