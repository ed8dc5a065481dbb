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

#include "bouncelab/audio/audio_source.hpp"

namespace bouncelab::audio {

/// Format of a recording.
struct AudioFormat {
  double rate_hz = 0.0;
  int n_channels = 0;
  std::int64_t n_frames = 0;  ///< samples per channel
  std::string description;    ///< container and encoding, in words
  std::string lossy_coding;   ///< "MP3", "AAC" ...: its coding keeps what is heard, not the samples; empty: it does not
  std::string ffmpeg;         ///< version of the ffmpeg that decodes it; empty where none does
  std::string warning;        ///< one line where the header and what the file holds differ; empty where they agree
};

/// Takes bytes of a file as they are read, and their place in it.
using BytesSink = std::function<void(std::int64_t first, std::span<const std::byte> bytes)>;

/// Reads recordings with random access, never resampled:
///   - what libsndfile knows (WAV, RF64, W64, FLAC, OGG, MP3, AIFF, CAF ...); where the header of such a file gives
///     another length than it has, or none, what is there is read, and format().warning says so
///   - the sound of any other file by ffmpeg, where that is installed (m4a, mp4, mov, 3gp, webm, mkv, amr ...)
///   - numbers: .npy of samples (x channels), tables of text with or without a column of times
/// Not for several threads at once: SharedRecording is (shared_recording.hpp).
class AudioReader {
 public:
  /// @param rate_hz  sampling rate of numbers that come without one
  /// @param bytes_read  told of whatever is read of plain samples (WAV, AIFF ... without a codec), each time it is, and
  ///                    before the first of them of the header; of nothing else. Never by two threads at once.
  /// @throws FileError naming the remedy: missing, empty, no sound in it, ffmpeg needed and not installed, numbers
  ///         without a rate or with times that are not uniform, a sampling rate outside 4 kHz ... 4 MHz;
  ///         InvalidArgument where rate_hz is given for a file with a rate of its own, or is out of range
  explicit AudioReader(const std::filesystem::path& path, std::optional<double> rate_hz = std::nullopt,
                       BytesSink bytes_read = {});
  /// The same for the bytes of a file in memory, which must outlive the reader; by libsndfile alone.
  /// @param name  for messages. @throws FileError
  AudioReader(std::span<const std::byte> bytes, const std::string& name);
  AudioReader(AudioReader&&) noexcept;
  AudioReader& operator=(AudioReader&&) noexcept;
  ~AudioReader();

  const AudioFormat& format() const;

  /// Samples first ... first + out.size() - 1 of one channel; full scale = 1.
  /// @throws InvalidArgument outside the file; FileError where it ends early or a sample is not finite
  void read(std::int64_t first, int channel, std::span<float> out);

  /// Whether several readers of the file, one for each thread, read it in less time than one in turns, and the same
  /// samples: a FLAC that is too long to be held in memory, so that a decoder seeks where it is not read onwards.
  bool gains_by_more_readers() const;

  /// One channel as an AudioSource; it refers to this reader, which must outlive it.
  AudioSource source(int channel);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Starts the process in which a recording will be decoded, as its AudioReader would: what its caller does meanwhile
/// costs no time. Nothing where it cannot be started, which that reader then says.
/// @param n_threads  2 or more: may decode a recording of FLAC on two, the same samples
void prepare_to_read(const std::filesystem::path& path, int n_threads = 1);

/// The version of the ffmpeg that has decoded a recording in this process; empty where none has.
std::string ffmpeg_version_used();

}  // namespace bouncelab::audio
