// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

namespace bouncelab::audio {

enum class SampleEncoding { pcm16, pcm24, pcm32, float32 };

/// Format of a sound file to be written.
struct AudioSpec {
  int rate_hz = 96000;
  int n_channels = 1;
  SampleEncoding encoding = SampleEncoding::pcm24;
};

/// Writes a sound file, whole or not at all. The container follows the extension, .wav where a stream has none: .wav
/// (RF64 by itself where the sound would pass the 4 GiB that WAV can hold), .rf64, .w64 (Sony Wave64) or .flac.
class AudioWriter {
 public:
  /// @param n_frames      length of the sound, as far as known; decides between WAV and RF64
  /// @param may_replace   an existing file may be overwritten
  /// @throws InvalidArgument naming extension, rate, channels or encoding where the container cannot hold it
  /// @throws FileError where the file cannot be written
  AudioWriter(const std::filesystem::path& path, const AudioSpec& spec, std::int64_t n_frames, bool may_replace);
  ~AudioWriter();
  AudioWriter(AudioWriter&&) noexcept;
  AudioWriter& operator=(AudioWriter&&) noexcept;

  /// Appends samples, interleaved by channel, full scale = 1. Integers are rounded to nearest; what is beyond full
  /// scale is clipped to it. @throws FileError (disk full)
  void write(std::span<const double> interleaved);
  /// The same of floats, which float32 holds as they are, also those beyond full scale that a decoder gives.
  void write(std::span<const float> interleaved);
  /// Closes the file and puts it in place; without it the destructor removes what was written. @throws FileError
  void commit();

 private:
  void write_floats(std::span<const float> interleaved);

  struct State;
  std::unique_ptr<State> state_;
};

/// The samples as they would be read back from a file of this encoding: rounded and clipped like AudioWriter does.
std::vector<float> as_read_back(std::span<const double> samples, SampleEncoding encoding);
/// The same into memory of at least as many floats; of samples that are floats, the same bits as of those in doubles.
void as_read_back(std::span<const double> samples, SampleEncoding encoding, std::span<float> out);
void as_read_back(std::span<const float> samples, SampleEncoding encoding, std::span<float> out);

/// Throws InvalidArgument where no AudioWriter could write this: a long synthesis should not find out at its end.
void validate(const std::filesystem::path& path, const AudioSpec& spec);

}  // namespace bouncelab::audio
