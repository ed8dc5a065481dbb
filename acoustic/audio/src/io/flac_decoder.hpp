// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "io/sound_bytes.hpp"

namespace bouncelab::audio {

/// Whether the bytes begin like FLAC that FlacDecoder may read.
bool is_flac(SoundBytes bytes);

/// FLAC by libFLAC (RFC 9639), which libsndfile reads it with too: without that it takes four fifths of the time, and a
/// short recording need not wait until libsndfile has been loaded with all its codecs. Of files that have all that
/// their header says; what is to become of others libsndfile decides.
class FlacDecoder {
 public:
  struct Format {
    double rate_hz = 0.0;
    std::int32_t n_channels = 0;
    std::int64_t n_frames = 0;
    int n_bits = 0;  ///< 16 or 24, of a sample
  };

  /// None where the bytes do not begin with a FLAC of 16 or 24 bits that states its length and has its last frame.
  static std::optional<FlacDecoder> open(SoundBytes bytes);
  FlacDecoder(FlacDecoder&&) noexcept;
  FlacDecoder& operator=(FlacDecoder&&) noexcept;
  ~FlacDecoder();

  const Format& format() const;
  /// Interleaved frames from `first` on, all of them inside the file: the floats that libsndfile gives.
  /// @return false where libFLAC saw an error: then read no more
  bool read(std::int64_t first, std::span<float> interleaved);

 private:
  struct State;
  explicit FlacDecoder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace bouncelab::audio
