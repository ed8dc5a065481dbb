// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>
#include <sstream>
#include <vector>

#include "bouncelab/core/child_process.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/numerics.hpp"
#include "io/coded_sound.hpp"
#include "io/sound_header.hpp"
#include "io/stamp_gaps.hpp"

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

/// Containers and codings that hold their sound themselves. Others (HLS, DASH, lists of files, scores) would have
/// ffmpeg open what they name.
constexpr const char* kContainers =
    "3dostr,aac,ac3,aiff,amr,amrnb,amrwb,ape,aptx,asf,au,avi,caf,codec2,dsf,dts,dtshd,dv,eac3,flac,flv,gsm,gxf,iff,"
    "ilbc,"
    "ircam,loas,matroska,mlp,mov,mp3,mpc,mpc8,mpeg,mpegts,mxf,nistsphere,nut,ogg,oma,qcp,rm,rso,sds,shn,sln,sox,tak,"
    "tta,"
    "truehd,voc,w64,wav,wsd,wtv,wv";

/// One recording on its way through ffmpeg.
struct Decoding {
  std::filesystem::path ffmpeg, ffprobe;
  std::string input;  // as ffmpeg is told
  std::string name;
  int descriptor;
  int track;  // of sound, from 0
  std::int64_t n_bytes;
  ChildLimits limits;

  /// Arguments by which a program opens the recording, and no other file.
  std::vector<std::string> opening() const {
    return {"-v", "error", "-protocol_whitelist", "file,pipe", "-format_whitelist", kContainers, "-i", input};
  }
  std::string map() const { return "0:a:" + std::to_string(track); }
  [[noreturn]] void refuse(const std::string& complaints) const {
    throw FileError(name,
                    "ffmpeg cannot decode it (" + first_line_of(complaints, input) + "); record or copy it again");
  }
};

// A packet takes 60 bytes of ffprobe's answer and holds 20 ms or so: a day of sound.
constexpr std::size_t kMostOfAnswer_bytes = std::size_t{1} << 28;

constexpr const char* kShown =  // of the file
    "packet=stream_index,pts_time,duration_time:stream=index,codec_name,codec_long_name:format=format_long_name";

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// What the file is. @param reason  why libsndfile does not read it
/// @return the packets of the track
std::vector<StampedBlock> ask_what_it_is(const Decoding& d, const std::string& reason, SoundInfo& info) {
  const ProgramResult answer = run_program(
      d.ffprobe,
      joined(d.opening(), {"-select_streams", "a", "-show_entries", kShown, "-of", "default=noprint_wrappers=1"}),
      d.name, d.descriptor, d.limits, kMostOfAnswer_bytes);
  if (answer.complaints.find("not on whitelist") != std::string::npos)
    throw FileError(d.name, "is a list of other files, or a format in which no sound is recorded; name the recording");
  if (!answer.ended_well)
    throw FileError(d.name, "not readable as audio (libsndfile: " + reason + "; ffmpeg: " +
                                first_line_of(answer.complaints, d.input) + "); record or copy it again");
  struct Track {
    std::string index, codec, codec_in_words;
    std::vector<StampedBlock> packets{};
  };
  std::vector<Track> tracks;
  std::vector<std::pair<std::string, StampedBlock>> packets;  // each with its stream
  std::istringstream lines(answer.output);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = std::min(line.find('='), line.size());
    const std::string key = line.substr(0, equals), value = line.substr(std::min(equals + 1, line.size()));
    const double number = std::strtod(value.c_str(), nullptr);  // "N/A" is 0
    if (key == "stream_index") packets.emplace_back(value, StampedBlock{});
    if (key == "pts_time" && !packets.empty() && value != "N/A") packets.back().second.begin_s = number;
    if (key == "duration_time" && !packets.empty()) packets.back().second.length_s = number;
    if (key == "index") tracks.push_back({value, {}, {}});
    if (key == "codec_name" && !tracks.empty()) tracks.back().codec = value;
    if (key == "codec_long_name" && !tracks.empty()) tracks.back().codec_in_words = value;
  }
  const std::string format = value_of(answer.output, "format_long_name");
  if (tracks.empty()) throw FileError(d.name, "holds no sound (" + format + "); name a recording with sound");
  info.n_tracks = static_cast<int>(tracks.size());
  if (d.track < 0 || d.track >= info.n_tracks) return {};  // the reader refuses it
  info.track = d.track;
  Track& track = tracks[static_cast<std::size_t>(d.track)];
  for (const auto& [index, packet] : packets)
    if (index == track.index) track.packets.push_back(packet);
  info.description = format + ", " + track.codec_in_words;
  if (!is_lossless(track.codec)) info.lossy_coding = name_of_coding(track.codec);
  return track.packets;
}

/// In MP4 a packet lasts to the next one, lost ones included.
std::vector<StampedBlock> of_equal_length(std::vector<StampedBlock> packets) {
  std::vector<double> lengths_s;
  for (const StampedBlock& packet : packets) lengths_s.push_back(packet.length_s);
  if (lengths_s.empty()) return packets;
  const double most_s = median(std::move(lengths_s));
  for (StampedBlock& packet : packets) packet.length_s = std::min(packet.length_s, most_s);
  return packets;
}

/// The blocks of samples as they are decoded, with their time stamps.
std::vector<StampedBlock> decoded_blocks(const Decoding& d) {
  const ProgramResult answer = run_program(
      d.ffmpeg, joined(d.opening(), {"-nostdin", "-map", d.map(), "-c:a", "pcm_f32le", "-f", "framecrc", "pipe:1"}),
      d.name, d.descriptor, d.limits, kMostOfAnswer_bytes);
  std::vector<StampedBlock> blocks;
  std::istringstream lines(answer.output);
  double unit_s = 0.0;
  for (std::string line; std::getline(lines, line);) {
    long long numerator = 0, denominator = 0, dts = 0, pts = 0, length = 0;
    if (std::sscanf(line.c_str(), "#tb 0: %lld/%lld", &numerator, &denominator) == 2 && denominator > 0)
      unit_s = static_cast<double>(numerator) / static_cast<double>(denominator);
    if (std::sscanf(line.c_str(), "0, %lld, %lld, %lld", &dts, &pts, &length) == 3)
      blocks.push_back({unit_s * static_cast<double>(pts), unit_s * static_cast<double>(length)});
  }
  return blocks;
}

/// Samples as they are decoded, with zeros where the container's clock ran on and without those that overlap.
class SamplesByTheClock {
 public:
  SamplesByTheClock(DecodedSamples& samples, std::vector<StampGap> gaps) : samples_(samples), gaps_(std::move(gaps)) {}

  void append(std::span<const float> decoded, const SoundInfo& info) {
    const auto samples_in = [&](double length_s) { return std::llround(length_s * info.rate_hz) * info.n_channels; };
    while (!gaps_.empty() && !decoded.empty()) {
      const std::int64_t n_before = samples_in(gaps_.front().after_s) - n_decoded_;
      if (n_before > std::ssize(decoded)) break;
      const auto n_here = static_cast<std::size_t>(std::max<std::int64_t>(0, n_before));
      take(decoded.first(n_here));
      decoded = decoded.subspan(n_here);
      const std::int64_t n = samples_in(gaps_.front().length_s);
      gaps_.erase(gaps_.begin());
      if (n < 0) n_to_skip_ -= n;
      constexpr std::int64_t kAtOnce = 1 << 14;
      for (std::int64_t left = n; left > 0; left -= kAtOnce)
        samples_.append(std::vector<float>(static_cast<std::size_t>(std::min(left, kAtOnce)), 0.0F));
    }
    take(decoded);
  }

 private:
  void take(std::span<const float> decoded) {
    n_decoded_ += std::ssize(decoded);
    const std::size_t n_skipped = std::min(decoded.size(), static_cast<std::size_t>(n_to_skip_));
    n_to_skip_ -= static_cast<std::int64_t>(n_skipped);
    samples_.append(decoded.subspan(n_skipped));
  }

  DecodedSamples& samples_;
  std::vector<StampGap> gaps_;
  std::int64_t n_decoded_ = 0, n_to_skip_ = 0;  // of all channels
};

/// The sound as ffmpeg writes it, a WAV file of floats. @return frames
std::int64_t take_sound(const Decoding& d, ChildProcess& running, const std::vector<StampGap>& gaps, SoundInfo& info,
                        DecodedSamples& samples) {
  SamplesByTheClock by_the_clock(samples, gaps);
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
    by_the_clock.append(floats, info);
    if (samples.size() / info.n_channels / kMostFfmpegFramesPerByte > d.n_bytes)
      throw FileError(d.name, "ffmpeg finds no end of it: damaged? record or copy it again");
    n_head = 0;
    piece.resize(kFfmpegSamplesAtOnce * sizeof(float));
    piece.resize(running.read(piece));
  }
  return samples.size() / info.n_channels;
}

}  // namespace

SoundInfo decode_by_ffmpeg(const std::filesystem::path& path, const ReadableFile& file, int track,
                           const std::string& reason, DecodedSamples& samples) {
  const std::int64_t n_bytes = SoundBytes(file.descriptor()).size();
  Decoding d{installed("ffmpeg", file.name(), reason),
             installed("ffprobe", file.name(), reason),
             {},
             file.name(),
             file.descriptor(),
             track,
             n_bytes,
             {kLeastOfFfmpeg_cpu_s + kCpuSecondsPerByte * static_cast<double>(n_bytes)}};
  const std::string content = readable(path).native();
  const bool is_of_this_process = content.rfind("/proc/", 0) == 0 || content.rfind("/dev/", 0) == 0;
  // file: a name may begin with a dash, or look like an address on the network
  d.input = "file:" + (is_of_this_process ? "/dev/fd/" + std::to_string(ChildProcess::kHandedOver) : content);
  SoundInfo info;
  std::vector<StampGap> gaps;
  // packets show whether there are any; where they lie in the samples, the decoder's delay taken out, its blocks do
  if (!gaps_between(of_equal_length(ask_what_it_is(d, reason, info))).empty()) gaps = gaps_between(decoded_blocks(d));
  if (track >= info.n_tracks) return info;
  ChildProcess running(d.ffmpeg,
                       joined(d.opening(), {"-nostdin", "-map", d.map(), "-fflags", "+bitexact", "-c:a", "pcm_f32le",
                                            "-f", "wav", "pipe:1"}),
                       d.name, d.descriptor, d.limits);
  info.n_frames = take_sound(d, running, gaps, info, samples);
  const bool ended_well = running.ended_well();
  if (!ended_well || !running.complaints().empty())
    info.warning = "ffmpeg met errors (" + first_line_of(running.complaints(), d.input) + "): the " +
                   std::to_string(info.n_frames) + " samples that it decoded were read; is it cut off?";
  say_gaps(gaps, info);
  info.ffmpeg = version_of(d.ffmpeg, d.name);
  return info;
}

std::string ffmpeg_version_used() {
  const std::lock_guard lock(version_mutex);
  return version_used();
}

}  // namespace bouncelab::audio
