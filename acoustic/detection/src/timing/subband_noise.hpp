// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

#include "bouncelab/audio/dsp/white_window.hpp"
#include "timing/subband_delay.hpp"

namespace bouncelab::detection {

/// Sets each sub-band's noise: the variance in each real and imaginary part, averaged over its bins with the weights
/// omega^2 |W|^2 that the delay gives them. (A plain mean is wrong where the whitened noise is not flat within a
/// sub-band; and it is not flat where the whitener has modelled the modes too: it is low just where the template is
/// strong.) Estimated from the quieter half of the windows that end where impacts begin; in the others an earlier
/// impact still rings.
/// @return  sum of squares of such a window, averaged
/// @param begins  samples at which the windows of impacts begin, not empty
double estimate_noise(audio::WhiteSound& sound, const std::vector<float>& whitener,
                      const std::vector<std::int64_t>& begins, const MatchedFilter& filter, Subbands& subbands);

}  // namespace bouncelab::detection
