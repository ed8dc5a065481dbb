// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bouncelab/audio/audio_reader.hpp"

namespace bouncelab::detection {

/// Low-pass filter and decimation without delay: sample k lies at the time of sample k * factor of the source. A
/// Hann-windowed sinc of 16 factor + 1 taps: -6 dB at 0.8 of the new Nyquist frequency, below -40 dB above it. Sounds
/// of soft balls end below 1.5 kHz and are detected better without the noise above.
/// @param factor  >= 1
audio::AudioSource decimate(const audio::AudioSource& source, int factor);

}  // namespace bouncelab::detection
