// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "bouncelab/audio/annotations.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::uint64_t kIn32Bits = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kHighestHeaderRate_hz = 1'000'000'000;
constexpr std::uint64_t kShortestDs64 = 28;  // bytes: three sizes and the length of a table

void put(std::string& bytes, std::uint32_t value) { bytes += bytes_of_number(value, 4); }

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  return static_cast<std::uint32_t>(number_in(bytes.substr(std::min(at, bytes.size()), 4)));
}

/// The chunks of a WAV or RF64 file (EBU Tech 3306).
class RiffFile {
 public:
  explicit RiffFile(const FileBytes& bytes) : name_(bytes.name()), bytes_(bytes) {
    const std::string head = read(0, 12);
    kind_ = head.substr(0, 4);
    if (head.size() < 12 || (kind_ != "RIFF" && kind_ != "RF64" && kind_ != "BW64") || head.substr(8) != "WAVE")
      throw FileError(name_, "is neither WAV nor RF64; cue points go into those only");
    std::uint64_t data_size = kIn32Bits;
    const ChunkLayout layout;
    for (std::int64_t at = layout.first_chunk; std::optional<Chunk> chunk = chunk_at(bytes_, layout, at);) {
      if (chunk->name == "ds64") {
        if (chunk->length < kShortestDs64)
          throw FileError(name_, "the chunk 'ds64' is too short for the sizes it holds");
        data_size = number_in(read(chunk->begin + 8, 8));
      }
      if (chunk->name == "data" && chunk->length == kIn32Bits) chunk->length = data_size;
      if (chunk->length > static_cast<std::uint64_t>(bytes_.size() - chunk->begin))
        throw FileError(name_, "the chunk '" + chunk->name + "' is longer than the file; was the recording cut off?");
      at = layout.next(chunk->begin, static_cast<std::int64_t>(chunk->length));
      chunks_.push_back(*chunk);
    }
    bytes_.check();
  }

  const std::vector<Chunk>& chunks() const { return chunks_; }
  const std::string& kind() const { return kind_; }
  const std::string& name() const { return name_; }
  std::string read(std::int64_t begin, std::uint64_t size) {
    std::string text = bytes_.text(begin, size);
    bytes_.check();
    return text;
  }
  std::string content(const Chunk& chunk) { return read(chunk.begin, chunk.length); }
  bool is_cue_chunk(const Chunk& chunk) {
    return chunk.name == "cue " || (chunk.name == "LIST" && chunk.length >= 4 && read(chunk.begin, 4) == "adtl");
  }
  int rate_hz() {
    for (const Chunk& chunk : chunks_) {
      if (chunk.name != "fmt " || chunk.length < 16) continue;
      const std::uint32_t rate = number_at(read(chunk.begin, 16), 4);
      if (rate > 0 && rate <= kHighestHeaderRate_hz) return static_cast<int>(rate);
      throw FileError(name_, "sample rate " + std::to_string(rate) + " Hz: must be 1 to 1e9 Hz; correct the header");
    }
    throw FileError(name_, "has no format chunk with a sample rate");
  }

 private:
  std::string name_, kind_;
  FileBytes bytes_;
  std::vector<Chunk> chunks_;
};

/// Texts of the cue points, by their number, from the content of a list of type adtl.
void read_labels(const std::string& list, std::map<std::uint32_t, std::string>& labels) {
  for (std::size_t at = 4; at + 8 <= list.size();) {
    const std::uint32_t size = number_at(list, at + 4);
    if (list.compare(at, 4, "labl") == 0 && size >= 4) {
      const std::string text = list.substr(std::min(at + 12, list.size()), size - 4);
      labels[number_at(list, at + 8)] = text.substr(0, text.find('\0'));
    }
    at += 8 + std::size_t{size} + size % 2;
  }
}

std::string chunk_bytes(const char* id, const std::string& content) {
  std::string bytes = id;
  put(bytes, static_cast<std::uint32_t>(content.size()));
  bytes += content;
  if (content.size() % 2) bytes += '\0';
  return bytes;
}

std::string cue_chunks(const Annotations& annotations, int rate_hz, const std::string& name) {
  std::string cues, labels = "adtl";
  put(cues, static_cast<std::uint32_t>(annotations.points.size()));
  std::uint32_t number = 0;
  for (const Annotation& point : annotations.points) {
    const double frame = std::round(point.t_s * rate_hz);
    if (!(frame >= 0.0 && frame <= static_cast<double>(kIn32Bits)))
      throw FileError(name, "a point at " + std::to_string(point.t_s) +
                                " s is beyond the range of a cue point (2^32 frames); use another label format");
    ++number;
    put(cues, number);
    put(cues, static_cast<std::uint32_t>(frame));
    cues += "data";
    put(cues, 0);
    put(cues, 0);
    put(cues, static_cast<std::uint32_t>(frame));
    std::string label;
    put(label, number);
    labels += chunk_bytes("labl", label + point.label + '\0');
  }
  return chunk_bytes("cue ", cues) + chunk_bytes("LIST", labels);
}

Annotations cues_of(RiffFile file) {
  Annotations result;
  const int rate_hz = file.rate_hz();
  result.recording = file.name();
  result.resolution_s = 1.0 / rate_hz;
  std::map<std::uint32_t, std::string> labels;
  std::string cues;
  for (const Chunk& chunk : file.chunks()) {
    if (!file.is_cue_chunk(chunk)) continue;
    if (chunk.name == "cue ")
      cues = file.content(chunk);
    else
      read_labels(file.content(chunk), labels);
  }
  for (std::size_t at = 4; at + 24 <= cues.size(); at += 24)
    result.points.push_back({number_at(cues, at + 20) / static_cast<double>(rate_hz), labels[number_at(cues, at)]});
  if (result.points.empty())
    throw FileError(file.name(), "is a recording and holds no cue points; bouncelab analyze takes recordings");
  return result;
}

}  // namespace

Annotations read_cues(const std::filesystem::path& path) { return cues_of(RiffFile(FileBytes(path))); }

Annotations parse_cues(std::span<const std::byte> bytes, const std::string& name) {
  return cues_of(RiffFile(FileBytes(bytes, name)));
}

void copy_with_cues(const std::filesystem::path& recording, const Annotations& annotations,
                    const std::function<void(std::string_view)>& write, const std::string& name) {
  RiffFile file{FileBytes(recording)};
  const std::string cues = cue_chunks(annotations, file.rate_hz(), name);
  std::vector<Chunk> chunks = file.chunks();
  std::erase_if(chunks, [&](const Chunk& chunk) { return file.is_cue_chunk(chunk); });
  std::uint64_t length = 12 + cues.size();
  for (const Chunk& chunk : chunks) length += 8 + chunk.length + chunk.length % 2;
  const bool is_riff = file.kind() == "RIFF";
  if (is_riff && length - 8 > kIn32Bits)
    throw FileError(name, "would be longer than the 4 GiB of WAV; make the recording an RF64 first (sox, ffmpeg)");
  if (!is_riff && std::none_of(chunks.begin(), chunks.end(), [](const Chunk& chunk) { return chunk.name == "ds64"; }))
    throw FileError(file.name(), "is RF64 without its chunk 'ds64'");
  std::string head = file.read(0, 12);
  if (is_riff) head.replace(4, 4, bytes_of_number(length - 8, 4));
  write(head);
  constexpr std::uint64_t kPiece = 1 << 20;
  for (const Chunk& chunk : chunks) {
    const std::uint64_t size = 8 + chunk.length;
    for (std::uint64_t done = 0; done < size; done += kPiece) {
      std::string piece = file.read(chunk.begin - 8 + static_cast<std::int64_t>(done), std::min(kPiece, size - done));
      if (chunk.name == "ds64" && done == 0) piece.replace(8, 8, bytes_of_number(length - 8, 8));
      write(piece);
    }
    if (size % 2) write(std::string(1, '\0'));
  }
  write(cues);
}

}  // namespace bouncelab::audio
