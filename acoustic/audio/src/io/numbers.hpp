// SPDX-License-Identifier: GPL-3.0-or-later
// Samples as numbers: NumPy's .npy, tables of text.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>

#include "io/coded_sound.hpp"
#include "io/sound_bytes.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {

bool is_npy(SoundBytes& bytes);

/// Samples that NumPy saved (numpy.save, format versions 1 to 3): one dimension, or samples x channels in C order, of
/// int16 (full scale = 32768), float32 or float64 (full scale = 1), little-endian.
/// @param rate_hz  sampling rate, which the format does not hold
/// @throws FileError naming the remedy: another type, order or shape, cut off, no rate given
/// Source: numpy.lib.format, https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
PlainSound npy_sound(SoundBytes& bytes, const std::string& name, std::optional<double> rate_hz);

/// Whether a file may be a table: no control characters in its first bytes.
bool is_text(SoundBytes& bytes);

/// The step of the first column of such a table, where that is a time [s]; read from its first rows.
/// @throws FileError where these are no numbers
std::optional<double> step_of_number_text(std::istream& in);

/// Samples as a table of text, as phyphox and oscilloscopes export them: columns by tab, semicolon, comma or blanks;
/// decimal point, or decimal comma where the comma does not separate; lines in front that are no numbers (titles,
/// units), empty ones and those that begin with # are passed over.
///
/// A first column whose title has a unit of time, or that grows by equal steps, gives the sampling
/// rate; one that counts 0, 1, 2 ... is passed over. Every other column is a channel, full scale = 1.
/// @param in       the table's text, read to its end. @param name  for messages
/// @param rate_hz  of a table without times
/// @throws FileError naming the line: no numbers, another number of cells, times that are not uniform, neither times
///         nor rate; InvalidArgument where there are both
SoundInfo read_number_text(std::istream& in, const std::string& name, std::optional<double> rate_hz,
                           DecodedSamples& samples);

}  // namespace bouncelab::audio
