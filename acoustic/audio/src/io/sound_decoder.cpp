// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_header.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kFramesAtOnce = 1 << 13;  // 32 kB of one channel: stays in the cache
constexpr std::int64_t kMp3Block_frames = 1152;
// FLAC packs best: a block of 65,535 equal samples into 10 bytes
constexpr std::int64_t kMostFramesPerByte = 1 << 16;

/// Where libsndfile stands in the bytes that it gets, a part of a file.
struct ByteCursor {
  FileBytes bytes;
  std::int64_t begin = 0, size = 0;
  std::int64_t at = 0;
  std::int64_t corrected_at = 0;  // place of bytes of the header that are wrong
  std::string corrected{};        // and what they should be
};

sf_count_t size_of(void* cursor) { return static_cast<ByteCursor*>(cursor)->size; }

sf_count_t seek(sf_count_t offset, int whence, void* user) {
  ByteCursor& cursor = *static_cast<ByteCursor*>(user);
  const std::int64_t from = whence == SEEK_CUR ? cursor.at : whence == SEEK_END ? cursor.size : 0;
  std::int64_t to = 0;
  if (__builtin_add_overflow(from, offset, &to) || to < 0) return -1;
  return cursor.at = to;
}

sf_count_t read_bytes(void* to, sf_count_t n, void* user) {
  ByteCursor& cursor = *static_cast<ByteCursor*>(user);
  n = std::min(n, cursor.size - cursor.at);
  if (n <= 0) return 0;
  const std::int64_t got =
      cursor.bytes.read(cursor.begin + cursor.at, {static_cast<std::byte*>(to), static_cast<std::size_t>(n)});
  for (std::size_t k = 0; k < cursor.corrected.size(); ++k)
    if (const std::int64_t place = cursor.corrected_at + static_cast<std::int64_t>(k) - cursor.at;
        place >= 0 && place < got)
      static_cast<char*>(to)[place] = cursor.corrected[k];
  cursor.at += got;
  return got;
}

sf_count_t write_nothing(const void*, sf_count_t, void*) { return 0; }

sf_count_t position_of(void* cursor) { return static_cast<ByteCursor*>(cursor)->at; }

struct CloseSound {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using SoundFile = std::unique_ptr<SNDFILE, CloseSound>;

/// @param cursor  is kept
SoundFile open_sound(ByteCursor& cursor, SF_INFO& header) {
  SF_VIRTUAL_IO io{size_of, seek, read_bytes, write_nothing, position_of};
  return SoundFile(sf_open_virtual(&io, SFM_READ, &header, &cursor));
}

/// The codings that keep of the sound what is heard. Others lose steps of the amplitude, which moves no impact.
std::string lossy_coding_of(int format) {
  constexpr std::array<std::pair<int, const char*>, 6> kLossy{{{SF_FORMAT_VORBIS, "Vorbis"},
                                                               {SF_FORMAT_OPUS, "Opus"},
                                                               {SF_FORMAT_MPEG_LAYER_I, "MPEG layer I"},
                                                               {SF_FORMAT_MPEG_LAYER_II, "MPEG layer II"},
                                                               {SF_FORMAT_MPEG_LAYER_III, "MP3"},
                                                               {SF_FORMAT_GSM610, "GSM 6.10"}}};
  for (const auto& [coding, name] : kLossy)
    if (coding == (format & SF_FORMAT_SUBMASK)) return name;
  return {};
}

bool is_integer(int format) {
  const int coding = format & SF_FORMAT_SUBMASK;
  return coding == SF_FORMAT_PCM_S8 || coding == SF_FORMAT_PCM_U8 || coding == SF_FORMAT_PCM_16 ||
         coding == SF_FORMAT_PCM_24 || coding == SF_FORMAT_PCM_32;
}

std::string reason_of_refusal() {
  std::string reason = sf_strerror(nullptr);
  while (!reason.empty() && (reason.back() == '.' || reason.back() == '\n')) reason.pop_back();
  return reason;
}

}  // namespace

std::string description_of(int format) {
  SF_FORMAT_INFO major{format & SF_FORMAT_TYPEMASK, nullptr, nullptr};
  SF_FORMAT_INFO sub{format & SF_FORMAT_SUBMASK, nullptr, nullptr};
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &major, sizeof major);
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &sub, sizeof sub);
  return std::string(major.name ? major.name : "?") + ", " + (sub.name ? sub.name : "?");
}

// ---- plain samples

namespace {

static_assert(std::endian::native == std::endian::little, "samples are read as they lie in files");

constexpr std::size_t kBytesAtOnce = 1 << 14;  // stay in the nearest cache

/// @tparam n_bytes  from one sample to the next. @param value  of a Word, full scale = 1
template <class Word, std::size_t n_bytes = sizeof(Word), class Value>
void convert(const std::byte* __restrict from, std::span<float> out, const Value& value) {
  for (std::size_t k = 0; k < out.size(); ++k) {
    Word word;
    std::memcpy(&word, from + k * n_bytes, sizeof word);
    out[k] = value(word);
  }
}

float from_24_bits(std::uint32_t upper) { return static_cast<float>(static_cast<std::int32_t>(upper)) * 0x1p-31F; }

/// Samples of 24 bits, four of which are three words: four times as fast as one by one.
/// @param n  a multiple of four
BOUNCELAB_VECTOR_CLONES void convert_fours(const std::byte* __restrict from, float* __restrict out, std::size_t n) {
  for (std::size_t k = 0; k < n; k += 4) {
    std::uint32_t a, b, c;
    std::memcpy(&a, from + 3 * k, sizeof a);
    std::memcpy(&b, from + 3 * k + 4, sizeof b);
    std::memcpy(&c, from + 3 * k + 8, sizeof c);
    out[k] = from_24_bits(a << 8U);
    out[k + 1] = from_24_bits((a >> 24U << 8U) | b << 16U);
    out[k + 2] = from_24_bits((b >> 16U << 8U) | c << 24U);
    out[k + 3] = from_24_bits(c >> 8U << 8U);
  }
}

/// @param from  followed by a byte more
void convert_24_bits(const std::byte* from, std::span<float> out) {
  const std::size_t n = out.size() - out.size() % 4;
  convert_fours(from, out.data(), n);
  convert<std::uint32_t, 3>(from + 3 * n, out.subspan(n), [](std::uint32_t x) { return from_24_bits(x << 8U); });
}

/// @param from  followed by a byte more
void convert(int coding, const std::byte* from, std::span<float> out) {
  switch (coding & SF_FORMAT_SUBMASK) {
    case SF_FORMAT_PCM_U8:
      return convert<std::uint8_t>(from, out, [](int x) { return static_cast<float>(x - 128) * 0x1p-7F; });
    case SF_FORMAT_PCM_16:
      return convert<std::int16_t>(from, out, [](int x) { return static_cast<float>(x) * 0x1p-15F; });
    case SF_FORMAT_PCM_24:
      return convert_24_bits(from, out);
    case SF_FORMAT_PCM_32:
      return convert<std::int32_t>(from, out, [](std::int32_t x) { return static_cast<float>(x) * 0x1p-31F; });
    case SF_FORMAT_DOUBLE:
      return convert<double>(from, out, [](double x) { return static_cast<float>(x); });
    default:
      return convert<float>(from, out, [](float x) { return x; });
  }
}

}  // namespace

void PlainSamples::read(std::int64_t first, std::span<float> interleaved) const {
  FileBytes bytes = bytes_;  // whose error is this call's
  const std::size_t n_bytes = sound_.sample_bytes;
  std::array<std::byte, kBytesAtOnce + 1> piece;
  std::int64_t at = first * sound_.info.n_channels;  // of all samples
  while (!interleaved.empty()) {
    const std::span<float> out = interleaved.first(std::min(kBytesAtOnce / n_bytes, interleaved.size()));
    const auto size = static_cast<std::int64_t>(n_bytes);
    const std::int64_t got =
        bytes.read(sound_.first_byte + at * size, std::span(piece).first(out.size() * n_bytes)) / size;
    bytes.check();
    at += got;
    if (got < std::ssize(out))
      throw FileError(bytes.name(), ends_early(at / sound_.info.n_channels, sound_.info.n_frames));
    convert(sound_.coding, piece.data(), out);
    interleaved = interleaved.subspan(out.size());
  }
}

// ---- coded sound

struct SoundDecoder::State {
  ByteCursor cursor;
  std::string name = cursor.bytes.name();
  SoundFile file{};
  SoundInfo info{};
  bool has_length = false;
  std::int64_t n_read = 0;  // frames
  std::vector<float> piece{};

  /// Whether the last frame is there that the header promises. A decoder that has met an error may not find it.
  bool can_read_last() {
    ByteCursor from_begin = cursor;
    from_begin.at = 0;
    SF_INFO header{};
    const SoundFile other = open_sound(from_begin, header);
    return other && sf_seek(other.get(), info.n_frames - 1, SEEK_SET) == info.n_frames - 1 &&
           sf_readf_float(other.get(), piece.data(), 1) == 1;
  }
};

SoundDecoder::SoundDecoder(const FileBytes& bytes) : state_(new State{{bytes, 0, bytes.size()}}) {
  State& s = *state_;
  if (const auto ogg = ogg_in_wav(s.cursor.bytes)) {
    s.cursor.begin = ogg->first;
    s.cursor.size = ogg->n_bytes;
  }
  const std::optional<CodedLength> length = coded_length(s.cursor.bytes);
  if (length) {
    s.cursor.corrected_at = length->at;
    s.cursor.corrected = bytes_of_number(static_cast<std::uint64_t>(length->n_bytes), 4);
  }
  SF_INFO header{};
  s.file = open_sound(s.cursor, header);
  s.cursor.bytes.check();
  if (!s.file) throw NotForLibsndfile(s.name, reason_of_refusal());
  if (header.frames <= 0 || header.channels <= 0) throw FileError(s.name, "holds no samples; record again");
  check_rate(header.samplerate, s.name);
  s.info.rate_hz = header.samplerate;
  s.info.n_channels = header.channels;
  s.info.n_frames = header.frames;
  s.info.description = description_of(header.format);
  s.info.lossy_coding = lossy_coding_of(header.format);
  s.info.may_be_infinite = !is_integer(header.format);
  if (length)
    s.info.n_frames = length->n_promised ? std::llround(static_cast<double>(header.frames) * *length->n_promised /
                                                        static_cast<double>(std::max<std::int64_t>(length->n_bytes, 1)))
                                         : SF_COUNT_MAX;
  s.has_length = s.info.n_frames != SF_COUNT_MAX;
  s.piece.resize(static_cast<std::size_t>(kFramesAtOnce * header.channels));
}

const SoundInfo& SoundDecoder::info() const { return state_->info; }

bool SoundDecoder::has_length() const { return state_->has_length; }

std::span<const float> SoundDecoder::next() {
  State& s = *state_;
  const std::int64_t got = std::max<std::int64_t>(0, sf_readf_float(s.file.get(), s.piece.data(), kFramesAtOnce));
  s.n_read += got;
  s.cursor.bytes.check();
  if (s.n_read / kMostFramesPerByte > s.cursor.size)
    throw FileError(s.name, "has more samples than any file of its length: damaged? record or copy it again");
  // an MP3 without a table of contents has no number: libsndfile estimates it by the bit rate, to a block or two
  const std::int64_t n_missing = s.info.n_frames - s.n_read;
  const bool is_estimate = s.info.lossy_coding == "MP3" && n_missing <= 2 * kMp3Block_frames;
  const bool may_have_all = s.has_length && s.info.n_frames / kMostFramesPerByte <= s.cursor.size;
  if (got == 0 && n_missing > 0 && may_have_all && !is_estimate && s.can_read_last())
    throw FileError(s.name, ends_early(s.n_read, s.info.n_frames));
  return std::span(s.piece).first(static_cast<std::size_t>(got * s.info.n_channels));
}

void conclude(SoundInfo& info, bool has_length, std::int64_t n_found, const std::string& name) {
  const std::int64_t n_promised = std::exchange(info.n_frames, n_found);
  if (n_found == 0) throw FileError(name, "holds no samples; record again");
  const bool is_estimate = info.lossy_coding == "MP3" && std::abs(n_found - n_promised) <= 2 * kMp3Block_frames;
  if (n_found != n_promised && !is_estimate)
    info.warning = wrong_length(info, has_length ? std::optional(static_cast<double>(n_promised)) : std::nullopt);
}

}  // namespace bouncelab::audio
