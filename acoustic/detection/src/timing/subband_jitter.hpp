// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// Jitter of each clock from how the readings of many impacts disagree, and how neighbours err together. No clock is
/// taken for much better than the others: one that the mean follows disagrees with nothing.
/// @param wave  that of the readings
void learn_jitter(const std::vector<ClockReading>& readings, const WaveTemplate& wave, BandClocks& clocks);

}  // namespace bouncelab::detection
