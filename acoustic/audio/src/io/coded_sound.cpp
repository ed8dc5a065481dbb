// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/coded_sound.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string_view>
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
    throw FileError(file.name(),
                    "not readable as sound (" + error.reason() + "); choose another file, or record again");
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

/// What the child writes before the samples.
struct Head {
  using Text = std::array<char, 256>;

  double rate_hz = 0.0;
  std::int64_t n_frames = 0;
  int n_channels = 0;
  bool has_length = false, may_be_infinite = false;
  Text description{}, lossy_coding{};
  Text refusal{};  // why libsndfile does not read the file; empty: it does
};

void put(std::string_view from, Head::Text& to) { from.copy(to.data(), to.size() - 1); }

void decode_in_child(const std::string& name, const ChildProcess::Output& write) {
  Head head;
  std::optional<SoundDecoder> decoder;
  try {
    decoder.emplace(FileBytes(ChildProcess::kHandedOver, name));
    const SoundInfo& info = decoder->info();
    head = {info.rate_hz, info.n_frames, info.n_channels, decoder->has_length(), info.may_be_infinite, {}, {}, {}};
    put(info.description, head.description);
    put(info.lossy_coding, head.lossy_coding);
  } catch (const NotForLibsndfile& error) {
    put(error.reason(), head.refusal);
  }
  write(std::as_bytes(std::span(&head, 1)));
  if (!decoder) return;
  for (auto piece = decoder->next(); !piece.empty(); piece = decoder->next()) write(std::as_bytes(piece));
}

/// @throws NotForLibsndfile; FileError
SoundInfo decode_by_libsndfile(const FileBytes& file, DecodedSamples& samples) {
  const std::int64_t n_bytes = file.size();
  const ChildLimits limits{kLeast_cpu_s + static_cast<double>(n_bytes) / kBytesPerCpuSecond,
                           kLeast_memory_bytes + kMemoryPerFileByte * n_bytes};
  ChildProcess child([&](const ChildProcess::Output& write) { decode_in_child(file.name(), write); }, file.name(),
                     file.descriptor(), limits);
  Head head;
  child.read(std::as_writable_bytes(std::span(&head, 1)));
  if (head.refusal.front() != '\0') throw NotForLibsndfile(file.name(), head.refusal.data());
  SoundInfo info;
  info.rate_hz = head.rate_hz;
  info.n_channels = head.n_channels;
  info.n_frames = head.n_frames;
  info.may_be_infinite = head.may_be_infinite;
  info.description = head.description.data();
  info.lossy_coding = head.lossy_coding.data();
  // not more than the file may hold, whatever its header says
  if (head.has_length) samples.reserve(std::min(info.n_frames, n_bytes) * info.n_channels);
  std::vector<float> piece(kSamplesAtOnce);
  while (const std::size_t n = child.read(std::as_writable_bytes(std::span(piece))) / sizeof(float))
    samples.append(std::span(piece).first(n));
  child.finish(kRemedy);
  conclude(info, head.has_length, samples.size() / info.n_channels, file.name());
  return info;
}

}  // namespace

SoundInfo decode_coded(const std::filesystem::path& path, const FileBytes& file, int track, DecodedSamples& samples) {
  try {
    return decode_by_libsndfile(file, samples);
  } catch (const NotForLibsndfile& error) {
    return decode_by_ffmpeg(path, file, track, error.reason(), samples);
  }
}

#endif

}  // namespace bouncelab::audio
