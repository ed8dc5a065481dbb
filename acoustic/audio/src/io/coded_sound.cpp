// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/coded_sound.hpp"

#include <algorithm>
#include <cstring>
#include <sstream>
#include <system_error>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kMostHeld = 1 << 24;  // samples

}  // namespace

void DecodedSamples::reserve(std::int64_t n) { held_.reserve(static_cast<std::size_t>(std::min(n, kMostHeld))); }

void DecodedSamples::append(std::span<const float> samples) {
  n_ += std::ssize(samples);
  if (n_ <= kMostHeld) {
    held_.insert(held_.end(), samples.begin(), samples.end());
    return;
  }
  if (!file_) {
    std::error_code missing;
    std::filesystem::path folder = std::filesystem::temp_directory_path(missing);
    if (missing) folder = "/tmp";
    file_.emplace(folder, name_ + ": its samples in " + folder.string() + " (TMPDIR names another folder)");
    append_to_file(held_);
    held_ = {};
  }
  append_to_file(samples);
}

void DecodedSamples::append_to_file(std::span<const float> samples) {
  file_->append({reinterpret_cast<const char*>(samples.data()), samples.size_bytes()});
}

void DecodedSamples::read(std::int64_t first, std::span<float> out) const {
  if (!file_) {
    std::copy_n(held_.begin() + first, out.size(), out.begin());
    return;
  }
  const std::string bytes = file_->at(first * static_cast<std::int64_t>(sizeof(float)), out.size_bytes());
  std::memcpy(out.data(), bytes.data(), bytes.size());
}

// ---- decoding

#ifdef __EMSCRIPTEN__  // a browser, which has no processes, and decodes by itself what ffmpeg would

SoundInfo decode_coded(const std::filesystem::path&, const FileBytes& file, int, DecodedSamples& samples) {
  try {
    SoundDecoder decoder(file);
    SoundInfo info = decoder.info();
    for (auto piece = decoder.next(); !piece.empty(); piece = decoder.next()) samples.append(piece);
    conclude(info, decoder.has_length(), samples.size() / info.n_channels, file.name());
    return info;
  } catch (const NotForLibsndfile& error) {
    throw FileError(file.name(), "not readable as sound (" + error.reason + "); choose another file, or record again");
  }
}

std::string ffmpeg_version_used() { return {}; }

#else

namespace {

// A header takes milliseconds, a piece of samples less; 1 s/MB is left for decoders that go through the file first.
constexpr double kLeast_cpu_s = 5.0;
constexpr double kBytesPerCpuSecond = 1e6;
// Decoders hold a few MB, and tables of the file's parts in proportion to its length.
constexpr std::int64_t kLeast_memory_bytes = 100'000'000;
constexpr std::int64_t kMemoryPerFileByte = 10;
constexpr std::size_t kSamplesAtOnce = 1 << 14;  // the 64 kB that a pipe holds

const char* const kRemedy = "repair or convert it: ffmpeg -i IN OUT.wav";

// What the child writes: the length of a head, the head, samples. The head is lines: "sound" and the members of a
// SoundInfo, or "other" and why libsndfile does not read the file.
constexpr const char* kSound = "sound";
constexpr const char* kOther = "other";

std::string head_of(const SoundDecoder& decoder) {
  const SoundInfo& info = decoder.info();
  std::ostringstream head;
  head << kSound << '\n'
       << static_cast<std::int64_t>(info.rate_hz) << ' ' << info.n_channels << ' ' << info.n_frames << ' '
       << decoder.has_length() << ' ' << info.may_be_infinite << '\n'
       << info.description << '\n'
       << info.lossy_coding << '\n';
  return head.str();
}

void write_head(const std::string& head, const ChildProcess::Output& write) {
  const auto n = static_cast<std::uint32_t>(head.size());
  write(std::as_bytes(std::span(&n, 1)));
  write(std::as_bytes(std::span(head)));
}

void decode_in_child(const std::string& name, const ChildProcess::Output& write) {
  std::optional<SoundDecoder> decoder;
  try {
    decoder.emplace(FileBytes(ChildProcess::kHandedOver, name));
  } catch (const NotForLibsndfile& error) {
    return write_head(std::string(kOther) + "\n" + error.reason, write);
  }
  write_head(head_of(*decoder), write);
  for (auto piece = decoder->next(); !piece.empty(); piece = decoder->next()) write(std::as_bytes(piece));
}

/// @throws NotForLibsndfile; FileError
SoundInfo decode_by_libsndfile(const FileBytes& file, DecodedSamples& samples) {
  const std::int64_t n_bytes = file.size();
  const ChildLimits limits{kLeast_cpu_s + static_cast<double>(n_bytes) / kBytesPerCpuSecond,
                           kLeast_memory_bytes + kMemoryPerFileByte * n_bytes};
  ChildProcess child([&](const ChildProcess::Output& write) { decode_in_child(file.name(), write); }, file.name(),
                     file.descriptor(), limits);
  std::uint32_t n_head = 0;
  child.read(std::as_writable_bytes(std::span(&n_head, 1)));
  std::string head(n_head, '\0');
  child.read(std::as_writable_bytes(std::span(head)));
  std::istringstream lines(head);
  std::string kind, rest;
  std::getline(lines, kind);
  if (kind == kOther) {
    std::getline(lines, rest);
    throw NotForLibsndfile(file.name(), rest);
  }
  SoundInfo info;
  bool has_length = false;
  lines >> info.rate_hz >> info.n_channels >> info.n_frames >> has_length >> info.may_be_infinite;
  std::getline(lines, rest);
  std::getline(lines, info.description);
  std::getline(lines, info.lossy_coding);
  // not more than the file may hold, whatever its header says
  if (has_length) samples.reserve(std::min(info.n_frames, n_bytes) * info.n_channels);
  std::vector<float> piece(kSamplesAtOnce);
  while (const std::size_t n = child.read(std::as_writable_bytes(std::span(piece))) / sizeof(float))
    samples.append(std::span(piece).first(n));
  child.finish(kRemedy);
  conclude(info, has_length, samples.size() / info.n_channels, file.name());
  return info;
}

}  // namespace

SoundInfo decode_coded(const std::filesystem::path& path, const FileBytes& file, int track, DecodedSamples& samples) {
  try {
    return decode_by_libsndfile(file, samples);
  } catch (const NotForLibsndfile& error) {
    return decode_by_ffmpeg(path, file, track, error.reason, samples);
  }
}

#endif

}  // namespace bouncelab::audio
