// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/files.hpp"
#include "io/sound_bytes.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {

// Gaps between the time stamps of a container's blocks.

/// A packet of a container, or what was decoded of one.
struct StampedBlock {
  double begin_s = 0.0;
  double length_s = 0.0;
};

/// Where the time stamps run ahead of the samples, or go back.
struct StampGap {
  double after_s = 0.0;    ///< samples that come before it, in seconds
  double stamped_s = 0.0;  ///< by the time stamps; below 0: the samples that follow overlap those before

  /// A pause of more than a minute, or a clock that begins anew (files that were joined).
  bool is_jump() const;
  /// What stands for it between the samples: the gap itself; for a jump, forward or back, a minute of silence.
  double length_s() const;
};

/// A gap is a step of the stamps against the lengths before them that stays: the least of the eight stamps that follow
/// is beyond the greatest of the eight before, by more than 2 ms, so that neither the rounding of stamps (1 ms in
/// Matroska) nor their jitter (clocks of browsers) is one. Its length is a whole number of blocks where it is near one:
/// blocks are lost, not parts of them.
std::vector<StampGap> gaps_between(const std::vector<StampedBlock>& blocks);

/// Puts them into info.silences and info.warning.
void say_gaps(const std::vector<StampGap>& gaps, SoundInfo& info);

/// Samples that were decoded once: in memory, or, where they are more than 2^24 (64 MB), in a file without a name in
/// TMPDIR or /tmp, 4 bytes each.
class DecodedSamples {
 public:
  /// @param name  of the recording, for messages
  explicit DecodedSamples(std::string name) : name_(std::move(name)) {}

  /// Room for so many, as far as they are held in memory.
  void reserve(std::int64_t n);
  /// @throws FileError (disk full)
  void append(std::span<const float> samples);
  std::int64_t size() const { return n_; }
  /// Samples first ... first + out.size() - 1, all inside [0, size()); from any thread. @throws FileError
  void read(std::int64_t first, std::span<float> out) const;

 private:
  void append_to_file(std::span<const float> samples);

  std::string name_;
  std::int64_t n_ = 0;
  std::vector<float> held_;
  std::optional<ScratchFile> file_;  // instead
};

/// Decodes a recording, once and whole: by libsndfile in a process of its own, which has limits on processor time and
/// memory that grow with the file, or, where libsndfile does not know the format, by ffmpeg.
/// @param path   as it was given
/// @param track  of several that ffmpeg finds, from 0
/// @throws FileError naming the remedy; Interrupted
SoundInfo decode_coded(const std::filesystem::path& path, const ReadableFile& file, int track, DecodedSamples& samples);

/// Any recording that ffmpeg can decode, a track of sound of a video too: ffmpeg runs as a process of its own and
/// writes float samples and nothing else to a pipe, at the rate and in the channels that ffprobe states. It leaves out
/// what the file's edit list or encoder delay does. Gaps between the time stamps of its packets become zeros
/// (AudioFormat::silences).
/// @param reason  why libsndfile does not read it, for messages
/// @throws FileError: ffmpeg is not installed, or cannot read it; it holds no sound. Interrupted
SoundInfo decode_by_ffmpeg(const std::filesystem::path& path, const ReadableFile& file, int track,
                           const std::string& reason, DecodedSamples& samples);

}  // namespace bouncelab::audio
