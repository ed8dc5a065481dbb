// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace bouncelab::web {

/// A recording in memory; samples interleaved, full scale = 1.
struct Sound {
  std::vector<float> samples;
  double rate_hz = 0.0;
  int n_channels = 0;
  std::string name, format, lossy_coding;
  std::vector<std::string> warnings;
};

/// Of a file in the page's file system, by the reader of the command line; no ffmpeg. @throws FileError
Sound read_recording(const std::string& file);
/// The same of a file's bytes.
Sound read_sound(const std::string& bytes, const std::string& name);

/// A WAV file of 32-bit floats: the samples as they are.
/// @throws InvalidArgument where rate or number of channels are none of a recording
void write_sound(const std::filesystem::path& path, const Sound& sound);
/// Its bytes.
std::string wav_of(const Sound& sound);

}  // namespace bouncelab::web
