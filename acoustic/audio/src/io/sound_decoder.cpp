// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_decoder.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "io/flac_decoder.hpp"
#include "io/header_repair.hpp"

namespace bouncelab::audio {

/// Where libsndfile stands in the bytes, and the bytes it gets.
struct ByteCursor {
  SoundBytes bytes;
  std::int64_t begin = 0, size = 0;  // of the sound file within them
  std::vector<HeaderPatch> patches{};
  std::int64_t at = 0;
};

namespace {

constexpr std::int64_t kFramesAtOnce = 1 << 14;  // 64 kB of one channel: stays in the cache
constexpr std::int64_t kMp3Block_frames = 1152;
// as libsndfile names them
constexpr const char* kFlac16 = "FLAC (Free Lossless Audio Codec), Signed 16 bit PCM";
constexpr const char* kFlac24 = "FLAC (Free Lossless Audio Codec), Signed 24 bit PCM";
// FLAC packs best: a block of 65,535 equal samples into 10 bytes
constexpr std::int64_t kMostFramesPerByte = 1 << 16;

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
  std::byte* const bytes = static_cast<std::byte*>(to);
  const std::int64_t got = cursor.bytes.read(cursor.begin + cursor.at, {bytes, static_cast<std::size_t>(n)});
  for (const HeaderPatch& patch : cursor.patches) {
    const std::int64_t first = std::max(patch.first, cursor.at);
    const std::int64_t last = std::min(patch.first + std::ssize(patch.bytes), cursor.at + got);
    if (first < last)
      std::memcpy(bytes + (first - cursor.at), patch.bytes.data() + (first - patch.first),
                  static_cast<std::size_t>(last - first));
  }
  cursor.at += got;
  return got;
}

sf_count_t write_nothing(const void*, sf_count_t, void*) { return 0; }

sf_count_t position_of(void* cursor) { return static_cast<ByteCursor*>(cursor)->at; }

/// Integers are finite.
bool is_integer(int encoding) {
  return encoding == SF_FORMAT_PCM_S8 || encoding == SF_FORMAT_PCM_U8 || encoding == SF_FORMAT_PCM_16 ||
         encoding == SF_FORMAT_PCM_24 || encoding == SF_FORMAT_PCM_32;
}

std::string describe_format(int format) {
  SF_FORMAT_INFO major{};
  SF_FORMAT_INFO sub{};
  major.format = format & SF_FORMAT_TYPEMASK;
  sub.format = format & SF_FORMAT_SUBMASK;
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &major, sizeof major);
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &sub, sizeof sub);
  return std::string(major.name ? major.name : "?") + ", " + (sub.name ? sub.name : "?");
}

/// How the samples lie in the file, if they do so one after the other in this processor's order.
PlainEncoding plain_encoding(SNDFILE* file, int format) {
  const int container = format & SF_FORMAT_TYPEMASK;
  const bool may_be = container == SF_FORMAT_WAV || container == SF_FORMAT_WAVEX || container == SF_FORMAT_RF64 ||
                      container == SF_FORMAT_W64 || container == SF_FORMAT_AIFF || container == SF_FORMAT_AU ||
                      container == SF_FORMAT_CAF;
  const bool is_native = std::endian::native == std::endian::little &&
                         sf_command(file, SFC_RAW_DATA_NEEDS_ENDSWAP, nullptr, 0) == SF_FALSE;
  if (!may_be || !is_native) return PlainEncoding::none;
  const int sub = format & SF_FORMAT_SUBMASK;
  if (sub == SF_FORMAT_PCM_16) return PlainEncoding::int16;
  if (sub == SF_FORMAT_PCM_24) return PlainEncoding::int24;
  return sub == SF_FORMAT_FLOAT ? PlainEncoding::float32 : PlainEncoding::none;
}

/// The codings that keep of the sound what is heard. Others lose steps of the amplitude, which moves no impact.
std::string lossy_coding_of(int format) {
  switch (format & SF_FORMAT_SUBMASK) {
    case SF_FORMAT_VORBIS:
      return "Vorbis";
    case SF_FORMAT_OPUS:
      return "Opus";
    case SF_FORMAT_MPEG_LAYER_I:
      return "MPEG layer I";
    case SF_FORMAT_MPEG_LAYER_II:
      return "MPEG layer II";
    case SF_FORMAT_MPEG_LAYER_III:
      return "MP3";
    case SF_FORMAT_GSM610:
      return "GSM 6.10";
    default:
      return {};
  }
}

std::string reason_of(SNDFILE* file) {
  std::string reason = sf_strerror(file);
  while (!reason.empty() && (reason.back() == '.' || reason.back() == '\n')) reason.pop_back();
  return reason;
}

std::string seconds(double n_frames, double rate_hz) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.4f s", n_frames / rate_hz);
  return text.data();
}

}  // namespace

void load_libsndfile() {
  std::array<char, 64> version{};
  sf_command(nullptr, SFC_GET_LIB_VERSION, version.data(), version.size());
}

struct SoundDecoder::State {
  ByteCursor cursor;
  std::string name;
  std::optional<HeaderRepair> repair;
  std::optional<FlacDecoder> flac;  // instead of the file, until there is an error
  SNDFILE* file = nullptr;
  SoundInfo info{};
  std::int64_t next_frame = 0;  // where libsndfile, or libFLAC, stands

  State(SoundBytes bytes, std::string name_) : cursor{bytes, 0, bytes.size()}, name(std::move(name_)) {
    if (const auto ogg = ogg_in_wav(cursor.bytes)) {
      cursor.begin = ogg->first;
      cursor.size = ogg->n_bytes;
    } else if ((repair = repair_header(cursor.bytes))) {
      cursor.patches = repair->patches;
    }
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() { close(); }

  void close() {
    if (file != nullptr) sf_close(std::exchange(file, nullptr));
  }

  SF_INFO open() {
    SF_VIRTUAL_IO io{size_of, seek, read_bytes, write_nothing, position_of};
    SF_INFO header{};
    cursor.at = 0;
    file = sf_open_virtual(&io, SFM_READ, &header, &cursor);
    if (file != nullptr) return header;
    check_bytes();
    throw NotForLibsndfile(name, reason_of(nullptr));
  }

  /// Begins again: a decoder that has seen the end may not find back.
  void reopen() {
    flac.reset();
    close();
    open();
    next_frame = 0;
  }

  void check_bytes() const {
    if (const int error = cursor.bytes.error(); error != 0)
      throw FileError(name, std::string("cannot be read (") + std::strerror(error) + "); copy it to a local disk");
  }

  /// libFLAC does not find every place of a long stream without a length or a table of places ("psf_fseek() failed"),
  /// and none any more after that: from the beginning then.
  void go_to(std::int64_t frame) {
    if (frame == next_frame) return;
    if (sf_seek(file, frame, SEEK_SET) == frame) {
      next_frame = frame;
      return;
    }
    go_to_from_beginning(frame);
  }

  void go_to_from_beginning(std::int64_t frame) {
    reopen();
    std::vector<float> piece(static_cast<std::size_t>(kFramesAtOnce * info.n_channels));
    for (sf_count_t got = 1; next_frame < frame && got > 0; next_frame += got)
      got = std::max<sf_count_t>(0, sf_readf_float(file, piece.data(), std::min(kFramesAtOnce, frame - next_frame)));
    check_bytes();
    if (next_frame < frame) throw FileError(name, ends_early(next_frame, info.n_frames));
  }

  bool open_flac() {
    flac = FlacDecoder::open(cursor.bytes);
    if (!flac) return false;
    const FlacDecoder::Format& format = flac->format();
    check_rate(format.rate_hz, name);
    info.rate_hz = format.rate_hz;
    info.n_channels = format.n_channels;
    info.n_frames = format.n_frames;
    info.may_be_infinite = false;
    info.can_begin_anywhere = true;
    info.description = format.n_bits == 16 ? kFlac16 : kFlac24;
    return true;
  }

  /// False where there is an error, which libsndfile is to find too: it may pass over what it is.
  bool read_flac(std::int64_t first, std::span<float> interleaved) {
    const bool goes_on = first == next_frame;
    if (flac->read(first, interleaved)) {
      next_frame = first + std::ssize(interleaved) / info.n_channels;
      return true;
    }
    if (goes_on)
      go_to_from_beginning(first);
    else
      reopen();
    return false;
  }

  /// Whether the last frame is there that the header promises; of damaged files the decoder may fail to go there.
  bool can_read_last() {
    std::vector<float> frame(static_cast<std::size_t>(info.n_channels));
    return sf_seek(file, info.n_frames - 1, SEEK_SET) == info.n_frames - 1 &&
           sf_readf_float(file, frame.data(), 1) == 1;
  }

  /// Coded sound that gives no number of frames, or a wrong one: to the end, and back.
  void take_what_is_there() {
    const std::int64_t n_promised = std::exchange(info.n_frames, count_frames(info.n_channels));
    if (info.n_frames == 0) throw FileError(name, "holds no samples; record again");
    reopen();
    // an MP3 without a table of contents has no number: libsndfile estimates it by the bit rate, to a block or two
    const bool is_estimate = info.lossy_coding == "MP3" && std::abs(info.n_frames - n_promised) <= 2 * kMp3Block_frames;
    if (info.n_frames != n_promised && !is_estimate)
      warn(n_promised == SF_COUNT_MAX ? std::nullopt : std::optional(n_promised));
  }

  void warn(std::optional<double> n_promised) {
    const std::string found =
        std::to_string(info.n_frames) + " samples (" + seconds(static_cast<double>(info.n_frames), info.rate_hz) + ")";
    if (!n_promised) {
      info.warning = "the header gives no length (written to a pipe, or not to its end?): the " + found +
                     " that are there were read";
      return;
    }
    std::array<char, 64> number{};
    std::snprintf(number.data(), number.size(), "%.0f", *n_promised);
    info.warning = std::string("the header promises ") + number.data() + " samples (" +
                   seconds(*n_promised, info.rate_hz) + "), the file holds " + found +
                   ": those were read; is it cut off?";
  }

  /// Frames of a stream that does not say how many it has.
  std::int64_t count_frames(int n_channels) {
    std::vector<float> piece(static_cast<std::size_t>(kFramesAtOnce) * static_cast<std::size_t>(n_channels));
    const std::int64_t n_most = cursor.size * kMostFramesPerByte;
    std::int64_t n = 0;
    for (std::int64_t got = 1; got > 0 && n <= n_most; n += std::max<std::int64_t>(got, 0))
      got = sf_readf_float(file, piece.data(), kFramesAtOnce);
    check_bytes();
    return n;
  }

  /// Where the plain samples lie: libsndfile goes to the byte of a frame without reading. Plain is given up where they
  /// are not next to each other, or not all in the file.
  void locate_plain() {
    if (info.plain == PlainEncoding::none) return;
    const std::int64_t frame_bytes = std::int64_t{bytes_per_sample(info.plain)} * info.n_channels;
    const auto byte_of = [&](std::int64_t frame) {
      return sf_seek(file, frame, SEEK_SET) == frame ? cursor.begin + cursor.at : std::int64_t{-1};
    };
    const std::int64_t second = byte_of(1);
    info.first_byte = byte_of(0);
    const bool fits = info.first_byte >= 0 && second == info.first_byte + frame_bytes &&
                      info.n_frames <= (cursor.bytes.size() - info.first_byte) / frame_bytes;
    if (!fits) info.plain = PlainEncoding::none;
  }
};

SoundDecoder::SoundDecoder(SoundBytes bytes, std::string name)
    : state_(std::make_unique<State>(bytes, std::move(name))) {
  State& s = *state_;
  if (s.open_flac()) return;
  const SF_INFO header = s.open();
  if (header.frames <= 0 || header.channels <= 0) throw FileError(s.name, "holds no samples; record again");
  check_rate(header.samplerate, s.name);
  s.info = {static_cast<double>(header.samplerate),
            header.channels,
            header.frames,
            !is_integer(header.format & SF_FORMAT_SUBMASK),
            false,
            plain_encoding(s.file, header.format),
            0,
            describe_format(header.format),
            lossy_coding_of(header.format),
            {}};
  if (s.repair) {
    const double frame_bytes = static_cast<double>(s.repair->n_held_bytes) / static_cast<double>(header.frames);
    const auto promised = s.repair->n_promised_bytes;
    s.warn(promised ? std::optional(static_cast<double>(*promised) / frame_bytes) : std::nullopt);
  }
  s.locate_plain();
  if (s.info.plain != PlainEncoding::none) return;
  const bool has_number = header.frames != SF_COUNT_MAX && header.frames / kMostFramesPerByte <= s.cursor.size;
  const bool is_right = has_number && s.can_read_last();
  s.reopen();
  if (!is_right) s.take_what_is_there();
  s.info.can_begin_anywhere = is_right && !s.repair && (header.format & SF_FORMAT_TYPEMASK) == SF_FORMAT_FLAC;
}

SoundDecoder::SoundDecoder(SoundDecoder&&) noexcept = default;
SoundDecoder& SoundDecoder::operator=(SoundDecoder&&) noexcept = default;
SoundDecoder::~SoundDecoder() = default;

const SoundInfo& SoundDecoder::info() const { return state_->info; }

void SoundDecoder::read(std::int64_t first, std::span<float> interleaved) {
  State& s = *state_;
  if (s.flac && s.read_flac(first, interleaved)) return;
  const std::int64_t n = std::ssize(interleaved) / s.info.n_channels;
  s.go_to(first);
  std::int64_t n_done = 0;
  for (std::int64_t got = 1; got > 0 && n_done < n; n_done += got)
    got = std::max<std::int64_t>(0, sf_readf_float(s.file, interleaved.data() + n_done * s.info.n_channels,
                                                   std::min(kFramesAtOnce, n - n_done)));
  s.next_frame = first + n_done;
  if (n_done == n) return;
  s.check_bytes();
  throw FileError(s.name, ends_early(s.next_frame, s.info.n_frames));
}

bool SoundDecoder::read_without_error(std::int64_t first, std::span<float> interleaved) {
  State& s = *state_;
  if (s.flac) return s.read_flac(first, interleaved);
  const std::int64_t n = std::ssize(interleaved) / s.info.n_channels;
  if (first != s.next_frame && sf_seek(s.file, first, SEEK_SET) != first) return false;
  s.next_frame = first;
  for (std::int64_t n_done = 0; n_done < n;) {
    const std::int64_t got =
        sf_readf_float(s.file, interleaved.data() + n_done * s.info.n_channels, std::min(kFramesAtOnce, n - n_done));
    if (got <= 0 || sf_error(s.file) != SF_ERR_NO_ERROR || s.cursor.bytes.error() != 0) return false;
    n_done += got;
    s.next_frame += got;
  }
  return true;
}

void SoundDecoder::begin_again() { state_->reopen(); }

void check_rate(double rate_hz, const std::string& name) {
  if (rate_hz >= kLowestRate_hz && rate_hz <= kHighestRate_hz) return;
  std::array<char, 64> rate{};
  std::snprintf(rate.data(), rate.size(), "%.10g", rate_hz);
  throw FileError(name, std::string("sampling rate ") + rate.data() +
                            " Hz: must be 4 kHz to 4 MHz; correct the header or record again");
}

std::string ends_early(std::int64_t at_frame, std::int64_t n_promised) {
  return "ends at sample " + std::to_string(at_frame) + " of the " + std::to_string(n_promised) +
         " its header promises; copy it again whole, or repair it: ffmpeg -i IN OUT.wav";
}

}  // namespace bouncelab::audio
