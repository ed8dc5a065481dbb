// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_decoder.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {

/// Where libsndfile stands in the bytes.
struct ByteCursor {
  SoundBytes bytes;
  bool is_unfinished_wav = false;
  std::int64_t at = 0;
};

namespace {

constexpr double kLowestRate_hz = 4e3;  // below, a contact of steel on glass (30 us) leaves nothing to time
constexpr double kHighestRate_hz = 4e6;
constexpr std::int64_t kFramesAtOnce = 1 << 14;  // 64 kB of one channel: stays in the cache
// FLAC packs best: a block of 65,535 equal samples into 10 bytes
constexpr std::int64_t kMostFramesPerByte = 1 << 16;

/// A WAV whose writer could not go back to write its length (a pipe), or had no time to: 0 in the file's head.
bool is_unfinished_wav(SoundBytes& bytes) {
  constexpr std::string_view kHead("RIFF\0\0\0\0WAVE", 12);
  std::array<std::byte, kHead.size()> head{};
  return bytes.read(0, head) == std::ssize(head) && std::memcmp(head.data(), kHead.data(), kHead.size()) == 0;
}

sf_count_t size_of(void* cursor) { return static_cast<ByteCursor*>(cursor)->bytes.size(); }

sf_count_t seek(sf_count_t offset, int whence, void* user) {
  ByteCursor& cursor = *static_cast<ByteCursor*>(user);
  const std::int64_t from = whence == SEEK_CUR ? cursor.at : whence == SEEK_END ? cursor.bytes.size() : 0;
  std::int64_t to = 0;
  if (__builtin_add_overflow(from, offset, &to) || to < 0) return -1;
  return cursor.at = to;
}

sf_count_t read_bytes(void* to, sf_count_t n, void* user) {
  ByteCursor& cursor = *static_cast<ByteCursor*>(user);
  if (n <= 0) return 0;
  const std::int64_t got = cursor.bytes.read(cursor.at, {static_cast<std::byte*>(to), static_cast<std::size_t>(n)});
  // libsndfile takes a length of 8 for unfinished, but not 0: then it goes by the file's length as it should
  if (cursor.is_unfinished_wav && cursor.at <= 4 && cursor.at + got > 4)
    static_cast<std::byte*>(to)[4 - cursor.at] = std::byte{8};
  cursor.at += got;
  return got;
}

sf_count_t write_nothing(const void*, sf_count_t, void*) { return 0; }

sf_count_t position_of(void* cursor) { return static_cast<ByteCursor*>(cursor)->at; }

/// The ISO base media signature of m4a, mp4, mov.
bool is_mpeg4(SoundBytes& bytes) {
  std::array<std::byte, 8> head{};
  return bytes.read(0, head) == std::ssize(head) && std::memcmp(head.data() + 4, "ftyp", 4) == 0;
}

/// libsndfile reads a truncated WAV without an error; only its log shows the length given in the header:
/// "data : 1000 (should be 500)". Streamed files (ffmpeg to a pipe) give 2^32-1 or 0, which is not an error.
void check_promised_length(SNDFILE* file, const std::string& name) {
  std::array<char, 16384> log{};
  sf_command(file, SFC_GET_LOG_INFO, log.data(), log.size());
  const std::string text(log.data());
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    line.erase(0, std::min(line.find_first_not_of(' '), line.size()));
    const std::size_t correction = line.find("(should be ");
    if (line.rfind("data", 0) != 0 && line.rfind("SSND", 0) != 0 && line.rfind("Data Size", 0) != 0) continue;
    const std::size_t colon = line.find(':');
    if (correction == std::string::npos || colon == std::string::npos) continue;
    const double promised = std::atof(line.c_str() + colon + 1);
    const double held = std::atof(line.c_str() + correction + 11);
    if (promised > held && promised < 4294967000.0)
      throw FileError(name, "the header promises " + std::to_string(static_cast<long long>(promised)) +
                                " bytes of source, the file holds " + std::to_string(static_cast<long long>(held)) +
                                "; copy it again whole, or repair it: ffmpeg -i IN OUT.wav");
  }
}

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

std::string unreadable(SNDFILE* file) {
  std::string reason = sf_strerror(file);
  while (!reason.empty() && (reason.back() == '.' || reason.back() == '\n')) reason.pop_back();
  return "not readable as audio (" + reason + "); convert it: ffmpeg -i IN OUT.wav";
}

}  // namespace

struct SoundDecoder::State {
  ByteCursor cursor;
  std::string name;
  SNDFILE* file = nullptr;
  SoundInfo info{};
  std::int64_t next_frame = 0;  // where libsndfile stands

  State(SoundBytes bytes, std::string name_) : cursor{bytes, is_unfinished_wav(bytes)}, name(std::move(name_)) {}
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
    if (is_mpeg4(cursor.bytes))
      throw FileError(
          name, "is MPEG-4 audio (m4a), which libsndfile cannot read; convert it: ffmpeg -i \"" + name + "\" out.wav");
    throw FileError(name, unreadable(nullptr));
  }

  void check_bytes() const {
    if (const int error = cursor.bytes.error(); error != 0)
      throw FileError(name, std::string("cannot be read (") + std::strerror(error) + "); copy it to a local disk");
  }

  /// Frames of a stream that does not say how many it has.
  std::int64_t count_frames(int n_channels) {
    std::vector<float> piece(static_cast<std::size_t>(kFramesAtOnce) * static_cast<std::size_t>(n_channels));
    const std::int64_t n_most = cursor.bytes.size() * kMostFramesPerByte;
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
      return sf_seek(file, frame, SEEK_SET) == frame ? cursor.at : std::int64_t{-1};
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
  const SF_INFO header = s.open();
  check_promised_length(s.file, s.name);
  if (header.frames <= 0 || header.channels <= 0) throw FileError(s.name, "holds no samples; record again");
  if (header.samplerate < kLowestRate_hz || header.samplerate > kHighestRate_hz)
    throw FileError(s.name, "sampling rate " + std::to_string(header.samplerate) +
                                " Hz: must be 4 kHz to 4 MHz; correct the header or record again");
  s.info = {static_cast<double>(header.samplerate),
            header.channels,
            header.frames,
            !is_integer(header.format & SF_FORMAT_SUBMASK),
            plain_encoding(s.file, header.format),
            0,
            describe_format(header.format)};
  if (header.frames == SF_COUNT_MAX) {
    s.info.n_frames = s.count_frames(header.channels);
    if (s.info.n_frames == 0) throw FileError(s.name, "holds no samples; record again");
    s.close();  // the decoder has seen the end, and would have to be told to begin again
    s.open();
  }
  if (s.info.n_frames / kMostFramesPerByte > bytes.size())
    throw FileError(s.name, "the header promises " + std::to_string(s.info.n_frames) + " samples in " +
                                std::to_string(bytes.size()) +
                                " bytes; copy it again whole, or repair it: ffmpeg -i IN OUT.wav");
  s.locate_plain();
}

SoundDecoder::SoundDecoder(SoundDecoder&&) noexcept = default;
SoundDecoder& SoundDecoder::operator=(SoundDecoder&&) noexcept = default;
SoundDecoder::~SoundDecoder() = default;

const SoundInfo& SoundDecoder::info() const { return state_->info; }

void SoundDecoder::read(std::int64_t first, std::span<float> interleaved) {
  State& s = *state_;
  const std::int64_t n = std::ssize(interleaved) / s.info.n_channels;
  if (first != s.next_frame && sf_seek(s.file, first, SEEK_SET) != first)
    throw FileError(s.name, "cannot go to sample " + std::to_string(first) + ": " + sf_strerror(s.file));
  std::int64_t n_done = 0;
  for (std::int64_t got = 1; got > 0 && n_done < n; n_done += got)
    got = std::max<std::int64_t>(0, sf_readf_float(s.file, interleaved.data() + n_done * s.info.n_channels,
                                                   std::min(kFramesAtOnce, n - n_done)));
  s.next_frame = first + n_done;
  if (n_done == n) return;
  s.check_bytes();
  throw FileError(s.name, ends_early(s.next_frame, s.info.n_frames));
}

std::string ends_early(std::int64_t at_frame, std::int64_t n_promised) {
  return "ends at sample " + std::to_string(at_frame) + " of the " + std::to_string(n_promised) +
         " its header promises; copy it again whole, or repair it: ffmpeg -i IN OUT.wav";
}

}  // namespace bouncelab::audio
