// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {

/// Coherence (Wiener) weight of a mean, by bin: the share c of its power that two halves of the data have in common,
/// over the 17 bins around. 1 where the halves agree, 0 where the mean is noise. Shares below 0.5, which noise reaches
/// by chance, count as 0, and those above are rescaled: (c - 0.5) / (1 - 0.5), limited to 0 ... 1.
/// @param a, b    sums of weighted spectra, over one half of the impacts each
/// @param weight_a, weight_b  sums of the squared weights; positive
/// Source: Wiener 1949; Bendat & Piersol, Random Data (2010), 6.1 (coherence).
std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b);

}  // namespace bouncelab::detection
