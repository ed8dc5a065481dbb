// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/audio/audio_source.hpp"

namespace bouncelab::audio {

/// The lower part of a sound's band at an n-th of its rate, without delay: sample k lies at the time of sample k *
/// factor. A Hann-windowed sinc of 16 factor + 1 taps: -6 dB at 0.8 of the new Nyquist frequency, below -40 dB above
/// it. Soft balls, whose sound ends below 1.5 kHz, are heard better without the noise above.
/// @param factor  >= 1
AudioSource decimate(const AudioSource& source, int factor);

}  // namespace bouncelab::audio
