// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace bouncelab::web {

// The page's file system, which lies in memory: the commands of the command line read and write there.

/// An empty folder that is the working folder while this lives, and is removed with all in it.
class WorkingFolder {
 public:
  WorkingFolder();
  WorkingFolder(const WorkingFolder&) = delete;
  WorkingFolder& operator=(const WorkingFolder&) = delete;
  ~WorkingFolder();
};

/// The last part of a recording's name, which is its name in the working folder; "recording" where there is none.
std::string file_name(const std::string& name);

/// @throws FileError
void write_file(const std::filesystem::path& path, std::string_view bytes);
/// Empty where there is no such file.
std::string read_file(const std::filesystem::path& path);

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

/// The bytes of a WAV file of 32-bit floats: the samples as they are.
/// @throws InvalidArgument where rate or number of channels are none of a recording
std::string wav_of(const Sound& sound);

}  // namespace bouncelab::web
