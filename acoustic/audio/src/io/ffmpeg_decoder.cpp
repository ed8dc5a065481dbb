// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/numerics.hpp"
#include "bouncelab/core/text.hpp"
#include "io/coded_sound.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::size_t kAround = 8;         // blocks, some 0.2 s
constexpr double kLeastStep_s = 2e-3;      // stamps of Matroska are whole milliseconds
constexpr double kNearBlocks_s = 1e-3;     // to a whole number of blocks
constexpr double kLongestGap_s = 60.0;     // no ball flies so long
constexpr double kLongestOverlap_s = 1.0;  // of blocks that were written twice

}  // namespace

bool StampGap::is_jump() const { return stamped_s > kLongestGap_s || stamped_s < -kLongestOverlap_s; }

double StampGap::length_s() const { return is_jump() ? kLongestGap_s : stamped_s; }

std::vector<StampGap> gaps_between(const std::vector<StampedBlock>& blocks) {
  std::vector<double> ahead_s;  // of the lengths before
  double sum_s = 0.0;
  for (const StampedBlock& block : blocks) {
    ahead_s.push_back(block.begin_s - sum_s);
    sum_s += block.length_s;
  }
  std::vector<double> lengths_s;
  for (const StampedBlock& block : blocks) lengths_s.push_back(block.length_s);
  const double block_s = lengths_s.empty() ? 0.0 : median(lengths_s);
  std::vector<StampGap> gaps;
  double after_s = 0.0;
  for (std::size_t k = 1; k < blocks.size(); ++k) {
    after_s += blocks[k - 1].length_s;
    const auto here = ahead_s.begin() + static_cast<std::ptrdiff_t>(k);
    const auto begin = ahead_s.begin() + static_cast<std::ptrdiff_t>(k - std::min(k, kAround));
    const auto end = here + static_cast<std::ptrdiff_t>(std::min(blocks.size() - k, kAround));
    const auto [least_before, most_before] = std::minmax_element(begin, here);
    const auto [least_after, most_after] = std::minmax_element(here, end);
    const bool ahead = *least_after - *most_before > kLeastStep_s, back = *most_after - *least_before < -kLeastStep_s;
    if (!ahead && !back) continue;
    // a gap that follows at once raises the later ones of those after it: the nearest few are this one's
    double length_s = *here - *(here - 1);
    const double n_blocks = block_s > 0.0 ? std::round(length_s / block_s) : 0.0;
    if (n_blocks != 0.0 && std::abs(length_s - n_blocks * block_s) < kNearBlocks_s) length_s = n_blocks * block_s;
    gaps.push_back({after_s, length_s});
  }
  return gaps;
}

void say_gaps(const std::vector<StampGap>& gaps, SoundInfo& info) {
  std::vector<std::string> texts;
  std::size_t n_filled = 0;
  double moved_s = 0.0, filled_s = 0.0, overlap_s = 0.0;
  for (const StampGap& gap : gaps) {
    const double begin_s = gap.after_s + moved_s, length_s = gap.length_s();
    moved_s += length_s;
    if (length_s < 0.0) {
      overlap_s -= length_s;
      continue;
    }
    info.silences.push_back({begin_s, begin_s + length_s});
    if (gap.is_jump()) {
      texts.push_back(
          formatted("its time stamps jump by %.0f s at %.4g s: %.0f s of silence stand for the jump, and the "
                    "times that follow are not those of its clock",
                    gap.stamped_s, begin_s, length_s));
    } else {
      filled_s += length_s;
      ++n_filled;
    }
  }
  if (n_filled > 0)
    texts.push_back(
        formatted("its time stamps have %zu gap%s, %.3g s in all, where sound is missing: its times are kept", n_filled,
                  n_filled == 1 ? "" : "s", filled_s));
  if (overlap_s > 0.0)
    texts.push_back(formatted("%.3g s of sound overlap by their time stamps: what came first was kept", overlap_s));
  for (const std::string& text : texts) info.warning += (info.warning.empty() ? "" : "; ") + text;
}

namespace {

static_assert(std::endian::native == std::endian::little);  // as the samples come

// Speech coders hold half an hour of sound in a MB, which ffmpeg decodes at over 100 times its speed.
constexpr double kLeastOfFfmpeg_cpu_s = 20.0;
constexpr double kCpuSecondsPerByte = 30e-6;
constexpr std::int64_t kMostFfmpegFramesPerByte = 1 << 16;  // as FLAC packs silence
constexpr std::size_t kFfmpegSamplesAtOnce = 1 << 14;       // the 64 kB that a pipe holds

/// Of what ffmpeg complained, without the name that it gave the file.
std::string first_line_of(const std::string& complaints, const std::string& input) {
  const std::string line = first_complaint(complaints);
  return line.starts_with(input + ": ") ? line.substr(input.size() + 2) : line;
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

std::vector<std::string> joined(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// A track of sound, as ffprobe describes it.
struct SoundTrack {
  std::string stream;  // its number among all streams of the file
  std::string codec, codec_in_words;
  double rate_hz = 0.0;
  int n_channels = 0;
  std::string layout;  // of the channels: "stereo", "5.1(side)"; "unknown" or empty where the file does not tell
  std::vector<StampedBlock> packets{};
};

/// One recording on its way through ffmpeg.
struct Decoding {
  std::filesystem::path ffmpeg, ffprobe;
  std::string input;  // as ffmpeg is told
  std::string name;
  int descriptor;
  std::int64_t n_bytes;
  ChildLimits limits;

  /// Arguments by which a program opens the recording, and no other file.
  std::vector<std::string> opening() const {
    return {"-v", "error", "-protocol_whitelist", "file,pipe", "-format_whitelist", kContainers, "-i", input};
  }
  /// Arguments by which ffmpeg writes a track as float samples and nothing else, one after the other whatever their
  /// time stamps. What ffprobe says of rate and channels is given back: a decoder that finds others (parametric stereo,
  /// a rate that changes) is resampled to them, so that both agree. A layout is given where there is one, since ffmpeg
  /// assumes a layout for a number of channels and mixes any other into it.
  std::vector<std::string> decoding(const SoundTrack& track) const {
    const bool has_layout = !track.layout.empty() && track.layout != "unknown";
    return joined(opening(), {"-nostdin", "-map", "0:" + track.stream, "-af", "asetpts=N/SR/TB", "-ar",
                              formatted("%.0f", track.rate_hz), has_layout ? "-channel_layout" : "-ac",
                              has_layout ? track.layout : std::to_string(track.n_channels), "-f", "f32le", "pipe:1"});
  }
};

// A packet takes 60 bytes of ffprobe's answer and holds 20 ms or so: a day of sound.
constexpr std::size_t kMostOfAnswer_bytes = std::size_t{1} << 28;

constexpr const char* kShown =  // of the file
    "packet=stream_index,pts_time,duration_time:"
    "stream=index,codec_name,codec_long_name,sample_rate,channels,channel_layout:format=format_long_name";

/// The tracks of sound that ffmpeg knows the codec of, in the order of their streams.
/// @param lines  ffprobe's answer: packets, then streams
std::vector<SoundTrack> tracks_in(const std::string& lines) {
  std::map<int, SoundTrack> tracks;  // by stream: a transport stream lists each under its program too
  std::map<int, std::vector<StampedBlock>> packets;
  std::vector<StampedBlock>* of_stream = nullptr;
  SoundTrack* track = nullptr;
  std::istringstream in(lines);
  for (std::string line; std::getline(in, line);) {
    const std::size_t equals = std::min(line.find('='), line.size());
    const std::string key = line.substr(0, equals), value = line.substr(std::min(equals + 1, line.size()));
    const double number = std::strtod(value.c_str(), nullptr);  // "N/A" is 0
    if (key == "stream_index") (of_stream = &packets[static_cast<int>(number)])->emplace_back();
    if (key == "pts_time" && of_stream && value != "N/A") of_stream->back().begin_s = number;
    if (key == "duration_time" && of_stream) of_stream->back().length_s = number;
    if (key == "index") (track = &tracks[static_cast<int>(number)])->stream = value;
    if (!track) continue;
    if (key == "codec_name") track->codec = value;
    if (key == "codec_long_name") track->codec_in_words = value;
    if (key == "sample_rate") track->rate_hz = number;
    if (key == "channels") track->n_channels = static_cast<int>(number);
    if (key == "channel_layout") track->layout = value;
  }
  std::vector<SoundTrack> known;
  for (auto& [stream, of] : tracks) {
    if (of.codec.empty() || of.codec == "unknown" || of.codec == "none") continue;
    of.packets = std::move(packets[stream]);
    known.push_back(std::move(of));
  }
  return known;
}

/// What the file is. @param reason  why libsndfile does not read it
/// @return the track; of a number that the file does not have: nothing, which the reader refuses
std::optional<SoundTrack> ask_what_it_is(const Decoding& d, int number, const std::string& reason, SoundInfo& info) {
  const ProgramResult answer = run_program(
      d.ffprobe,
      joined(d.opening(), {"-select_streams", "a", "-show_entries", kShown, "-of", "default=noprint_wrappers=1"}),
      d.name, d.descriptor, d.limits, kMostOfAnswer_bytes);
  if (answer.complaints.find("not on whitelist") != std::string::npos)
    throw FileError(
        d.name,
        "is a list of other files, a picture, or another format in which no sound is recorded; name the recording");
  if (!answer.ended_well)
    throw FileError(d.name, "not readable as audio (libsndfile: " + reason + "; ffmpeg: " +
                                first_line_of(answer.complaints, d.input) + "); record or copy it again");
  std::vector<SoundTrack> tracks = tracks_in(answer.output);
  const std::string format = value_of(answer.output, "format_long_name");
  if (tracks.empty()) throw FileError(d.name, "holds no sound (" + format + "); name a recording with sound");
  info.n_tracks = static_cast<int>(tracks.size());
  if (number < 0 || number >= info.n_tracks) return std::nullopt;
  SoundTrack& track = tracks[static_cast<std::size_t>(number)];
  if (track.rate_hz > 0.0) check_rate(track.rate_hz, d.name);
  if (!(track.rate_hz > 0.0) || track.n_channels <= 0) throw FileError(d.name, "holds no samples; record again");
  info.track = number;
  info.rate_hz = track.rate_hz;
  info.n_channels = track.n_channels;
  info.description = format + ", " + track.codec_in_words;
  if (!is_lossless(track.codec)) info.lossy_coding = name_of_coding(track.codec);
  return std::move(track);
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

/// The blocks of samples as they are decoded, with their time stamps; a stamp that is missing is where the block before
/// ends.
std::vector<StampedBlock> decoded_blocks(const Decoding& d, const SoundTrack& track) {
  const ProgramResult answer =
      run_program(d.ffprobe,
                  joined(d.opening(), {"-select_streams", track.stream, "-show_entries",
                                       "frame=best_effort_timestamp_time,nb_samples", "-of", "csv=print_section=0"}),
                  d.name, d.descriptor, d.limits, kMostOfAnswer_bytes);
  std::vector<StampedBlock> blocks;
  std::istringstream lines(answer.output);
  for (std::string line; std::getline(lines, line);) {
    const double n_samples = std::strtod(line.c_str() + std::min(line.find(',') + 1, line.size()), nullptr);
    const double next_s = blocks.empty() ? 0.0 : blocks.back().begin_s + blocks.back().length_s;
    blocks.push_back(
        {line.rfind("N/A", 0) == 0 ? next_s : std::strtod(line.c_str(), nullptr), n_samples / track.rate_hz});
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
      const std::int64_t n = samples_in(gaps_.front().length_s());
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

/// The sound as ffmpeg writes it: samples and nothing else. @return frames
std::int64_t take_sound(const Decoding& d, ChildProcess& running, const std::vector<StampGap>& gaps,
                        const SoundInfo& info, DecodedSamples& samples) {
  SamplesByTheClock by_the_clock(samples, gaps);
  std::vector<float> piece(kFfmpegSamplesAtOnce);
  while (const std::size_t n = running.read(std::as_writable_bytes(std::span(piece))) / sizeof(float)) {
    by_the_clock.append(std::span(piece).first(n), info);
    if (samples.size() / info.n_channels / kMostFfmpegFramesPerByte > d.n_bytes)
      throw FileError(d.name, "ffmpeg finds no end of it: damaged? record or copy it again");
  }
  if (samples.size() > 0) return samples.size() / info.n_channels;
  if (running.ended_well() && running.complaints().empty()) throw FileError(d.name, "holds no samples; record again");
  throw FileError(d.name, "ffmpeg cannot decode it (" + first_line_of(running.complaints(), d.input) +
                              "); record or copy it again");
}

}  // namespace

SoundInfo decode_by_ffmpeg(const std::filesystem::path& path, const FileBytes& file, int track,
                           const std::string& reason, DecodedSamples& samples) {
  const std::int64_t n_bytes = file.size();
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
  std::vector<StampGap> gaps;
  const std::optional<SoundTrack> of_file = ask_what_it_is(d, track, reason, info);
  if (!of_file) return info;
  // packets show whether there are any; where they lie in the samples, the decoder's delay taken out, its blocks do
  if (!gaps_between(of_equal_length(of_file->packets)).empty()) gaps = gaps_between(decoded_blocks(d, *of_file));
  ChildProcess running(d.ffmpeg, d.decoding(*of_file), d.name, d.descriptor, d.limits);
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
