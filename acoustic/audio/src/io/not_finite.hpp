// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>

namespace bouncelab::audio {

/// Index of the first sample that is infinite or no number, or how many samples there are.
std::size_t first_not_finite(std::span<const float> samples);

}  // namespace bouncelab::audio
