// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "io/sound_bytes.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

bool is_npy(SoundBytes& bytes);

/// Samples that NumPy saved (numpy.save, format versions 1 to 3): one dimension, or samples x channels in C order, of
/// int16 (full scale = 32768), float32 or float64 (full scale = 1), little-endian.
/// @param rate_hz  sampling rate, which the format does not hold
/// @throws FileError naming the remedy: another type, order or shape, cut off, no rate given
/// Source: numpy.lib.format, https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
SoundInfo npy_info(SoundBytes& bytes, const std::string& name, std::optional<double> rate_hz);

}  // namespace bouncelab::audio
