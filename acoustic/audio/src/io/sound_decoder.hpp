// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "bouncelab/core/error.hpp"
#include "io/pcm_decode.hpp"
#include "io/sound_bytes.hpp"

namespace bouncelab::audio {

/// Has libsndfile and its codecs ready, which some programs load on demand.
void load_libsndfile();

/// What is known of a sound file once it is open.
struct SoundInfo {
  double rate_hz = 0.0;
  std::int32_t n_channels = 0;
  std::int64_t n_frames = 0;
  bool may_be_infinite = true;  ///< floats, and what a lossy codec makes, need not be finite
  /// Whether frames are the same wherever reading begins: of FLAC that has what its header says.
  bool can_begin_anywhere = false;
  PlainEncoding plain = PlainEncoding::none;
  std::int64_t first_byte = 0;  ///< of the samples, where they are plain
  std::string description;      ///< container and encoding, in words
  std::string lossy_coding;     ///< name of the coding that left out what is not heard; empty where none did
  std::string warning;          ///< where the header is wrong: what it promises and what was found
};

/// libsndfile cannot read the file: perhaps another decoder can.
class NotForLibsndfile : public FileError {
 public:
  NotForLibsndfile(const std::string& path, const std::string& reason_) : FileError(path, reason_), reason(reason_) {}
  std::string reason;
};

/// libsndfile itself: no limit on time and memory, which a damaged file may use up. AudioReader runs it in a process of
/// its own; the tests that try millions of damaged files run it as it is.
class SoundDecoder {
 public:
  /// Reads the header. Where it gives the length of the sound wrongly, or none, what is there is taken: of WAV, W64,
  /// AIFF and AU by the file's length (repair_header), of coded sound (FLAC) by reading to the end and counting.
  /// @param name  of the file, for messages
  /// @throws NotForLibsndfile; FileError naming the remedy
  SoundDecoder(SoundBytes bytes, std::string name);
  SoundDecoder(SoundDecoder&&) noexcept;
  SoundDecoder& operator=(SoundDecoder&&) noexcept;
  ~SoundDecoder();

  const SoundInfo& info() const;
  /// Interleaved frames from `first` on, all of them inside the file.
  /// @throws FileError where the file ends early
  void read(std::int64_t first, std::span<float> interleaved);

  /// The same as read(). @return false where libsndfile saw any error, also one that read() passes over
  bool read_without_error(std::int64_t first, std::span<float> interleaved);
  /// To the first frame, as if nothing had been read.
  void begin_again();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

inline constexpr double kLowestRate_hz = 4e3;  // below, a contact of steel on glass (30 us) leaves nothing to time
inline constexpr double kHighestRate_hz = 4e6;

/// @throws FileError where a sampling rate is outside of these
void check_rate(double rate_hz, const std::string& name);

/// The message for a file that holds less than its header says.
std::string ends_early(std::int64_t at_frame, std::int64_t n_promised);

}  // namespace bouncelab::audio
