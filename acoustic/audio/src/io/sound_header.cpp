// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/sound_header.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "bouncelab/core/error.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {
namespace {

constexpr int kMostChunks = 1000;  // some writers add a dozen; chunks may also lead round in a circle
// What follows the samples and is no chunk: up to this the padding or the tags of some writers (ID3v1: 128 bytes), and
// less than 0.1 s of sound in any case. libsndfile leaves it out, and so do we. Nor is it told when so much is missing:
// some writers count the header among the samples.
constexpr std::int64_t kMostPadding_bytes = 4096;
constexpr std::int64_t kMostPlainChannels = 1024;  // of libsndfile

enum class Kind { other, riff, rf64, w64, aiff, au };

Kind kind_of(SoundBytes& bytes) {
  const std::string head = bytes.text(0, 40);
  if (head.size() < 12) return Kind::other;
  const std::string_view name(head.data(), 4), type(head.data() + 8, 4);
  if (name == "RIFF" && type == "WAVE") return Kind::riff;
  if (name == "RF64" && type == "WAVE") return Kind::rf64;
  if (name == "riff" && head.size() == 40 && head.compare(24, 4, "wave") == 0) return Kind::w64;
  if (name == "FORM" && (type == "AIFF" || type == "AIFC")) return Kind::aiff;
  return name == ".snd" || name == "dns." ? Kind::au : Kind::other;
}

ChunkLayout layout_of(Kind kind) {
  if (kind == Kind::w64) return {40, 16, 8, false, true, 8};
  ChunkLayout layout;
  layout.is_big_endian = kind == Kind::aiff;
  return layout;
}

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

int integers_of(std::uint64_t n_bits) {
  switch (n_bits) {
    case 16:
      return SF_FORMAT_PCM_16;
    case 24:
      return SF_FORMAT_PCM_24;
    case 32:
      return SF_FORMAT_PCM_32;
    default:
      return 0;
  }
}

int floats_of(std::uint64_t n_bits) { return n_bits == 32 ? SF_FORMAT_FLOAT : n_bits == 64 ? SF_FORMAT_DOUBLE : 0; }

/// The content of the chunk `fmt ` of WAV and W64: tag, channels, rate, bytes a second, bytes a frame, bits; where the
/// tag says so, a longer one with the tag at the begin of an identifier of 16 bytes.
void take_wav_format(std::string_view content, Kind kind, Samples& s) {
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
  const int integers = n_bits == 8 ? SF_FORMAT_PCM_U8 : integers_of(n_bits);
  const int coding = tag == 1 ? integers : tag == 3 ? floats_of(n_bits) : 0;
  if (coding == 0 || s.frame_bytes != s.n_channels * static_cast<std::int64_t>(n_bits / 8)) return;
  const int container = kind == Kind::rf64  ? SF_FORMAT_RF64
                        : kind == Kind::w64 ? SF_FORMAT_W64
                        : is_extensible     ? SF_FORMAT_WAVEX
                                            : SF_FORMAT_WAV;
  s.format = container | coding | SF_ENDIAN_LITTLE;
}

/// The content of the chunk `COMM` of AIFF: channels, frames, bits, rate as an extended float, coding of AIFC.
void take_aiff_format(std::string_view content, Samples& s) {
  const auto number = [&](std::size_t at, std::size_t n) { return number_in(content.substr(at, n), true); };
  s.format = 0;
  if (content.size() < 18) return;
  const std::uint64_t n_bits = number(6, 2);
  const std::string_view coding = content.size() >= 22 ? content.substr(18, 4) : "NONE";
  s.n_channels = static_cast<std::int64_t>(number(0, 2));
  const int exponent = static_cast<int>(number(8, 2) & 0x7FFF) - 16383;
  s.rate_hz = std::floor(std::ldexp(static_cast<double>(number(10, 8)), std::clamp(exponent, -100, 100) - 63));
  s.frame_bytes = s.n_channels * static_cast<std::int64_t>((n_bits + 7) / 8);
  const int integers = n_bits == 8 ? SF_FORMAT_PCM_S8 : integers_of(n_bits);
  int found = 0;
  if (coding == "NONE" || coding == "twos" || coding == "sowt") found = integers;
  if ((coding == "fl32" || coding == "FL32") && n_bits == 32) found = SF_FORMAT_FLOAT;
  if (coding == "fl64" && n_bits == 64) found = SF_FORMAT_DOUBLE;
  if (found != 0) s.format = SF_FORMAT_AIFF | found | (coding == "sowt" ? SF_ENDIAN_LITTLE : SF_ENDIAN_BIG);
}

std::optional<Samples> samples_in_chunks(SoundBytes& bytes, Kind kind) {
  constexpr std::size_t kMostOfFormat = 64;
  const ChunkLayout layout = layout_of(kind);
  Samples s;
  s.has_64_bits = kind == Kind::w64;
  std::optional<std::uint64_t> length_64;
  std::int64_t at = layout.first_chunk;
  for (int k = 0; k < kMostChunks; ++k) {
    const std::optional<Chunk> chunk = chunk_at(bytes, layout, at);
    if (!chunk) return std::nullopt;
    if (chunk->name == (kind == Kind::aiff ? "SSND" : "data")) {
      // two numbers come first; one of them is of bytes before the first frame
      const std::int64_t offset =
          kind == Kind::aiff ? 8 + static_cast<std::int64_t>(number_in(bytes.text(chunk->begin, 4), true)) : 0;
      s.begin = chunk->begin + offset;
      s.promised = chunk->length - std::min(chunk->length, static_cast<std::uint64_t>(offset));
      s.has_64_bits |= length_64.has_value();
      if (length_64 && chunk->length == 0xFFFFFFFF) s.promised = *length_64;
      return s.frame_bytes > 0 ? std::optional(s) : std::nullopt;
    }
    const std::string content =
        bytes.text(chunk->begin, static_cast<std::size_t>(std::min<std::uint64_t>(chunk->length, kMostOfFormat)));
    if (chunk->name == "fmt ") take_wav_format(content, kind, s);
    if (chunk->name == "COMM") take_aiff_format(content, s);
    if (chunk->name == "ds64" && kind == Kind::rf64 && content.size() >= 16)
      length_64 = number_in(std::string_view(content).substr(8, 8));
    if (chunk->length > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
    at = layout.next(chunk->begin, static_cast<std::int64_t>(chunk->length));
  }
  return std::nullopt;
}

/// AU: name, begin, length, coding, rate, channels; no chunks.
std::optional<Samples> samples_in_au(SoundBytes& bytes) {
  const std::string head = bytes.text(0, 24);
  if (head.size() < 24) return std::nullopt;
  const bool is_big_endian = head[0] == '.';
  const auto number = [&](std::size_t at) { return number_in(std::string_view(head).substr(at, 4), is_big_endian); };
  constexpr std::array<std::pair<int, int>, 6> kCodings{{{SF_FORMAT_PCM_S8, 1},
                                                         {SF_FORMAT_PCM_16, 2},
                                                         {SF_FORMAT_PCM_24, 3},
                                                         {SF_FORMAT_PCM_32, 4},
                                                         {SF_FORMAT_FLOAT, 4},
                                                         {SF_FORMAT_DOUBLE, 8}}};  // from number 2 on
  const std::uint64_t coding = number(12) - 2;
  if (coding >= kCodings.size() || number(4) < 24 || number(8) == 0) return std::nullopt;
  const auto& [format, n_bytes] = kCodings[coding];
  Samples s;
  s.format = SF_FORMAT_AU | format | (is_big_endian ? SF_ENDIAN_BIG : SF_ENDIAN_LITTLE);
  s.rate_hz = static_cast<double>(number(16));
  s.n_channels = static_cast<std::int64_t>(number(20));
  s.frame_bytes = s.n_channels * n_bytes;
  s.begin = static_cast<std::int64_t>(number(4));
  s.promised = number(8);
  return s;
}

/// Whether a chunk begins there that lies in the file, or one that is known to follow samples and was cut off.
bool is_chunk(SoundBytes& bytes, const ChunkLayout& layout, std::int64_t at) {
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
bool is_longer_than_promised(SoundBytes& bytes, Kind kind, const Samples& s) {
  if (kind == Kind::au) return false;  // has no chunks: what follows its samples may be anything
  const ChunkLayout layout = layout_of(kind);
  const auto promised = static_cast<std::int64_t>(s.promised);
  const std::int64_t end = layout.next(s.begin, promised);
  return bytes.size() - end > (promised > 0 ? kMostPadding_bytes : 0) && !is_chunk(bytes, layout, end) &&
         !is_chunk(bytes, layout, s.begin + promised);
}

/// How many frames (or blocks) there are where they are not as many as promised.
std::optional<std::int64_t> held_instead(SoundBytes& bytes, Kind kind, const Samples& s) {
  const auto n_held = static_cast<std::uint64_t>((bytes.size() - s.begin) / s.frame_bytes);
  const std::uint64_t n_promised = s.promised / static_cast<std::uint64_t>(s.frame_bytes);
  if (n_promised > n_held || (n_promised < n_held && is_longer_than_promised(bytes, kind, s)))
    return static_cast<std::int64_t>(n_held);
  return std::nullopt;
}

}  // namespace

std::uint64_t number_in(std::string_view text, bool is_big_endian) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < text.size(); ++k)
    value = value << 8 | static_cast<unsigned char>(text[is_big_endian ? k : text.size() - 1 - k]);
  return value;
}

std::string bytes_of_number(std::uint64_t value, int n_bytes) {
  std::string text;
  for (int k = 0; k < n_bytes; ++k, value >>= 8) text += static_cast<char>(value & 0xFF);
  return text;
}

std::optional<Chunk> chunk_at(SoundBytes& bytes, const ChunkLayout& layout, std::int64_t at) {
  const std::string head = bytes.text(at, static_cast<std::size_t>(layout.head_bytes()));
  if (std::ssize(head) < layout.head_bytes()) return std::nullopt;
  std::uint64_t length = number_in(std::string_view(head).substr(layout.name_bytes), layout.is_big_endian);
  if (layout.counts_head) length -= std::min(length, static_cast<std::uint64_t>(layout.head_bytes()));
  return Chunk{head.substr(0, 4), at + layout.head_bytes(), length};
}

std::optional<PlainSound> plain_sound(SoundBytes& bytes, const std::string& name) {
  const Kind kind = kind_of(bytes);
  if (kind == Kind::other) return std::nullopt;
  const std::optional<Samples> s = kind == Kind::au ? samples_in_au(bytes) : samples_in_chunks(bytes, kind);
  if (!s || s->format == 0 || s->n_channels <= 0 || s->n_channels > kMostPlainChannels) return std::nullopt;
  if (bytes.size() <= s->begin) return std::nullopt;
  PlainSound sound;
  SoundInfo& info = sound.info;
  const std::optional<std::int64_t> held = held_instead(bytes, kind, *s);
  info.n_frames = held.value_or(static_cast<std::int64_t>(s->promised / static_cast<std::uint64_t>(s->frame_bytes)));
  if (info.n_frames == 0) throw FileError(name, "holds no samples; record again");
  check_rate(s->rate_hz, name);
  info.rate_hz = s->rate_hz;
  info.n_channels = static_cast<int>(s->n_channels);
  info.description = description_of(s->format);
  sound.coding = s->format & (SF_FORMAT_SUBMASK | SF_FORMAT_ENDMASK);
  const int coding = s->format & SF_FORMAT_SUBMASK;
  info.may_be_infinite = coding == SF_FORMAT_FLOAT || coding == SF_FORMAT_DOUBLE;
  sound.first_byte = s->begin;
  std::optional<double> n_promised = length_of(*s);
  if (n_promised) *n_promised /= static_cast<double>(s->frame_bytes);
  const double missing_bytes =
      n_promised ? (*n_promised - static_cast<double>(info.n_frames)) * static_cast<double>(s->frame_bytes) : 0.0;
  if (held && !(missing_bytes > 0.0 && missing_bytes <= kMostPadding_bytes))
    info.warning = wrong_length(info, n_promised);
  return sound;
}

std::optional<CodedLength> coded_length(SoundBytes& bytes) {
  if (kind_of(bytes) != Kind::riff) return std::nullopt;
  const std::optional<Samples> s = samples_in_chunks(bytes, Kind::riff);
  const std::optional<std::int64_t> held = s ? held_instead(bytes, Kind::riff, *s) : std::nullopt;
  if (!held) return std::nullopt;
  return CodedLength{s->begin - 4, *held * s->frame_bytes, length_of(*s)};
}

namespace {

/// The first place of `mark` behind the first byte that `is_it` accepts, which gets the place and the bytes from there.
template <class IsIt>
std::optional<std::int64_t> place_of(SoundBytes& bytes, std::string_view mark, const IsIt& is_it) {
  constexpr std::size_t kPiece = 1 << 20, kBehind = 8;
  for (std::int64_t first = 1; first < bytes.size(); first += kPiece) {
    const std::string piece = bytes.text(first, kPiece + kBehind);
    for (std::size_t at = piece.find(mark); at < kPiece; at = piece.find(mark, at + 1)) {
      const std::int64_t place = first + static_cast<std::int64_t>(at);
      const std::string_view text = std::string_view(piece).substr(at, kBehind);
      if (text.size() == kBehind && is_it(place, text)) return place;
    }
  }
  return std::nullopt;
}

/// A second FLAC: its first block of metadata has 34 bytes, and says so.
std::optional<std::int64_t> second_flac(SoundBytes& bytes) {
  return place_of(bytes, "fLaC", [](std::int64_t, std::string_view text) {
    return text.substr(5) == std::string_view("\0\0\x22", 3) && (text[4] & 0x7F) == 0;
  });
}

/// A page that begins a stream, behind one that goes on: streams side by side begin together.
std::optional<std::int64_t> second_ogg(SoundBytes& bytes) {
  bool has_gone_on = false;
  return place_of(bytes, "OggS", [&](std::int64_t, std::string_view text) {
    if (text[4] != '\0') return false;
    const bool begins = (text[5] & 2) != 0;
    has_gone_on = has_gone_on || !begins;
    return begins && has_gone_on;
  });
}

/// A second frame that says how many there are, "Xing" or "Info": decoders end where the first one says. It stands 36,
/// 21 or 13 bytes behind the begin of its frame, by version and channels.
std::optional<std::int64_t> second_mp3(SoundBytes& bytes) {
  int n = 0;
  std::optional<std::int64_t> last;
  for (const char* mark : {"Xing", "Info"})
    place_of(bytes, mark, [&](std::int64_t place, std::string_view) {
      constexpr std::array<std::int64_t, 3> kBehind{36, 21, 13};
      for (const std::int64_t behind : kBehind) {
        const std::string sync = bytes.text(std::max<std::int64_t>(0, place - behind), 2);
        if (sync.size() < 2 || sync[0] != '\xFF' || (sync[1] & 0xE0) != 0xE0) continue;
        ++n;
        last = std::max(last.value_or(0), place - behind);
        break;
      }
      return n > 1;
    });
  return n > 1 ? last : std::nullopt;
}

/// A second box `ftyp` of an MP4 or QuickTime file.
std::optional<std::int64_t> second_mp4(SoundBytes& bytes) {
  for (std::int64_t at = 0; at < bytes.size();) {
    const std::string head = bytes.text(at, 16);
    if (head.size() < 8) return std::nullopt;
    if (at > 0 && head.compare(4, 4, "ftyp") == 0) return at;
    std::uint64_t length = number_in(std::string_view(head).substr(0, 4), true);
    if (length == 1 && head.size() == 16) length = number_in(std::string_view(head).substr(8), true);
    if (length < 8 || length > static_cast<std::uint64_t>(bytes.size() - at)) return std::nullopt;
    at += static_cast<std::int64_t>(length);
  }
  return std::nullopt;
}

/// Behind the samples of a file of chunks another such file, or more samples.
std::optional<std::int64_t> second_in_chunks(SoundBytes& bytes, Kind kind) {
  const std::optional<Samples> s = samples_in_chunks(bytes, kind);
  if (!s || s->promised > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
  const ChunkLayout layout = layout_of(kind);
  std::int64_t next = layout.next(s->begin, static_cast<std::int64_t>(s->promised));
  for (int n = 0; n < kMostChunks; ++n) {
    const std::optional<Chunk> chunk = chunk_at(bytes, layout, next);
    if (!chunk || chunk->length > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
    constexpr std::array<std::string_view, 6> kSoundChunks{"RIFF", "RF64", "riff", "FORM", "data", "SSND"};
    if (chunk->length > 0 && std::find(kSoundChunks.begin(), kSoundChunks.end(), chunk->name) != kSoundChunks.end())
      return next;
    next = layout.next(chunk->begin, static_cast<std::int64_t>(chunk->length));
  }
  return std::nullopt;
}

std::optional<std::int64_t> second_sound(SoundBytes& bytes) {
  const Kind kind = kind_of(bytes);
  if (kind == Kind::au) return std::nullopt;  // has no chunks: what follows its samples may be anything
  if (kind != Kind::other) return second_in_chunks(bytes, kind);
  const std::string head = bytes.text(0, 8);
  if (head.size() < 8) return std::nullopt;
  if (head.starts_with("fLaC")) return second_flac(bytes);
  if (head.starts_with("OggS")) return second_ogg(bytes);
  if (head.compare(4, 4, "ftyp") == 0) return second_mp4(bytes);
  const bool is_frame = head[0] == '\xFF' && (head[1] & 0xE0) == 0xE0;
  return is_frame || head.starts_with("ID3") ? second_mp3(bytes) : std::nullopt;
}

}  // namespace

std::string what_follows(SoundBytes& bytes) {
  const std::optional<std::int64_t> at = second_sound(bytes);
  if (!at) return {};
  return "more sound follows at byte " + std::to_string(*at) +
         " (files joined, or a recorder that paused?) and is left out; cut the file there to analyze it";
}

std::optional<EmbeddedFile> ogg_in_wav(SoundBytes& bytes) {
  if (kind_of(bytes) != Kind::riff) return std::nullopt;
  const std::optional<Samples> s = samples_in_chunks(bytes, Kind::riff);
  if (!s || bytes.text(s->begin, 4) != "OggS") return std::nullopt;
  const std::int64_t available = bytes.size() - s->begin;
  const bool is_given = s->promised > 0 && s->promised <= static_cast<std::uint64_t>(available);
  return EmbeddedFile{s->begin, is_given ? static_cast<std::int64_t>(s->promised) : available};
}

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

std::string wrong_length(const SoundInfo& found, std::optional<double> n_promised) {
  const auto samples = [&](double n) {
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "%.0f samples (%.4f s)", n, n / found.rate_hz);
    return std::string(text.data());
  };
  const std::string held = samples(static_cast<double>(found.n_frames));
  if (!n_promised)
    return "the header gives no length (written to a pipe, or not to its end?): the " + held +
           " that are there were read";
  return "the header promises " + samples(*n_promised) + ", the file holds " + held + ": those were read" +
         (static_cast<double>(found.n_frames) < *n_promised ? "; is it cut off?" : "");
}

}  // namespace bouncelab::audio
