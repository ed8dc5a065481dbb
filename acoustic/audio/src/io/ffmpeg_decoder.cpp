// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/ffmpeg_decoder.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <mutex>
#include <optional>
#include <sstream>
#include <utility>

#include "bouncelab/audio/audio_reader.hpp"
#include "bouncelab/core/error.hpp"

namespace bouncelab::audio {
namespace {

static_assert(std::endian::native == std::endian::little);  // as the samples come

// Speech coders hold half an hour of sound in a MB, which ffmpeg decodes at over 100 times its speed.
constexpr double kLeastOfFfmpeg_cpu_s = 20.0;
constexpr double kCpuSecondsPerByte = 30e-6;
constexpr std::int64_t kMostFfmpegFramesPerByte = 1 << 16;  // as FLAC packs silence
constexpr std::size_t kFfmpegSamplesAtOnce = 1 << 16;
constexpr std::size_t kLongestWavHead_bytes = 4096;
constexpr std::int32_t kMostFfmpegChannels = 1024;

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

void remember_version(const std::filesystem::path& ffmpeg, const std::string& name, int descriptor) {
  const std::lock_guard lock(version_mutex);
  if (!version_used().empty()) return;
  std::istringstream words(run_program(ffmpeg, {"-version"}, name, descriptor, kLeastOfFfmpeg_cpu_s).output);
  std::string program, version, value;  // "ffmpeg version 5.1.9-0+deb12u1 Copyright ..."
  words >> program >> version >> value;
  version_used() = value.empty() ? "unknown version" : value;
}

/// What is said of a recording that only ffmpeg might decode, where there is none.
/// @param reason  why libsndfile does not read it
std::string unreadable_without_ffmpeg(const std::string& reason) {
#ifdef __EMSCRIPTEN__  // a browser, which decodes by itself what ffmpeg would
  return "not readable as sound (" + reason + "); choose another file, or record again";
#else
  return "not readable as audio by libsndfile (" + reason +
         "); install ffmpeg, which is then used by itself (Debian, Ubuntu: apt install ffmpeg; macOS: brew install "
         "ffmpeg)";
#endif
}

std::filesystem::path installed(const std::string& program, const std::string& name, const std::string& reason) {
  if (const auto found = find_program(program)) return *found;
  throw FileError(name, unreadable_without_ffmpeg(reason));
}

/// The pipe's WAV head, up to its samples. @return false where the pipe ends before
bool read_head(ProgramOutput& from, double& rate_hz, std::int32_t& n_channels) {
  std::array<std::byte, 12> riff{};
  std::array<std::byte, 8> head{};
  if (from.read(riff) < riff.size()) return false;
  for (;;) {
    if (from.read(head) < head.size()) return false;
    if (std::memcmp(head.data(), "data", 4) == 0) return true;
    std::uint32_t n = 0;
    std::memcpy(&n, head.data() + 4, sizeof n);
    std::vector<std::byte> content(std::min<std::size_t>(n + n % 2, kLongestWavHead_bytes));
    if (n > kLongestWavHead_bytes || from.read(content) < content.size()) return false;
    if (std::memcmp(head.data(), "fmt ", 4) != 0 || content.size() < 16) continue;
    std::uint16_t channels = 0;
    std::uint32_t rate = 0;
    std::memcpy(&channels, content.data() + 2, sizeof channels);
    std::memcpy(&rate, content.data() + 4, sizeof rate);
    n_channels = channels;
    rate_hz = rate;
  }
}

}  // namespace

FfmpegDecoder::FfmpegDecoder(const std::filesystem::path& content, int descriptor, std::string name,
                             const std::string& reason)
    : ffmpeg_(installed("ffmpeg", name, reason)),
      ffprobe_(installed("ffprobe", name, reason)),
      name_(std::move(name)),
      descriptor_(descriptor) {
  const std::string& path = content.native();
  const bool is_of_this_process = path.rfind("/proc/", 0) == 0 || path.rfind("/dev/", 0) == 0;
  // file: a name may begin with a dash, or look like an address on the network
  input_ = "file:" + (is_of_this_process ? "/dev/fd/" + std::to_string(ProgramOutput::kHandedOver) : path);
  const std::int64_t n_bytes = SoundBytes(descriptor).size();
  cpu_s_ = kLeastOfFfmpeg_cpu_s + kCpuSecondsPerByte * static_cast<double>(n_bytes);
  n_most_frames_ = n_bytes * kMostFfmpegFramesPerByte;
  ask_what_it_is(reason);
  count();
  remember_version(ffmpeg_, name_, descriptor_);
}

void FfmpegDecoder::ask_what_it_is(const std::string& reason) {
  const ProgramResult answer = run_program(
      ffprobe_,
      {"-v", "error", "-protocol_whitelist", "file", "-select_streams", "a:0", "-show_entries",
       "stream=codec_name,codec_long_name:format=format_long_name", "-of", "default=noprint_wrappers=1", "-i", input_},
      name_, descriptor_, cpu_s_);
  if (!answer.ended_well)
    throw FileError(name_, "not readable as audio (libsndfile: " + reason +
                               "; ffmpeg: " + first_line_of(answer.complaints, input_) + "); record or copy it again");
  const std::string codec = value_of(answer.output, "codec_name");
  const std::string format = value_of(answer.output, "format_long_name");
  if (codec.empty()) throw FileError(name_, "holds no sound (" + format + "); name a recording with sound");
  info_.may_be_infinite = true;
  info_.description = format + ", " + value_of(answer.output, "codec_long_name");
  if (!is_lossless(codec)) info_.lossy_coding = name_of_coding(codec);
}

void FfmpegDecoder::start() {
  running_.reset();  // one at a time
  running_ = std::make_unique<ProgramOutput>(
      ffmpeg_,
      std::vector<std::string>{"-nostdin", "-v", "error", "-protocol_whitelist", "file,pipe", "-i", input_, "-map",
                               "0:a:0", "-fflags", "+bitexact", "-c:a", "pcm_f32le", "-f", "wav", "pipe:1"},
      name_, descriptor_, cpu_s_);
  double rate_hz = 0.0;
  std::int32_t n_channels = 0;
  if (!read_head(*running_, rate_hz, n_channels)) {
    running_->ended_well();
    throw FileError(name_, "ffmpeg cannot decode it (" + first_line_of(running_->complaints(), input_) +
                               "); record or copy it again");
  }
  info_.rate_hz = rate_hz;
  info_.n_channels = n_channels;
  check_rate(rate_hz, name_);
  if (n_channels <= 0 || n_channels > kMostFfmpegChannels)
    throw FileError(name_, "has no number of channels that can be");
  window_.clear();
  window_.reserve(static_cast<std::size_t>(kMostSamples));  // pages are taken when they are written
  window_first_ = 0;
}

/// Appends whole frames to the window. @return samples; 0 at the end
std::size_t FfmpegDecoder::append(std::size_t n_samples) {
  const auto n_channels = static_cast<std::size_t>(info_.n_channels);
  const std::size_t before = window_.size();
  window_.resize(before + n_samples / n_channels * n_channels);
  const std::size_t n_bytes = running_->read(std::as_writable_bytes(std::span(window_).subspan(before)));
  const std::size_t n = n_bytes / sizeof(float) / n_channels * n_channels;
  window_.resize(before + n);
  return n;
}

void FfmpegDecoder::count() {
  start();
  const auto n_channels = static_cast<std::size_t>(info_.n_channels);
  is_whole_ = true;
  std::int64_t n_samples = 0;
  while (const std::size_t n = append(std::max(kFfmpegSamplesAtOnce, n_channels))) {
    n_samples += static_cast<std::int64_t>(n);
    if (n_samples / info_.n_channels > n_most_frames_)
      throw FileError(name_, "ffmpeg finds no end of it: damaged? record or copy it again");
    is_whole_ = is_whole_ && std::ssize(window_) <= kMostSamples - static_cast<std::int64_t>(kFfmpegSamplesAtOnce);
    if (!is_whole_) window_.clear();
  }
  const bool ended_well = running_->ended_well();
  const std::string complaints = running_->complaints();
  running_.reset();
  info_.n_frames = n_samples / info_.n_channels;
  if (info_.n_frames == 0)
    throw FileError(
        name_, ended_well && complaints.empty()
                   ? "holds no samples; record again"
                   : "ffmpeg cannot decode it (" + first_line_of(complaints, input_) + "); record or copy it again");
  if (!ended_well || !complaints.empty())
    info_.warning = "ffmpeg met errors (" + first_line_of(complaints, input_) + "): the " +
                    std::to_string(info_.n_frames) + " samples that it decoded were read; is it cut off?";
  if (!is_whole_) window_ = {};
}

std::span<float> FfmpegDecoder::read(std::int64_t first, std::int64_t n_frames) {
  const std::int64_t n_channels = info_.n_channels;
  const std::int64_t last = first + n_frames;
  const auto window_last = [&] { return window_first_ + std::ssize(window_) / n_channels; };
  if (!is_whole_ && (!running_ || first < window_first_)) start();
  while (window_last() < last) {
    if (std::ssize(window_) + static_cast<std::int64_t>(kFfmpegSamplesAtOnce) > kMostSamples) {  // its older half goes
      const std::int64_t n_gone = window_last() - window_first_ - kMostSamples / 2 / n_channels;
      window_.erase(window_.begin(), window_.begin() + n_gone * n_channels);
      window_first_ += n_gone;
    }
    if (append(std::max(kFfmpegSamplesAtOnce, static_cast<std::size_t>(n_channels))) == 0)
      throw FileError(name_, "ffmpeg decoded " + std::to_string(info_.n_frames) + " samples before, and now " +
                                 std::to_string(window_last()) + "; is the file being written?");
  }
  return std::span(window_).subspan(static_cast<std::size_t>((first - window_first_) * n_channels),
                                    static_cast<std::size_t>(n_frames * n_channels));
}

std::string ffmpeg_version_used() {
  const std::lock_guard lock(version_mutex);
  return version_used();
}

}  // namespace bouncelab::audio
