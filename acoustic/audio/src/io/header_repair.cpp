// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/header_repair.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
#include <utility>

namespace bouncelab::audio {
namespace {

constexpr int kMostChunks = 1000;  // some writers add a dozen; chunks may also lead round in a circle
// What follows the samples and is no chunk: up to this the padding or the tags of some writers (ID3v1: 128 bytes), and
// less than 0.1 s of sound in any case. libsndfile leaves it out, and so do we.
constexpr std::int64_t kMostPadding_bytes = 4096;

/// How a format writes its chunks: a name, a length, the content.
struct ChunkLayout {
  std::int64_t first_chunk = 12;  ///< in the file
  int name_bytes = 4, length_bytes = 4;
  bool is_big_endian = false;
  bool counts_head = false;  ///< the length includes name and length
  std::int64_t alignment = 2;
  std::int64_t length_of_file_at = 4;  ///< where the head gives it

  std::int64_t head_bytes() const { return name_bytes + length_bytes; }
  std::int64_t next(std::int64_t begin, std::int64_t length) const {
    return begin + (length + alignment - 1) / alignment * alignment;
  }
};

enum class Kind { other, riff, rf64, w64, aiff, au };

std::string text_at(SoundBytes& bytes, std::int64_t first, std::size_t n) {
  std::string text(n, '\0');
  text.resize(static_cast<std::size_t>(bytes.read(first, std::as_writable_bytes(std::span(text)))));
  return text;
}

std::uint64_t number_in(std::string_view text, bool is_big_endian) {
  std::uint64_t value = 0;
  for (std::size_t k = 0; k < text.size(); ++k)
    value = value << 8 | static_cast<unsigned char>(text[is_big_endian ? k : text.size() - 1 - k]);
  return value;
}

std::string bytes_of_number(std::uint64_t value, int n_bytes, bool is_big_endian) {
  std::string text;
  for (int k = 0; k < n_bytes; ++k, value >>= 8) text += static_cast<char>(value & 0xFF);
  if (is_big_endian) std::reverse(text.begin(), text.end());
  return text;
}

Kind kind_of(SoundBytes& bytes) {
  const std::string head = text_at(bytes, 0, 40);
  if (head.size() < 12) return Kind::other;
  const std::string_view name(head.data(), 4), type(head.data() + 8, 4);
  if (name == "RIFF" && type == "WAVE") return Kind::riff;
  if (name == "RF64" && type == "WAVE") return Kind::rf64;
  if (name == "riff" && head.size() == 40 && head.compare(24, 4, "wave") == 0) return Kind::w64;
  if (name == "FORM" && (type == "AIFF" || type == "AIFC")) return Kind::aiff;
  return name == ".snd" ? Kind::au : Kind::other;
}

ChunkLayout layout_of(Kind kind) {
  if (kind == Kind::w64) return {40, 16, 8, false, true, 8, 16};
  ChunkLayout layout;
  layout.is_big_endian = kind == Kind::aiff;
  return layout;
}

struct Chunk {
  std::string name;  // its first four characters
  std::int64_t head = 0, begin = 0;
  std::uint64_t length = 0;  // of the content, as it is given
};

std::optional<Chunk> chunk_at(SoundBytes& bytes, const ChunkLayout& layout, std::int64_t at) {
  const std::string head = text_at(bytes, at, static_cast<std::size_t>(layout.head_bytes()));
  if (std::ssize(head) < layout.head_bytes()) return std::nullopt;
  std::uint64_t length = number_in(std::string_view(head).substr(layout.name_bytes), layout.is_big_endian);
  if (layout.counts_head) length -= std::min(length, static_cast<std::uint64_t>(layout.head_bytes()));
  return Chunk{head.substr(0, 4), at, at + layout.head_bytes(), length};
}

/// What was read of a file's chunks up to its samples.
struct Samples {
  Chunk chunk;
  std::int64_t begin = 0;         // of the samples
  std::uint64_t promised = 0;     // bytes
  std::int64_t frame_bytes = 0;   // or bytes of a block, of what is coded in blocks
  std::int64_t length_64_at = 0;  // of RF64: where the length of the samples is given
  std::int64_t n_frames_at = 0;   // of AIFF: where their number is given too
};

std::optional<Samples> samples_of(SoundBytes& bytes, Kind kind, const ChunkLayout& layout) {
  Samples s;
  std::uint64_t length_64 = 0;
  std::int64_t at = layout.first_chunk;
  for (int k = 0; k < kMostChunks; ++k) {
    const std::optional<Chunk> chunk = chunk_at(bytes, layout, at);
    if (!chunk) return std::nullopt;
    const bool is_samples = chunk->name == (kind == Kind::aiff ? "SSND" : "data");
    if (is_samples) {
      const std::int64_t offset = kind == Kind::aiff ? 8 : 0;  // two numbers come first
      s.chunk = *chunk;
      s.begin = chunk->begin + offset;
      s.promised = chunk->length - std::min(chunk->length, static_cast<std::uint64_t>(offset));
      if (kind == Kind::rf64 && chunk->length == 0xFFFFFFFF && s.length_64_at > 0) s.promised = length_64;
      return s.frame_bytes > 0 ? std::optional(s) : std::nullopt;
    }
    const auto number = [&](std::int64_t offset, std::size_t n) {
      return number_in(text_at(bytes, chunk->begin + offset, n), layout.is_big_endian);
    };
    if (chunk->name == "fmt ") {
      s.frame_bytes = static_cast<std::int64_t>(number(12, 2));
    } else if (chunk->name == "ds64") {
      length_64 = number(8, 8);
      s.length_64_at = chunk->begin + 8;
    } else if (chunk->name == "COMM") {
      const std::string coding = chunk->length > 18 ? text_at(bytes, chunk->begin + 18, 4) : "NONE";
      constexpr std::array<std::string_view, 6> kPlain{"NONE", "twos", "sowt", "fl32", "FL32", "fl64"};
      if (std::find(kPlain.begin(), kPlain.end(), coding) == kPlain.end()) return std::nullopt;
      s.frame_bytes = static_cast<std::int64_t>(number(0, 2) * ((number(6, 2) + 7) / 8));
      s.n_frames_at = chunk->begin + 2;
    }
    if (chunk->length > static_cast<std::uint64_t>(bytes.size())) return std::nullopt;
    at = layout.next(chunk->begin, static_cast<std::int64_t>(chunk->length));
  }
  return std::nullopt;
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
bool is_no_length(std::uint64_t promised, int n_bytes) {
  const std::uint64_t all = n_bytes == 8 ? ~std::uint64_t{0} : 0xFFFFFFFF;
  return promised == 0 || promised >= all - 0x10000 ||
         (promised >= (all >> 1) - 0x1000000 && promised <= (all >> 1) + 1);
}

/// The bytes of samples from `begin` on, in whole frames; nothing where what is promised is there to a frame.
std::optional<std::int64_t> held_instead(SoundBytes& bytes, const ChunkLayout& layout, const Samples& s) {
  const std::int64_t available = bytes.size() - s.begin;
  if (available <= 0) return std::nullopt;
  const std::int64_t held = available / s.frame_bytes * s.frame_bytes;
  if (s.promised > static_cast<std::uint64_t>(available))
    return static_cast<std::int64_t>(s.promised / s.frame_bytes) > held / s.frame_bytes ? std::optional(held)
                                                                                        : std::nullopt;
  const std::int64_t promised = static_cast<std::int64_t>(s.promised);
  const std::int64_t end = layout.next(s.begin, promised);
  const bool has_all = bytes.size() - end <= (promised > 0 ? kMostPadding_bytes : 0);
  if (has_all || held == 0 || is_chunk(bytes, layout, end) || is_chunk(bytes, layout, s.begin + promised))
    return std::nullopt;
  return held;
}

std::uint64_t in_32_bits(std::int64_t n) { return std::min<std::uint64_t>(static_cast<std::uint64_t>(n), 0xFFFFFFFF); }

/// Of AU: name, begin, length, coding, rate, channels; no chunks.
std::optional<HeaderRepair> repair_au(SoundBytes& bytes) {
  const std::string head = text_at(bytes, 0, 24);
  if (head.size() < 24) return std::nullopt;
  const auto number = [&](std::size_t at) { return number_in(std::string_view(head).substr(at, 4), true); };
  const auto begin = static_cast<std::int64_t>(number(4));
  const std::uint64_t promised = number(8);
  const std::int64_t available = bytes.size() - begin;
  if (begin < 24 || available <= 0 || promised <= static_cast<std::uint64_t>(available)) return std::nullopt;
  constexpr std::array<std::uint64_t, 8> kSampleBytes{1, 1, 1, 2, 3, 4, 4, 8};  // by the number of the coding
  const std::uint64_t coding = std::min<std::uint64_t>(number(12), 27);
  const auto frame_bytes =
      static_cast<std::int64_t>((coding < kSampleBytes.size() ? kSampleBytes[coding] : 1) * (number(20) & 0xFFFF));
  if (frame_bytes == 0) return std::nullopt;
  const std::int64_t held = available / frame_bytes * frame_bytes;
  HeaderRepair repair{{{8, bytes_of_number(in_32_bits(held), 4, true)}}, {}, held};
  if (!is_no_length(promised, 4)) repair.n_promised_bytes = static_cast<std::int64_t>(promised);
  return repair;
}

}  // namespace

std::optional<HeaderRepair> repair_header(SoundBytes& bytes) {
  const Kind kind = kind_of(bytes);
  if (kind == Kind::other) return std::nullopt;
  if (kind == Kind::au) return repair_au(bytes);
  const ChunkLayout layout = layout_of(kind);
  const std::optional<Samples> s = samples_of(bytes, kind, layout);
  if (!s) return std::nullopt;
  const std::optional<std::int64_t> held = held_instead(bytes, layout, *s);
  if (!held) return std::nullopt;

  HeaderRepair repair{{}, {}, *held};
  const bool has_64_bits = kind == Kind::w64 || (kind == Kind::rf64 && s->length_64_at > 0);
  if (!is_no_length(s->promised, has_64_bits ? 8 : 4) && s->promised <= INT64_MAX)
    repair.n_promised_bytes = static_cast<std::int64_t>(s->promised);
  const auto set = [&](std::int64_t at, std::int64_t value, int n_bytes) {
    const std::uint64_t number = n_bytes == 8 ? static_cast<std::uint64_t>(value) : in_32_bits(value);
    repair.patches.push_back({at, bytes_of_number(number, n_bytes, layout.is_big_endian)});
  };
  const std::int64_t end = s->begin + *held;
  set(layout.length_of_file_at, kind == Kind::w64 ? end : end - 8, layout.length_bytes);
  const std::int64_t in_chunk = end - (layout.counts_head ? s->chunk.head : s->chunk.begin);
  if (kind == Kind::rf64 && s->length_64_at > 0) {
    set(s->chunk.head + 4, 0xFFFFFFFF, 4);
    set(s->length_64_at - 8, end - 8, 8);
    set(s->length_64_at, in_chunk, 8);
    set(layout.length_of_file_at, 0xFFFFFFFF, 4);
  } else {
    set(s->chunk.head + layout.name_bytes, in_chunk, layout.length_bytes);
    if (s->n_frames_at > 0) set(s->n_frames_at, *held / s->frame_bytes, 4);
  }
  return repair;
}

std::optional<EmbeddedFile> ogg_in_wav(SoundBytes& bytes) {
  if (kind_of(bytes) != Kind::riff) return std::nullopt;
  const ChunkLayout layout = layout_of(Kind::riff);
  const std::optional<Samples> s = samples_of(bytes, Kind::riff, layout);
  if (!s || text_at(bytes, s->begin, 4) != "OggS") return std::nullopt;
  const std::int64_t available = bytes.size() - s->begin;
  const bool is_given = s->promised > 0 && s->promised <= static_cast<std::uint64_t>(available);
  return EmbeddedFile{s->begin, is_given ? static_cast<std::int64_t>(s->promised) : available};
}

}  // namespace bouncelab::audio
