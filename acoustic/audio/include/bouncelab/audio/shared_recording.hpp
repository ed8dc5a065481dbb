// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "bouncelab/audio/audio_reader.hpp"

namespace bouncelab::audio {

/// A recording that several threads read, by as many readers as it gains by: a decoder that is asked for one place and
/// another in turn would seek each time.
class SharedRecording {
 public:
  /// @param rate_hz, bytes_read  as of AudioReader, which says what is thrown too
  /// @param n_threads            that will read it
  SharedRecording(const std::filesystem::path& path, std::optional<double> rate_hz, int n_threads,
                  BytesSink bytes_read = {});
  SharedRecording(const SharedRecording&) = delete;
  SharedRecording& operator=(const SharedRecording&) = delete;
  ~SharedRecording();

  const AudioFormat& format() const;
  /// One channel, to be read by any thread; it refers to this object, which must outlive it.
  AudioSource source(int channel);

 private:
  class Readers;
  std::unique_ptr<Readers> readers_;
};

}  // namespace bouncelab::audio
