// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/audio/audio_source.hpp"

namespace bouncelab::detection {

/// The limit that a recording reaches within 5 ms after t_s: three successive samples of the same value, the largest in
/// magnitude there. Infinity where it does not.
float clip_level(const audio::AudioSource& sound, double t_s);

}  // namespace bouncelab::detection
