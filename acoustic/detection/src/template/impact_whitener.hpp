// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bouncelab/audio/audio_reader.hpp"
#include "whitening/linear_prediction.hpp"

namespace bouncelab::detection {

/// Filter that makes the noise white with variance 1.
/// @param noise  its quiet variance is positive
std::vector<float> noise_whitener(const ArModel& noise);

/// Filter that whitens what disturbs an impact whose template is not known yet: the background noise and, everywhere
/// in its spectrum, a hundredth of its own power, which is different each time. Where a codec left nothing in the
/// background, the noise alone would make the codec's own errors, which it lets sound with the impacts only, the best
/// known part of them. With variance 1.
/// @param noise     its quiet variance may be 0 (digital silence)
/// @param begins    of windows with one impact each, samples of the recording; not empty
/// @param n_window  samples of such a window, a power of two
std::vector<float> impact_whitener(const audio::AudioSource& sound, const ArModel& noise,
                                   const std::vector<std::int64_t>& begins, std::size_t n_window);

}  // namespace bouncelab::detection
