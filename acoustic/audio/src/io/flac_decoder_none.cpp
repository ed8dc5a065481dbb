// SPDX-License-Identifier: GPL-3.0-or-later
// Where each kilobyte counts (a browser): FLAC is read by libsndfile alone.
#include "io/flac_decoder.hpp"

#include <utility>

namespace bouncelab::audio {

bool is_flac(SoundBytes) { return false; }

struct FlacDecoder::State {
  Format format;
};

std::optional<FlacDecoder> FlacDecoder::open(SoundBytes) { return {}; }

FlacDecoder::FlacDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
FlacDecoder::FlacDecoder(FlacDecoder&&) noexcept = default;
FlacDecoder& FlacDecoder::operator=(FlacDecoder&&) noexcept = default;
FlacDecoder::~FlacDecoder() = default;

const FlacDecoder::Format& FlacDecoder::format() const { return state_->format; }

bool FlacDecoder::read(std::int64_t, std::span<float>) { return false; }

}  // namespace bouncelab::audio
