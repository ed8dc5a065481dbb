// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "bouncelab/core/child_process.hpp"
#include "io/file_pieces.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

class DecoderProcess;

/// A SoundDecoder in a process of its own, with limits on processor time and memory that scale with the file.
///
/// A process that has read a file without an error is kept, and reads the next one: starting one takes longer than
/// reading the header of a recording. At most as many are kept as there were files open at the same time; they end with
/// this process.
class GuardedDecoder {
 public:
  static constexpr std::int64_t kMostSamples = 1 << 24;  ///< that can be read at once, of all channels together

  /// @param descriptor  of a regular file open for reading; it stays the caller's
  /// @throws NotForLibsndfile, FileError as SoundDecoder, or where libsndfile crashes or needs more than the file can
  /// be worth
  GuardedDecoder(int descriptor, std::string name);
  GuardedDecoder(const GuardedDecoder&) = delete;
  GuardedDecoder& operator=(const GuardedDecoder&) = delete;
  ~GuardedDecoder();

  const SoundInfo& info() const { return info_; }
  /// n interleaved frames from `first` on, all of them inside the file and at most kMostSamples samples.
  /// @return them, valid until the next call; shared with the other process, which does not touch them until then
  /// @throws FileError
  std::span<float> read(std::int64_t first, std::int64_t n_frames);

  /// Instead of read(): all frames are being decoded from the first call on, in pieces, while the caller works on those
  /// that are there.
  /// @param n_frames  that are needed, from the beginning on
  /// @param whole     all frames of the file, interleaved; the same in each call
  /// @return how many frames are there now, n_frames or more, of which no later call changes any
  /// @throws FileError
  std::int64_t read_whole(std::int64_t n_frames, std::span<float> whole);

  /// Starts a process for the next file, unless one is idle or none can be started.
  /// @param n_threads         2: read_whole() there may decode on two threads
  /// @param needs_libsndfile  for that file: it is loaded ahead
  static void start_process(int n_threads, bool needs_libsndfile);

 private:
  ChildLimits limits_for_samples(std::int64_t n_samples) const;
  void begin_pieces();
  /// False where the file cannot be read in two parts.
  bool finish_piece();
  void copy_piece(std::int64_t k, std::span<float> whole) const;

  std::string name_;
  std::int64_t n_bytes_ = 0;
  std::unique_ptr<DecoderProcess> process_;
  SoundInfo info_;
  FilePieces pieces_;
  std::int64_t n_begun_ = 0, n_copied_ = 0;  // pieces
};

}  // namespace bouncelab::audio
