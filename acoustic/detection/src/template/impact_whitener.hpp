// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// Filter that whitens what disturbs an impact: the background noise, a share of the impact's own power at each
/// frequency, which is different each time, and kTemplate.floor of its mean at all. Where a codec left nothing in the
/// background, the noise alone would make the codec's own errors, which it lets sound with the impacts only, the best
/// known part of them. With variance 1.
/// @param noise       its quiet variance may be 0 (digital silence)
/// @param begins      of windows with one impact each, samples of the recording; not empty
/// @param n_window    samples of such a window, a power of two
/// @param unrepeated  that share; 0 where the residuals show it
std::vector<float> impact_whitener(const audio::AudioSource& sound, const ArModel& noise,
                                   const std::vector<std::int64_t>& begins, std::size_t n_window, double unrepeated);

}  // namespace bouncelab::detection
