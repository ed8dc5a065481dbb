// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "bouncelab/audio/audio_source.hpp"

namespace bouncelab::audio {

/// Format of an audio file, from its header.
struct AudioFormat {
  double rate_hz = 0.0;
  int n_channels = 0;
  std::int64_t n_frames = 0;  ///< samples per channel
  std::string description;    ///< container and encoding, in words
};

/// Reads any format that libsndfile knows (WAV, RF64, FLAC, OGG, MP3, AIFF, CAF ...), with random access, never
/// resampled. Not for several threads at once; open the file once per thread instead.
class AudioReader {
 public:
  /// @throws FileError naming the remedy: missing, empty, not audio, m4a (which libsndfile cannot read), truncated or
  ///         with a header that promises more than the file holds, a sampling rate outside 4 kHz ... 4 MHz
  explicit AudioReader(const std::filesystem::path& path);
  /// The same for the bytes of a file in memory, which must outlive the reader.
  /// @param name  for messages. @throws FileError
  AudioReader(std::span<const std::byte> bytes, const std::string& name);
  AudioReader(AudioReader&&) noexcept;
  AudioReader& operator=(AudioReader&&) noexcept;
  ~AudioReader();

  const AudioFormat& format() const;

  /// Samples first ... first + out.size() - 1 of one channel; full scale = 1.
  /// @throws InvalidArgument outside the file; FileError where it ends early or a sample is not finite
  void read(std::int64_t first, int channel, std::span<float> out);

  /// One channel as an AudioSource; it refers to this reader, which must outlive it.
  AudioSource source(int channel);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace bouncelab::audio
