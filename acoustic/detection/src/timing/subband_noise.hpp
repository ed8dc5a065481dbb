// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_source.hpp"
#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// Sets each subband's noise: the variance in each real and imaginary part, averaged over the subband's bins as its
/// time weighs them, by omega^2 |wave|^2. (A plain mean is wrong where the whitened noise is not flat within a band,
/// and it is not where the whitener has learned the modes too: it is quiet just where the wave is loud.) From the
/// quieter half of the windows that end where impacts begin; in the others something still rings.
/// @return  sum of squares of such a window, averaged
/// @param begins  samples at which the windows of impacts begin, not empty
double estimate_noise(const audio::AudioSource& sound, const std::vector<float>& whitener,
                      const std::vector<std::int64_t>& begins, const MatchedFilter& wave, Subbands& subbands);

}  // namespace bouncelab::detection
