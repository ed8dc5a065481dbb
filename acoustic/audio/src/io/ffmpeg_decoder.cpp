// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <mutex>
#include <optional>
#include <sstream>
#include <vector>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "io/coded_sound.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {
namespace {

static_assert(std::endian::native == std::endian::little);  // as the samples come

// Speech coders hold half an hour of sound in a MB, which ffmpeg decodes at over 100 times its speed.
constexpr double kLeastOfFfmpeg_cpu_s = 20.0;
constexpr double kCpuSecondsPerByte = 30e-6;
constexpr std::int64_t kMostFfmpegFramesPerByte = 1 << 16;  // as FLAC packs silence
constexpr std::size_t kFfmpegSamplesAtOnce = 1 << 14;       // the 64 kB that a pipe holds

/// The first line of what a program complained of, without the name that it gave the file.
std::string first_line_of(const std::string& complaints, const std::string& input) {
  std::string line = complaints.substr(0, complaints.find('\n'));
  if (line.rfind(input + ": ", 0) == 0) line.erase(0, input.size() + 2);
  // "[aac @ 0x55d0]": where in memory its decoder lies is of no use
  if (const std::size_t at = line.find(" @ 0x"); line.rfind('[', 0) == 0 && at != std::string::npos)
    line.erase(at, std::min(line.find(']', at), line.size()) - at);
  return line.empty() ? "no reason given" : line;
}

/// KEY=VALUE in one of the lines.
std::string value_of(const std::string& lines, const std::string& key) {
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);)
    if (line.rfind(key + "=", 0) == 0) return line.substr(key.size() + 1);
  return {};
}

/// Codings that lose nothing, or steps of the amplitude only, which moves no impact (G.711, ADPCM).
bool is_lossless(const std::string& codec) {
  for (const char* begin : {"pcm_", "adpcm_"})
    if (codec.rfind(begin, 0) == 0) return true;
  constexpr std::array<const char*, 12> kNames{"flac", "alac", "wavpack", "tta",         "ape",     "tak",
                                               "mlp",  "als",  "truehd",  "wmalossless", "shorten", "ralf"};
  return std::any_of(kNames.begin(), kNames.end(), [&](const char* name) { return codec == name; });
}

/// As people write it: AAC, AMR-NB, Opus.
std::string name_of_coding(std::string codec) {
  if (codec == "opus") return "Opus";
  if (codec == "vorbis") return "Vorbis";
  for (char& c : codec) c = c == '_' ? '-' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return codec;
}

std::mutex version_mutex;
std::string& version_used() {
  static std::string version;
  return version;
}

/// @param ffmpeg  where it lies
std::string version_of(const std::filesystem::path& ffmpeg, const std::string& name) {
  const std::lock_guard lock(version_mutex);
  if (version_used().empty()) {
    std::istringstream words(run_program(ffmpeg, {"-version"}, name, -1, {kLeastOfFfmpeg_cpu_s}).output);
    std::string program, version, value;  // "ffmpeg version 5.1.9-0+deb12u1 Copyright ..."
    words >> program >> version >> value;
    version_used() = value.empty() ? "unknown version" : value;
  }
  return version_used();
}

std::filesystem::path installed(const std::string& program, const std::string& name, const std::string& reason) {
  if (const auto found = find_program(program)) return *found;
  throw FileError(name, "not readable as audio by libsndfile (" + reason +
                            "); install ffmpeg, which is then used by itself (Debian, Ubuntu: apt install ffmpeg; "
                            "macOS: brew install ffmpeg)");
}

/// One recording on its way through ffmpeg.
struct Decoding {
  std::filesystem::path ffmpeg, ffprobe;
  std::string input;  // as ffmpeg is told
  std::string name;
  int descriptor;
  std::int64_t n_bytes;
  ChildLimits limits;

  [[noreturn]] void refuse(const std::string& complaints) const {
    throw FileError(name,
                    "ffmpeg cannot decode it (" + first_line_of(complaints, input) + "); record or copy it again");
  }
};

/// What the file is. @param reason  why libsndfile does not read it
void ask_what_it_is(const Decoding& d, const std::string& reason, SoundInfo& info) {
  const ProgramResult answer = run_program(
      d.ffprobe,
      {"-v", "error", "-protocol_whitelist", "file", "-select_streams", "a:0", "-show_entries",
       "stream=codec_name,codec_long_name:format=format_long_name", "-of", "default=noprint_wrappers=1", "-i", d.input},
      d.name, d.descriptor, d.limits);
  if (!answer.ended_well)
    throw FileError(d.name, "not readable as audio (libsndfile: " + reason + "; ffmpeg: " +
                                first_line_of(answer.complaints, d.input) + "); record or copy it again");
  const std::string codec = value_of(answer.output, "codec_name");
  const std::string format = value_of(answer.output, "format_long_name");
  if (codec.empty()) throw FileError(d.name, "holds no sound (" + format + "); name a recording with sound");
  info.description = format + ", " + value_of(answer.output, "codec_long_name");
  if (!is_lossless(codec)) info.lossy_coding = name_of_coding(codec);
}

/// The sound as ffmpeg writes it, a WAV file of floats. @return frames
std::int64_t take_sound(const Decoding& d, ChildProcess& running, SoundInfo& info, DecodedSamples& samples) {
  std::vector<std::byte> piece(kFfmpegSamplesAtOnce * sizeof(float));
  piece.resize(running.read(piece));
  SoundBytes begin{std::span<const std::byte>(piece)};
  const std::optional<PlainSound> sound = plain_sound(begin, d.name);
  if (!sound) {
    if (running.ended_well() && running.complaints().empty()) throw FileError(d.name, "holds no samples; record again");
    d.refuse(running.complaints());
  }
  info.rate_hz = sound->info.rate_hz;
  info.n_channels = sound->info.n_channels;
  std::int64_t n_head = sound->first_byte;  // bytes of the piece: a multiple of four
  while (n_head < std::ssize(piece)) {
    std::vector<float> floats((piece.size() - static_cast<std::size_t>(n_head)) / sizeof(float));
    std::memcpy(floats.data(), piece.data() + n_head, floats.size() * sizeof(float));
    samples.append(floats);
    if (samples.size() / info.n_channels / kMostFfmpegFramesPerByte > d.n_bytes)
      throw FileError(d.name, "ffmpeg finds no end of it: damaged? record or copy it again");
    n_head = 0;
    piece.resize(kFfmpegSamplesAtOnce * sizeof(float));
    piece.resize(running.read(piece));
  }
  return samples.size() / info.n_channels;
}

}  // namespace

SoundInfo decode_by_ffmpeg(const std::filesystem::path& path, const ReadableFile& file, const std::string& reason,
                           DecodedSamples& samples) {
  const std::int64_t n_bytes = SoundBytes(file.descriptor()).size();
  Decoding d{installed("ffmpeg", file.name(), reason),
             installed("ffprobe", file.name(), reason),
             {},
             file.name(),
             file.descriptor(),
             n_bytes,
             {kLeastOfFfmpeg_cpu_s + kCpuSecondsPerByte * static_cast<double>(n_bytes)}};
  const std::string content = readable(path).native();
  const bool is_of_this_process = content.rfind("/proc/", 0) == 0 || content.rfind("/dev/", 0) == 0;
  // file: a name may begin with a dash, or look like an address on the network
  d.input = "file:" + (is_of_this_process ? "/dev/fd/" + std::to_string(ChildProcess::kHandedOver) : content);
  SoundInfo info;
  ask_what_it_is(d, reason, info);
  ChildProcess running(d.ffmpeg,
                       {"-nostdin", "-v", "error", "-protocol_whitelist", "file,pipe", "-i", d.input, "-map", "0:a:0",
                        "-fflags", "+bitexact", "-c:a", "pcm_f32le", "-f", "wav", "pipe:1"},
                       d.name, d.descriptor, d.limits);
  info.n_frames = take_sound(d, running, info, samples);
  const bool ended_well = running.ended_well();
  if (!ended_well || !running.complaints().empty())
    info.warning = "ffmpeg met errors (" + first_line_of(running.complaints(), d.input) + "): the " +
                   std::to_string(info.n_frames) + " samples that it decoded were read; is it cut off?";
  info.ffmpeg = version_of(d.ffmpeg, d.name);
  return info;
}

std::string ffmpeg_version_used() {
  const std::lock_guard lock(version_mutex);
  return version_used();
}

}  // namespace bouncelab::audio
