// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bouncelab/core/program_output.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {

/// Any recording that ffmpeg can decode, the first sound of a video too: ffmpeg runs as a process of its own and writes
/// float samples to a pipe, at the recording's rate and in its channels. It leaves out what the file's edit list or
/// encoder delay does.
///
/// Opening decodes all of it once, which gives its length. What fits into kMostSamples stays in memory; of a longer
/// recording a part of that size, and going back beyond it decodes again from the beginning: places that ffmpeg finds
/// by itself are not exact in all formats.
class FfmpegDecoder {
 public:
  static constexpr std::int64_t kMostSamples = 1 << 24;  ///< of all channels together

  /// @param content     under which the file can be opened by others; a path in /proc or /dev is handed over instead
  /// @param descriptor  of the same file; it stays the caller's
  /// @param name        for messages
  /// @param reason      why libsndfile does not read it, for messages
  /// @throws FileError: ffmpeg is not installed, or cannot read it; it holds no sound
  FfmpegDecoder(const std::filesystem::path& content, int descriptor, std::string name, const std::string& reason);

  const SoundInfo& info() const { return info_; }
  /// Whether all of it stays in memory.
  bool is_whole() const { return is_whole_; }
  /// n interleaved frames from `first` on, all of them inside the recording, at most kMostSamples / 2 samples unless it
  /// is held whole. @return them, valid until the next call. @throws FileError, Interrupted
  std::span<float> read(std::int64_t first, std::int64_t n_frames);

 private:
  void ask_what_it_is(const std::string& reason);
  void start();
  void count();
  std::size_t append(std::size_t n_samples);

  std::filesystem::path ffmpeg_, ffprobe_;
  std::string input_;  // as ffmpeg is told
  std::string name_;
  int descriptor_;
  double cpu_s_;
  std::int64_t n_most_frames_;
  SoundInfo info_;
  std::unique_ptr<ProgramOutput> running_;
  std::vector<float> window_;      // of interleaved samples
  std::int64_t window_first_ = 0;  // frame
  bool is_whole_ = false;          // the window is all
};

}  // namespace bouncelab::audio
