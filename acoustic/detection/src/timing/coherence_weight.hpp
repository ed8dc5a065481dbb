// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {

/// Share of the power of a mean that its two halves have in common, by bin, over the 17 bins around: 1 where they
/// agree, 0 where the mean is noise. What Wiener's filter would multiply it by, but for shares below 0.3, which noise
/// reaches by chance; they count as 0, and those above are stretched to make up for it.
/// @param a, b    sums of weighted spectra, over one half of the recordings each
/// @param weight_a, weight_b  sums of the squared weights; positive
/// Source: Wiener 1949; Bendat & Piersol, Random Data (2010), 6.1 (coherence).
std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b);

}  // namespace bouncelab::detection
