// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/flac_decoder.hpp"

#include <FLAC/stream_decoder.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <utility>
#include <vector>

namespace bouncelab::audio {
namespace {

constexpr std::array<char, 4> kFlacMagic{'f', 'L', 'a', 'C'};

}  // namespace

bool is_flac(SoundBytes bytes) {
  std::array<std::byte, kFlacMagic.size()> begin{};
  return bytes.read(0, begin) == std::ssize(begin) && std::memcmp(begin.data(), kFlacMagic.data(), begin.size()) == 0;
}

/// libFLAC calls the functions below for bytes, and with each block that it has decoded.
struct FlacDecoder::State {
  struct Delete {
    void operator()(FLAC__StreamDecoder* of) const { FLAC__stream_decoder_delete(of); }
  };

  SoundBytes bytes;
  std::int64_t at = 0;  // of the next byte
  std::unique_ptr<FLAC__StreamDecoder, Delete> decoder{FLAC__stream_decoder_new()};
  Format format;
  bool has_failed = false;

  std::vector<float> block;  // interleaved: the frames decoded last
  std::int64_t block_first = 0, n_block = 0;

  explicit State(SoundBytes bytes_) : bytes(bytes_) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() = default;

  bool begin() {
    return decoder &&
           FLAC__stream_decoder_init_stream(decoder.get(), read_bytes, seek, tell, length, is_at_end, write,
                                            take_metadata, take_error, this) == FLAC__STREAM_DECODER_INIT_STATUS_OK &&
           FLAC__stream_decoder_process_until_end_of_metadata(decoder.get()) && is_good();
  }

  bool is_good() const {
    const FLAC__StreamDecoderState state = FLAC__stream_decoder_get_state(decoder.get());
    return !has_failed && bytes.error() == 0 &&
           (state == FLAC__STREAM_DECODER_SEARCH_FOR_METADATA || state == FLAC__STREAM_DECODER_READ_METADATA ||
            state == FLAC__STREAM_DECODER_SEARCH_FOR_FRAME_SYNC || state == FLAC__STREAM_DECODER_READ_FRAME ||
            state == FLAC__STREAM_DECODER_END_OF_STREAM);
  }

  bool is_held(std::int64_t frame) const { return frame >= block_first && frame < block_first + n_block; }

  /// The block with the frame is decoded.
  bool go_to(std::int64_t frame) {
    if (frame == block_first + n_block) {
      const std::int64_t before = std::exchange(n_block, 0);
      block_first += before;
      return FLAC__stream_decoder_process_single(decoder.get()) && is_good() && is_held(frame);
    }
    n_block = 0;
    return FLAC__stream_decoder_seek_absolute(decoder.get(), static_cast<FLAC__uint64>(frame)) && is_good() &&
           is_held(frame);
  }

  bool read(std::int64_t first, std::span<float> out) {
    const std::int64_t end = first + std::ssize(out) / format.n_channels;
    for (std::int64_t frame = first; frame < end;) {
      if (!is_held(frame) && !go_to(frame)) return false;
      const std::int64_t n = std::min(end, block_first + n_block) - frame;
      const auto from = block.begin() + (frame - block_first) * format.n_channels;
      std::copy(from, from + n * format.n_channels, out.begin() + (frame - first) * format.n_channels);
      frame += n;
    }
    return true;
  }

  bool take_block(const FLAC__Frame& frame, const FLAC__int32* const* channels) {
    const FLAC__FrameHeader& header = frame.header;
    if (header.number_type != FLAC__FRAME_NUMBER_TYPE_SAMPLE_NUMBER ||
        static_cast<std::int32_t>(header.channels) != format.n_channels ||
        static_cast<int>(header.bits_per_sample) != format.n_bits || header.sample_rate != format.rate_hz)
      return false;
    block_first = static_cast<std::int64_t>(header.number.sample_number);
    n_block = header.blocksize;
    block.resize(static_cast<std::size_t>(n_block * format.n_channels));
    const float unit = 1.0F / static_cast<float>(1 << (format.n_bits - 1));
    const auto n_channels = static_cast<std::size_t>(format.n_channels);
    for (std::size_t channel = 0; channel < n_channels; ++channel) {
      const FLAC__int32* const from = channels[channel];
      float* const to = block.data() + channel;
      for (std::size_t k = 0; k < header.blocksize; ++k) to[k * n_channels] = static_cast<float>(from[k]) * unit;
    }
    return true;
  }

  // ---- called by libFLAC

  static State& of(void* user) { return *static_cast<State*>(user); }

  static FLAC__StreamDecoderReadStatus read_bytes(const FLAC__StreamDecoder*, FLAC__byte* to, std::size_t* n,
                                                  void* user) {
    State& s = of(user);
    const std::int64_t got = s.bytes.read(s.at, std::as_writable_bytes(std::span(to, *n)));
    *n = static_cast<std::size_t>(got);
    s.at += got;
    if (s.bytes.error() != 0) return FLAC__STREAM_DECODER_READ_STATUS_ABORT;
    return got > 0 ? FLAC__STREAM_DECODER_READ_STATUS_CONTINUE : FLAC__STREAM_DECODER_READ_STATUS_END_OF_STREAM;
  }

  static FLAC__StreamDecoderSeekStatus seek(const FLAC__StreamDecoder*, FLAC__uint64 to, void* user) {
    State& s = of(user);
    if (to > static_cast<FLAC__uint64>(s.bytes.size())) return FLAC__STREAM_DECODER_SEEK_STATUS_ERROR;
    s.at = static_cast<std::int64_t>(to);
    return FLAC__STREAM_DECODER_SEEK_STATUS_OK;
  }

  static FLAC__StreamDecoderTellStatus tell(const FLAC__StreamDecoder*, FLAC__uint64* at, void* user) {
    *at = static_cast<FLAC__uint64>(of(user).at);
    return FLAC__STREAM_DECODER_TELL_STATUS_OK;
  }

  static FLAC__StreamDecoderLengthStatus length(const FLAC__StreamDecoder*, FLAC__uint64* n, void* user) {
    *n = static_cast<FLAC__uint64>(of(user).bytes.size());
    return FLAC__STREAM_DECODER_LENGTH_STATUS_OK;
  }

  static FLAC__bool is_at_end(const FLAC__StreamDecoder*, void* user) {
    return of(user).at >= of(user).bytes.size() ? 1 : 0;
  }

  static FLAC__StreamDecoderWriteStatus write(const FLAC__StreamDecoder*, const FLAC__Frame* frame,
                                              const FLAC__int32* const channels[], void* user) {
    State& s = of(user);
    s.has_failed |= !s.take_block(*frame, channels);
    return s.has_failed ? FLAC__STREAM_DECODER_WRITE_STATUS_ABORT : FLAC__STREAM_DECODER_WRITE_STATUS_CONTINUE;
  }

  static void take_metadata(const FLAC__StreamDecoder*, const FLAC__StreamMetadata* metadata, void* user) {
    if (metadata->type != FLAC__METADATA_TYPE_STREAMINFO) return;
    const FLAC__StreamMetadata_StreamInfo& info = metadata->data.stream_info;
    of(user).format = {static_cast<double>(info.sample_rate), static_cast<std::int32_t>(info.channels),
                       static_cast<std::int64_t>(info.total_samples), static_cast<int>(info.bits_per_sample)};
  }

  static void take_error(const FLAC__StreamDecoder*, FLAC__StreamDecoderErrorStatus, void* user) {
    of(user).has_failed = true;
  }
};

std::optional<FlacDecoder> FlacDecoder::open(SoundBytes bytes) {
  if (!is_flac(bytes)) return {};
  auto state = std::make_unique<State>(bytes);
  if (!state->begin()) return {};
  const Format& format = state->format;
  if (format.n_frames <= 0 || format.n_channels <= 0 || (format.n_bits != 16 && format.n_bits != 24)) return {};
  std::vector<float> last(static_cast<std::size_t>(format.n_channels));
  if (!state->read(format.n_frames - 1, last)) return {};
  return FlacDecoder(std::move(state));
}

FlacDecoder::FlacDecoder(std::unique_ptr<State> state) : state_(std::move(state)) {}
FlacDecoder::FlacDecoder(FlacDecoder&&) noexcept = default;
FlacDecoder& FlacDecoder::operator=(FlacDecoder&&) noexcept = default;
FlacDecoder::~FlacDecoder() = default;

const FlacDecoder::Format& FlacDecoder::format() const { return state_->format; }

bool FlacDecoder::read(std::int64_t first, std::span<float> interleaved) { return state_->read(first, interleaved); }

}  // namespace bouncelab::audio
