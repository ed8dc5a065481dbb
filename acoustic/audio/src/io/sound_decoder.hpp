// SPDX-License-Identifier: GPL-3.0-or-later
// Samples by libsndfile.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>

#include "bouncelab/core/error.hpp"
#include "io/sound_bytes.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {

/// Container and coding in words. @param format  as libsndfile numbers it
std::string description_of(int format);

/// libsndfile cannot read the file: perhaps another decoder can.
class NotForLibsndfile : public FileError {
 public:
  NotForLibsndfile(const std::string& path, const std::string& reason_) : FileError(path, reason_), reason(reason_) {}
  std::string reason;
};

/// Plain samples, read in place: libsndfile is told what they are, and sees nothing of the file's header, which may be
/// damaged.
class PlainSamples {
 public:
  /// @param name  of the file, for messages
  PlainSamples(SoundBytes bytes, const PlainSound& sound, std::string name);
  PlainSamples(const PlainSamples&) = delete;
  PlainSamples& operator=(const PlainSamples&) = delete;
  ~PlainSamples();

  /// Interleaved frames from `first` on, all of them inside the sound; from any thread.
  /// @throws FileError where the file ends early or cannot be read
  void read(std::int64_t first, std::span<float> interleaved);

 private:
  struct State;
  std::mutex reading_;
  std::unique_ptr<State> state_;
};

/// Coded sound from its begin to its end: no limit on time and memory, which a damaged file may use up, so that
/// decode_coded() runs this in a process of its own. The tests that try millions of damaged files run it as it is.
class SoundDecoder {
 public:
  /// Reads the header. @throws NotForLibsndfile; FileError naming the remedy
  SoundDecoder(SoundBytes bytes, std::string name);
  SoundDecoder(const SoundDecoder&) = delete;
  SoundDecoder& operator=(const SoundDecoder&) = delete;
  ~SoundDecoder();

  /// n_frames as the header says, which may be wrong.
  const SoundInfo& info() const;
  /// Whether the header says how many frames there are.
  bool has_length() const;
  /// The next interleaved frames, until the next call; none at the end.
  /// @throws FileError where samples are missing that are not the last ones, or there is no end
  std::span<const float> next();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What is known once all was decoded. @param n_found  frames. @throws FileError where there are none
void conclude(SoundInfo& info, bool has_length, std::int64_t n_found, const std::string& name);

}  // namespace bouncelab::audio
