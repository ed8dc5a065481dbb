// SPDX-License-Identifier: GPL-3.0-or-later
// SharedRecording where there is one thread (a browser).
#include <utility>

#include "bouncelab/audio/shared_recording.hpp"

namespace bouncelab::audio {

class SharedRecording::Readers {
 public:
  explicit Readers(AudioReader reader_) : reader(std::move(reader_)) {}
  AudioReader reader;
};

SharedRecording::SharedRecording(const std::filesystem::path& path, std::optional<double> rate_hz, int,
                                 BytesSink bytes_read)
    : readers_(std::make_unique<Readers>(AudioReader(path, rate_hz, std::move(bytes_read)))) {}

SharedRecording::~SharedRecording() = default;

const AudioFormat& SharedRecording::format() const { return readers_->reader.format(); }

AudioSource SharedRecording::source(int channel) { return readers_->reader.source(channel); }

}  // namespace bouncelab::audio
