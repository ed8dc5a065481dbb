// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace bouncelab::audio {

/// Where a recording has no sound, though its clock ran on: it holds zeros there.
struct Silence {
  double begin_s = 0.0, end_s = 0.0;
};

/// One channel of sound with random access, from a file or from memory, so that hours of sound can be read several
/// times in bounded memory.
struct AudioSource {
  double rate_hz = 0.0;
  std::int64_t n_samples = 0;
  /// Fills `out` with the samples first ... first + out.size() - 1, all inside [0, n_samples). Full scale = 1. Called
  /// from any thread.
  std::function<void(std::int64_t first, std::span<float> out)> read;
  std::vector<Silence> silences{};
};

/// Source of samples in memory, which must outlive it.
/// @param samples  interleaved where there are several channels
/// @throws InvalidArgument naming a sample that is not finite
AudioSource source_in_memory(std::span<const float> samples, double rate_hz, int n_channels = 1, int channel = 0);

/// Reads samples first ... first + out.size() - 1; those outside the recording are 0.
void read_padded(const AudioSource& source, std::int64_t first, std::span<float> out);

/// Samples below this are zeros: half a step of 32-bit samples. A decoder of Opus makes 2e-34 of a zero.
inline constexpr float kLeastSound = 0x1p-32F;

/// A part of a recording.
struct PartOfSource {
  AudioSource sound;
  double begin_s = 0.0;  ///< in the recording
};

/// The recording without the zeros before its first and after its last sound (a muted microphone, a screen recorder),
/// as if it had been begun later and stopped earlier. Zeros of less than a second stay: so much belongs to a recording
/// as devices begin it. All of it where it holds nothing but zeros. Reads the zeros only.
PartOfSource without_zeros_around(const AudioSource& source);

/// Index of the first sample that is infinite or no number, or how many samples there are.
std::size_t first_unusable(std::span<const float> samples);

/// Format of a recording.
struct AudioFormat {
  double rate_hz = 0.0;
  int n_channels = 0;
  std::int64_t n_frames = 0;  ///< samples per channel
  std::string description;    ///< container and encoding, in words
  std::string lossy_coding;   ///< "MP3", "AAC" ...: its coding keeps what is heard, not the samples; empty: it does not
  std::string ffmpeg;         ///< version of the ffmpeg that decodes it; empty where none does
  int n_tracks = 1;           ///< of sound
  int track = 0;              ///< the one that is read
  std::vector<Silence> silences;  ///< gaps of its time stamps
  std::string warning;            ///< one line where the header and what the file holds differ; empty where they agree
};

/// Reads recordings with random access, never resampled:
///   - plain samples of WAV, RF64 and W64 in place
///   - what else libsndfile knows (FLAC, AIFF, OGG, MP3 ...), decoded once into memory, or where there are more than
///     2^24 samples into a nameless file in TMPDIR or /tmp
///   - the sound of any other file likewise by ffmpeg, where that is installed (m4a, mp4, mov, 3gp, webm, mkv, amr ...)
///   - numbers: .npy of samples (x channels), tables of text with or without a column of times
/// Where the time stamps of a container (mp4, mkv, webm ...) leave a gap, zeros stand for what is missing, and where
/// they overlap, what came first stays: the times of what follows are those of the container. A jump of more than a
/// minute, or back by more than a second, is a minute of zeros, and format().warning says so. Where the header gives
/// another length than the file has, or none, what is there is read, and format().warning says so. May be read by
/// several threads. A copy is of the same recording.
class AudioReader {
 public:
  /// @param rate_hz  sampling rate of numbers that come without one
  /// @param track    of several tracks of sound, from 0
  /// @throws FileError naming the remedy: missing, empty, no sound in it, ffmpeg needed and not installed, numbers
  ///         without a rate or with times that are not uniform, a sampling rate outside 4 kHz ... 4 MHz;
  ///         InvalidArgument where rate_hz is given for a file with a rate of its own, or is out of range, or there is
  ///         no such track
  explicit AudioReader(const std::filesystem::path& path, std::optional<double> rate_hz = std::nullopt, int track = 0);

  const AudioFormat& format() const;

  /// Samples first ... first + out.size() - 1 of one channel; full scale = 1.
  /// @throws InvalidArgument outside the file; FileError where it ends early or a sample is not finite
  void read(std::int64_t first, int channel, std::span<float> out) const;

  /// The channels whose samples are not all the same, in order. Reads no further than to where each has two values.
  /// @throws FileError as read()
  std::vector<int> channels_with_sound() const;

  /// One channel as an AudioSource, which keeps the recording open.
  AudioSource source(int channel) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

/// The version of the ffmpeg that has decoded a recording in this process; empty where none has.
std::string ffmpeg_version_used();

enum class SampleEncoding { pcm16, pcm24, pcm32, float32 };

/// Format of a sound file to be written.
struct AudioSpec {
  int rate_hz = 96000;
  int n_channels = 1;
  SampleEncoding encoding = SampleEncoding::pcm24;
};

/// Writes a sound file, whole or not at all. The container follows the extension, .wav where a stream has none: .wav
/// (RF64 by itself where the sound would pass the 4 GiB that WAV can hold), .rf64, .w64 (Sony Wave64) or .flac.
class AudioWriter {
 public:
  /// @param n_frames      length of the sound, as far as known; decides between WAV and RF64
  /// @param may_replace   an existing file may be overwritten
  /// @throws InvalidArgument naming extension, rate, channels or encoding where the container cannot hold it
  /// @throws FileError where the file cannot be written
  AudioWriter(const std::filesystem::path& path, const AudioSpec& spec, std::int64_t n_frames, bool may_replace);

  /// Appends samples, interleaved by channel, full scale = 1. Integers are rounded to nearest; what is beyond full
  /// scale is clipped to it. @throws FileError (disk full)
  void write(std::span<const double> interleaved);
  /// The same of floats, which float32 holds as they are, also those beyond full scale that a decoder gives.
  void write(std::span<const float> interleaved);
  /// Closes the file and puts it in place; without it nothing is left. @throws FileError
  void commit();

 private:
  void write_floats(std::span<const float> interleaved);

  struct State;
  std::shared_ptr<State> state_;
};

/// The samples as they would be read back from a file of this encoding: rounded and clipped like AudioWriter does.
std::vector<float> as_read_back(std::span<const double> samples, SampleEncoding encoding);
/// Throws InvalidArgument where no AudioWriter could write this: a long synthesis should not find out at its end.
void validate(const std::filesystem::path& path, const AudioSpec& spec);

}  // namespace bouncelab::audio
