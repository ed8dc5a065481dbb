// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_header.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

constexpr int kMostChunks = 1000;  // some writers add a dozen; chunks may also lead round in a circle
// What follows the samples and is no chunk: up to this the padding or the tags of some writers (ID3v1: 128 bytes), and
// less than 0.1 s of sound in any case. libsndfile leaves it out, and so do we. Nor is it told when so much is missing:
// some writers count the header among the samples.
constexpr std::int64_t kMostPadding_bytes = 4096;
constexpr std::int64_t kMostPlainChannels = 1024;  // of libsndfile

enum class Kind { other, riff, rf64, w64 };

Kind kind_of(FileBytes& bytes) {
  const std::string head = bytes.text(0, 40);
  if (head.starts_with("riff") && head.size() == 40 && head.compare(24, 4, "wave") == 0) return Kind::w64;
  if (head.size() < 12 || head.compare(8, 4, "WAVE") != 0) return Kind::other;
  return head.starts_with("RIFF") ? Kind::riff : head.starts_with("RF64") ? Kind::rf64 : Kind::other;
}

ChunkLayout layout_of(Kind kind) { return kind == Kind::w64 ? ChunkLayout{40, 16, 8, true, 8} : ChunkLayout{}; }

/// What was read of a file up to its samples.
struct Samples {
  int format = 0;  // of libsndfile: container, coding, order of bytes; no coding: not plain
  double rate_hz = 0.0;
  std::int64_t n_channels = 0;
  std::int64_t frame_bytes = 0;  // or bytes of a block, of what is coded in blocks
  std::int64_t begin = 0;
  std::uint64_t promised = 0;  // bytes
  bool has_64_bits = false;    // the length
};

struct PlainCoding {
  std::uint64_t tag, n_bits;
  int coding;
};
constexpr std::array<PlainCoding, 6> kPlainCodings{{{1, 8, SF_FORMAT_PCM_U8},
                                                    {1, 16, SF_FORMAT_PCM_16},
                                                    {1, 24, SF_FORMAT_PCM_24},
                                                    {1, 32, SF_FORMAT_PCM_32},
                                                    {3, 32, SF_FORMAT_FLOAT},
                                                    {3, 64, SF_FORMAT_DOUBLE}}};

/// The content of the chunk `fmt `: tag, channels, rate, bytes a second, bytes a frame, bits; where the
/// tag says so, a longer one with the tag at the begin of an identifier of 16 bytes.
void take_format(std::string_view content, Kind kind, Samples& s) {
  constexpr std::string_view kRestOfIdentifier("\x00\x00\x00\x00\x10\x00\x80\x00\x00\xAA\x00\x38\x9B\x71", 14);
  const auto number = [&](std::size_t at, std::size_t n) { return number_in(content.substr(at, n)); };
  s.format = 0;  // a second chunk replaces the first whole
  if (content.size() < 16) return;
  std::uint64_t tag = number(0, 2);
  const bool is_extensible = tag == 0xFFFE;
  if (is_extensible && content.size() >= 40 && content.substr(26, 14) == kRestOfIdentifier) tag = number(24, 2);
  const std::uint64_t n_bits = number(14, 2);
  s.n_channels = static_cast<std::int64_t>(number(2, 2));
  s.rate_hz = static_cast<double>(number(4, 4));
  s.frame_bytes = static_cast<std::int64_t>(number(12, 2));
  const auto* const plain = std::find_if(kPlainCodings.begin(), kPlainCodings.end(),
                                         [&](const PlainCoding& p) { return p.tag == tag && p.n_bits == n_bits; });
  if (plain == kPlainCodings.end() || s.frame_bytes != s.n_channels * static_cast<std::int64_t>(n_bits / 8)) return;
  const int container = kind == Kind::rf64  ? SF_FORMAT_RF64
                        : kind == Kind::w64 ? SF_FORMAT_W64
                        : is_extensible     ? SF_FORMAT_WAVEX
                                            : SF_FORMAT_WAV;
  s.format = container | plain->coding | SF_ENDIAN_LITTLE;
}

std::optional<Samples> samples_in(FileBytes& bytes) {
  constexpr std::size_t kMostOfFormat = 64;
  const Kind kind = kind_of(bytes);
  const ChunkLayout layout = layout_of(kind);
  if (kind == Kind::other) return std::nullopt;
  Samples s;
  std::optional<std::uint64_t> length_64;
  std::int64_t at = layout.first_chunk;
  for (int k = 0; k < kMostChunks; ++k) {
    const std::optional<Chunk> chunk = chunk_at(bytes, layout, at);
    if (!chunk) return std::nullopt;
    if (chunk->name == "data") {
      s.begin = chunk->begin;
      s.has_64_bits = kind == Kind::w64 || length_64;
      s.promised = length_64 && chunk->length == 0xFFFFFFFF ? *length_64 : chunk->length;
      return s.frame_bytes > 0 ? std::optional(s) : std::nullopt;
    }
    const std::string content =
        bytes.text(chunk->begin, static_cast<std::size_t>(std::min<std::uint64_t>(chunk->length, kMostOfFormat)));
    if (chunk->name == "fmt ") take_format(content, kind, s);
    if (chunk->name == "ds64" && kind == Kind::rf64 && content.size() >= 16)
      length_64 = number_in(std::string_view(content).substr(8, 8));
    if (chunk->length > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
    at = layout.next(chunk->begin, static_cast<std::int64_t>(chunk->length));
  }
  return std::nullopt;
}

/// Whether a chunk begins there that lies in the file, or one that is known to follow samples and was cut off.
bool is_chunk(FileBytes& bytes, const ChunkLayout& layout, std::int64_t at) {
  const std::optional<Chunk> chunk = chunk_at(bytes, layout, at);
  if (!chunk) return false;
  constexpr std::array<std::string_view, 6> kKnown{"LIST", "list", "id3 ", "ID3 ", "bext", "cue "};
  if (std::find(kKnown.begin(), kKnown.end(), chunk->name) != kKnown.end()) return true;
  const bool is_printable =
      std::all_of(chunk->name.begin(), chunk->name.end(), [](char c) { return c >= ' ' && c <= '~'; });
  return is_printable && chunk->length <= static_cast<std::uint64_t>(bytes.size() - chunk->begin);
}

/// Lengths that stand for none: what is left where nobody came back to write it (0; all bits, or all but the highest,
/// or some less for the header's own length).
bool is_no_length(std::uint64_t promised, bool has_64_bits) {
  const std::uint64_t all = has_64_bits ? ~std::uint64_t{0} : 0xFFFFFFFF;
  return promised == 0 || promised >= all - 0x10000 ||
         (promised >= (all >> 1) - 0x1000000 && promised <= (all >> 1) + 1);
}

/// Bytes, where the header gives a length.
std::optional<double> length_of(const Samples& s) {
  if (is_no_length(s.promised, s.has_64_bits) || s.promised > INT64_MAX) return std::nullopt;
  return static_cast<double>(s.promised);
}

/// Whether what follows the samples that are promised is sound too.
bool is_longer_than_promised(FileBytes& bytes, const Samples& s) {
  const ChunkLayout layout = layout_of(kind_of(bytes));
  const auto promised = static_cast<std::int64_t>(s.promised);
  const std::int64_t end = layout.next(s.begin, promised);
  return bytes.size() - end > (promised > 0 ? kMostPadding_bytes : 0) && !is_chunk(bytes, layout, end) &&
         !is_chunk(bytes, layout, s.begin + promised);
}

/// How many frames (or blocks) there are where they are not as many as promised.
std::optional<std::int64_t> held_instead(FileBytes& bytes, const Samples& s) {
  const auto n_held = static_cast<std::uint64_t>((bytes.size() - s.begin) / s.frame_bytes);
  const std::uint64_t n_promised = s.promised / static_cast<std::uint64_t>(s.frame_bytes);
  if (n_promised > n_held || (n_promised < n_held && is_longer_than_promised(bytes, s)))
    return static_cast<std::int64_t>(n_held);
  return std::nullopt;
}

}  // namespace

std::uint64_t number_in(std::string_view text) {
  std::uint64_t value = 0;
  for (auto byte = text.rbegin(); byte != text.rend(); ++byte) value = value << 8 | static_cast<unsigned char>(*byte);
  return value;
}

std::string bytes_of_number(std::uint64_t value, int n_bytes) {
  std::string text;
  for (int k = 0; k < n_bytes; ++k, value >>= 8) text += static_cast<char>(value & 0xFF);
  return text;
}

std::optional<Chunk> chunk_at(FileBytes& bytes, const ChunkLayout& layout, std::int64_t at) {
  const std::string head = bytes.text(at, static_cast<std::size_t>(layout.head_bytes()));
  if (std::ssize(head) < layout.head_bytes()) return std::nullopt;
  std::uint64_t length = number_in(std::string_view(head).substr(layout.name_bytes));
  if (layout.counts_head) length -= std::min(length, static_cast<std::uint64_t>(layout.head_bytes()));
  return Chunk{head.substr(0, 4), at + layout.head_bytes(), length};
}

std::optional<PlainSound> plain_sound(FileBytes& bytes) {
  const std::optional<Samples> s = samples_in(bytes);
  if (!s || s->format == 0 || s->n_channels <= 0 || s->n_channels > kMostPlainChannels) return std::nullopt;
  if (bytes.size() <= s->begin) return std::nullopt;
  PlainSound sound;
  SoundInfo& info = sound.info;
  const std::optional<std::int64_t> held = held_instead(bytes, *s);
  info.n_frames = held.value_or(static_cast<std::int64_t>(s->promised / static_cast<std::uint64_t>(s->frame_bytes)));
  if (info.n_frames == 0) throw FileError(bytes.name(), "holds no samples; record again");
  check_rate(s->rate_hz, bytes.name());
  info.rate_hz = s->rate_hz;
  info.n_channels = static_cast<int>(s->n_channels);
  info.description = description_of(s->format);
  sound.coding = s->format & (SF_FORMAT_SUBMASK | SF_FORMAT_ENDMASK);
  const int coding = s->format & SF_FORMAT_SUBMASK;
  info.may_be_infinite = coding == SF_FORMAT_FLOAT || coding == SF_FORMAT_DOUBLE;
  sound.sample_bytes = static_cast<std::size_t>(s->frame_bytes / s->n_channels);
  sound.first_byte = s->begin;
  std::optional<double> n_promised = length_of(*s);
  if (n_promised) *n_promised /= static_cast<double>(s->frame_bytes);
  const double missing_bytes =
      n_promised ? (*n_promised - static_cast<double>(info.n_frames)) * static_cast<double>(s->frame_bytes) : 0.0;
  if (held && !(missing_bytes > 0.0 && missing_bytes <= kMostPadding_bytes))
    info.warning = wrong_length(info, n_promised);
  return sound;
}

std::optional<CodedLength> coded_length(FileBytes& bytes) {
  const std::optional<Samples> s = kind_of(bytes) == Kind::riff ? samples_in(bytes) : std::nullopt;
  const std::optional<std::int64_t> held = s ? held_instead(bytes, *s) : std::nullopt;
  if (!held) return std::nullopt;
  return CodedLength{s->begin - 4, *held * s->frame_bytes, length_of(*s)};
}

namespace {

/// Where the bytes that a file begins with come again: a recorder, or an encoder, begins each file alike.
std::optional<std::int64_t> second_beginning(FileBytes& bytes) {
  constexpr std::int64_t kOggBeginnings_bytes = 4096;  // streams side by side begin together
  const std::string head = bytes.text(0, 64);
  const bool is_frame = head.size() == 64 && head[0] == '\xFF' && (head[1] & 0xE0) == 0xE0;
  std::size_t at = std::string::npos, n = 8;
  std::int64_t from = 1;
  if (head.starts_with("fLaC")) at = 0;
  if (head.starts_with("OggS")) at = 0, n = 6, from = kOggBeginnings_bytes;
  if (head.substr(0, 8).ends_with("ftyp")) at = 4;
  if (head.starts_with("FORM")) at = 8;
  if (head.starts_with("ID3")) at = 0, n = 5;
  if (is_frame) at = std::min(head.find("Xing"), head.find("Info"));  // how many frames follow: once in an MP3
  if (at == std::string::npos || at + n > head.size()) return std::nullopt;
  const std::string mark = head.substr(at, n);
  constexpr std::size_t kPiece = 1 << 20;
  for (std::int64_t first = from + static_cast<std::int64_t>(at); first < bytes.size(); first += kPiece)
    if (const std::size_t found = bytes.text(first, kPiece + n - 1).find(mark); found != std::string::npos)
      return first + static_cast<std::int64_t>(found) - static_cast<std::int64_t>(at);
  return std::nullopt;
}

/// Behind the samples of a file of chunks another such file, or more samples.
std::optional<std::int64_t> second_in_chunks(FileBytes& bytes) {
  const std::optional<Samples> s = samples_in(bytes);
  if (!s || s->promised > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
  const ChunkLayout layout = layout_of(kind_of(bytes));
  std::int64_t next = layout.next(s->begin, static_cast<std::int64_t>(s->promised));
  for (int n = 0; n < kMostChunks; ++n) {
    const std::optional<Chunk> chunk = chunk_at(bytes, layout, next);
    if (!chunk || chunk->length > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
    constexpr std::array<std::string_view, 4> kSoundChunks{"RIFF", "RF64", "riff", "data"};
    if (chunk->length > 0 && std::find(kSoundChunks.begin(), kSoundChunks.end(), chunk->name) != kSoundChunks.end())
      return next;
    next = layout.next(chunk->begin, static_cast<std::int64_t>(chunk->length));
  }
  return std::nullopt;
}

}  // namespace

std::string what_follows(FileBytes& bytes) {
  const std::optional<std::int64_t> at =
      kind_of(bytes) == Kind::other ? second_beginning(bytes) : second_in_chunks(bytes);
  if (!at) return {};
  return "more sound follows at byte " + std::to_string(*at) +
         " (files joined, or a recorder that paused?) and is left out; cut the file there to analyze it";
}

std::optional<EmbeddedFile> ogg_in_wav(FileBytes& bytes) {
  const std::optional<Samples> s = samples_in(bytes);
  if (!s || bytes.text(s->begin, 4) != "OggS") return std::nullopt;
  const std::int64_t available = bytes.size() - s->begin;
  const bool is_given = s->promised > 0 && s->promised <= static_cast<std::uint64_t>(available);
  return EmbeddedFile{s->begin, is_given ? static_cast<std::int64_t>(s->promised) : available};
}

void check_rate(double rate_hz, const std::string& name) {
  if (rate_hz >= kLowestRate_hz && rate_hz <= kHighestRate_hz) return;
  throw FileError(name, formatted("sampling rate %.10g Hz", rate_hz) +
                            ": must be 4 kHz to 4 MHz; correct the header or record again");
}

std::string ends_early(std::int64_t at_frame, std::int64_t n_promised) {
  return "ends at sample " + std::to_string(at_frame) + " of the " + std::to_string(n_promised) +
         " its header promises; copy it again whole, or repair it: ffmpeg -i IN OUT.wav";
}

std::string wrong_length(const SoundInfo& found, std::optional<double> n_promised) {
  const auto samples = [&](double n) { return formatted("%.0f samples (%.4f s)", n, n / found.rate_hz); };
  const std::string held = samples(static_cast<double>(found.n_frames));
  if (!n_promised)
    return "the header gives no length (written to a pipe, or not to its end?): the " + held +
           " that are there were read";
  return "the header promises " + samples(*n_promised) + ", the file holds " + held + ": those were read" +
         (static_cast<double>(found.n_frames) < *n_promised ? "; is it cut off?" : "");
}

}  // namespace bouncelab::audio
