// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <thread>

#include "bouncelab/core/child_process.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

/// A file decoded from its beginning to its end, the second half at the same time on a thread of its own. The samples
/// are those of one decoder: of codings without loss, where libsndfile sees an error anywhere, one goes on alone.
class TwoPartDecoder {
 public:
  /// @param first       at its beginning; can_begin_anywhere()
  /// @param descriptor  of the same file
  /// @param memory      begins with the file's samples, interleaved
  TwoPartDecoder(SoundDecoder& first, int descriptor, std::string name, SharedMemory& memory);
  TwoPartDecoder(const TwoPartDecoder&) = delete;
  TwoPartDecoder& operator=(const TwoPartDecoder&) = delete;
  ~TwoPartDecoder();

  /// Has the frames before `end` there; never fewer than before. @throws FileError as SoundDecoder::read()
  void read_until(std::int64_t end);

 private:
  std::span<float> part(std::int64_t first, std::int64_t end) const;
  void decode_second_half(int descriptor);
  /// Stops the thread.
  void stop();
  /// Waits until the second thread has the frames before `end`. False where it has failed.
  bool is_second_there(std::int64_t end);
  /// By the first decoder, from where it is.
  void go_on_alone(std::int64_t end);

  SoundDecoder& first_;
  std::string name_;
  SharedMemory& memory_;
  std::int64_t n_channels_, n_frames_, middle_;
  std::int64_t n_first_ = 0;  // frames that the first decoder has made
  bool is_alone_ = false;

  std::mutex mutex_;  // of what follows
  std::condition_variable changed_;
  std::int64_t n_second_;    // end of what the second thread has made
  bool has_failed_ = false;  // there, or it was told to stop
  std::thread second_;
};

}  // namespace bouncelab::audio
