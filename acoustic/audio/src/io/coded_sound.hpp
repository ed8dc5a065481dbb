// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bouncelab/core/files.hpp"
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
SoundInfo decode_coded(const std::filesystem::path& path, const FileBytes& file, int track, DecodedSamples& samples);

/// Any recording that ffmpeg can decode, a track of sound of a video too: ffmpeg runs as a process of its own and
/// writes float samples and nothing else to a pipe, at the rate and in the channels that ffprobe states. It leaves out
/// what the file's edit list or encoder delay does. Gaps between the time stamps of its packets become zeros
/// (AudioFormat::silences).
/// @param reason  why libsndfile does not read it, for messages
/// @throws FileError: ffmpeg is not installed, or cannot read it; it holds no sound. Interrupted
SoundInfo decode_by_ffmpeg(const std::filesystem::path& path, const FileBytes& file, int track,
                           const std::string& reason, DecodedSamples& samples);

bool is_npy(FileBytes& bytes);

/// Samples that NumPy saved (numpy.save, format versions 1 to 3): one dimension, or samples x channels in C order, of
/// int16 (full scale = 32768), float32 or float64 (full scale = 1), little-endian.
/// @param rate_hz  sampling rate, which the format does not hold
/// @throws FileError naming the remedy: another type, order or shape, cut off, no rate given
/// Source: numpy.lib.format, https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
PlainSound npy_sound(FileBytes& bytes, std::optional<double> rate_hz);

/// Whether a file may be a table: no control characters in its first bytes.
bool is_text(FileBytes& bytes);

/// The step of the first column of such a table, where that is a time [s]; read from its first rows.
/// @throws FileError where these are no numbers
std::optional<double> step_of_number_text(std::istream& in);

/// Samples as a table of text, as phyphox and oscilloscopes export them: columns by tab, semicolon, comma or blanks;
/// decimal point, or decimal comma where the comma does not separate; lines in front that are no numbers (titles,
/// units), empty ones and those that begin with # are passed over.
///
/// A first column whose title has a unit of time, or that grows by equal steps, gives the sampling
/// rate; one that counts 0, 1, 2 ... is passed over. Every other column is a channel, full scale = 1.
/// @param in       the table's text, read to its end. @param name  for messages
/// @param rate_hz  of a table without times
/// @throws FileError naming the line: no numbers, another number of cells, times that are not uniform, neither times
///         nor rate; InvalidArgument where there are both
SoundInfo read_number_text(std::istream& in, const std::string& name, std::optional<double> rate_hz,
                           DecodedSamples& samples);

}  // namespace bouncelab::audio
