// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "io/pcm_decode.hpp"
#include "io/sound_bytes.hpp"

namespace bouncelab::audio {

/// What libsndfile finds out about a sound file.
struct SoundInfo {
  double rate_hz = 0.0;
  std::int32_t n_channels = 0;
  std::int64_t n_frames = 0;
  bool may_be_infinite = true;  ///< floats, and what a lossy codec makes, need not be finite
  PlainEncoding plain = PlainEncoding::none;
  std::int64_t first_byte = 0;  ///< of the samples, where they are plain
  std::string description;      ///< container and encoding, in words
};

/// libsndfile itself: no limit on time and memory, which a damaged file may use up. AudioReader runs it in a process of
/// its own; the tests that try millions of damaged files run it as it is.
class SoundDecoder {
 public:
  /// Reads the header; a stream that was written without its length (FLAC from a pipe) is read to its end and counted.
  /// @param name  of the file, for messages
  /// @throws FileError naming the remedy
  SoundDecoder(SoundBytes bytes, std::string name);
  SoundDecoder(SoundDecoder&&) noexcept;
  SoundDecoder& operator=(SoundDecoder&&) noexcept;
  ~SoundDecoder();

  const SoundInfo& info() const;
  /// Interleaved frames from `first` on, all of them inside the file.
  /// @throws FileError where the file ends early
  void read(std::int64_t first, std::span<float> interleaved);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The message for a file that holds less than its header says.
std::string ends_early(std::int64_t at_frame, std::int64_t n_promised);

}  // namespace bouncelab::audio
