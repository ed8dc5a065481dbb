// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/audio_reader.hpp"

#include <sndfile.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "io/pcm_decode.hpp"

namespace bouncelab::audio {
namespace {

constexpr double kLowestRate_hz = 4e3;  // below, a contact of steel on glass (30 us) leaves nothing to time
constexpr double kHighestRate_hz = 4e6;
constexpr std::int64_t kFramesAtOnce = 1 << 14;  // 64 kB of one channel: stays in the cache
constexpr std::uint32_t kExponent = 0x7f800000;  // of a float
// samples up to which a recording is held whole: 64 MB where decoding costs more than memory, 4 MB where it does not
constexpr std::int64_t kMostHeldWhole = 1 << 24;
constexpr std::int64_t kMostPlainHeldWhole = 1 << 20;

/// The ISO base media signature of m4a, mp4, mov.
bool is_mpeg4(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::array<char, 8> head{};
  return in.read(head.data(), head.size()) && std::string(head.data() + 4, 4) == "ftyp";
}

void check_not_empty(const std::filesystem::path& file, const std::string& name) {
  std::error_code error;
  if (std::filesystem::file_size(file, error) == 0 && !error)
    throw FileError(name, "the file is empty (0 bytes); record again");
}

/// libsndfile reads a truncated WAV without an error; only its log shows the length given in the header:
/// "data : 1000 (should be 500)". Streamed files (ffmpeg to a pipe) give 2^32-1 or 0, which is not an error.
void check_promised_length(SNDFILE* file, const std::string& name) {
  std::array<char, 16384> log{};
  sf_command(file, SFC_GET_LOG_INFO, log.data(), log.size());
  const std::string text(log.data());
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string line = text.substr(begin, end - begin);
    begin = end + 1;
    line.erase(0, std::min(line.find_first_not_of(' '), line.size()));
    const std::size_t correction = line.find("(should be ");
    if (line.rfind("data", 0) != 0 && line.rfind("SSND", 0) != 0 && line.rfind("Data Size", 0) != 0) continue;
    const std::size_t colon = line.find(':');
    if (correction == std::string::npos || colon == std::string::npos) continue;
    const double promised = std::atof(line.c_str() + colon + 1);
    const double held = std::atof(line.c_str() + correction + 11);
    if (promised > held && promised < 4294967000.0)
      throw FileError(name, "the header promises " + std::to_string(static_cast<long long>(promised)) +
                                " bytes of source, the file holds " + std::to_string(static_cast<long long>(held)) +
                                "; copy it again whole, or repair it: ffmpeg -i IN OUT.wav");
  }
}

/// Integers are finite; floats, and what a lossy codec makes, need not be.
bool may_be_infinite(int format) {
  const int sub = format & SF_FORMAT_SUBMASK;
  return sub != SF_FORMAT_PCM_S8 && sub != SF_FORMAT_PCM_U8 && sub != SF_FORMAT_PCM_16 && sub != SF_FORMAT_PCM_24 &&
         sub != SF_FORMAT_PCM_32;
}

std::string describe_format(int format) {
  SF_FORMAT_INFO major{};
  SF_FORMAT_INFO sub{};
  major.format = format & SF_FORMAT_TYPEMASK;
  sub.format = format & SF_FORMAT_SUBMASK;
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &major, sizeof major);
  sf_command(nullptr, SFC_GET_FORMAT_INFO, &sub, sizeof sub);
  return std::string(major.name ? major.name : "?") + ", " + (sub.name ? sub.name : "?");
}

/// Bytes of an integer where the file holds little-endian integers of 16 or 24 bits one after the other, on a processor
/// of the same order; 0 where libsndfile must decode.
int bytes_of_plain_integer(SNDFILE* file, int format) {
  const int container = format & SF_FORMAT_TYPEMASK;
  const bool may_be = container == SF_FORMAT_WAV || container == SF_FORMAT_WAVEX || container == SF_FORMAT_RF64 ||
                      container == SF_FORMAT_W64 || container == SF_FORMAT_AIFF || container == SF_FORMAT_AU ||
                      container == SF_FORMAT_CAF;
  const bool is_native = std::endian::native == std::endian::little &&
                         sf_command(file, SFC_RAW_DATA_NEEDS_ENDSWAP, nullptr, 0) == SF_FALSE;
  if (!may_be || !is_native) return 0;
  const int sub = format & SF_FORMAT_SUBMASK;
  return sub == SF_FORMAT_PCM_16 ? 2 : sub == SF_FORMAT_PCM_24 ? 3 : 0;
}

}  // namespace

struct AudioReader::State {
  std::string name;
  SNDFILE* file = nullptr;
  AudioFormat format;
  bool may_be_infinite = true;
  int n_plain_bytes = 0;            // of an integer that need not be decoded by libsndfile; 0: it must
  std::vector<unsigned char> raw;   // what was read of such integers
  std::int64_t next_frame = 0;      // where libsndfile stands
  std::int64_t buffered_first = 0;  // interleaved frames kept from the last read, so that channels share them
  std::unique_ptr<float[]> buffer;
  std::span<float> buffered;  // what of the buffer is filled

  ~State() {
    if (file != nullptr) sf_close(file);
  }

  bool is_held_whole() const {
    return format.n_frames * format.n_channels <= (n_plain_bytes > 0 ? kMostPlainHeldWhole : kMostHeldWhole);
  }

  void fill_buffer(std::int64_t first) {
    const bool whole = is_held_whole();
    if (whole) first = 0;
    const std::int64_t n_most = whole ? format.n_frames : std::min(kFramesAtOnce, format.n_frames);
    // not a vector, which would set to zero what is overwritten at once
    if (!buffer) buffer.reset(new float[static_cast<std::size_t>(n_most * format.n_channels)]);
    const std::int64_t n = std::min(n_most, format.n_frames - first);
    buffered = {};
    decode(first, n);
    buffered = {buffer.get(), static_cast<std::size_t>(n * format.n_channels)};
    buffered_first = first;
    if (may_be_infinite) check_finite();
  }

  /// Into the buffer.
  void decode(std::int64_t first, std::int64_t n) {
    if (first != next_frame && sf_seek(file, first, SEEK_SET) != first)
      throw FileError(name, "cannot go to sample " + std::to_string(first) + ": " + sf_strerror(file));
    std::int64_t n_done = 0;
    for (std::int64_t got = 1; got > 0 && n_done < n; n_done += got)
      got = read_frames(buffer.get() + n_done * format.n_channels, std::min(kFramesAtOnce, n - n_done));
    next_frame = first + n_done;
    if (n_done == n) return;
    throw FileError(name, "ends at sample " + std::to_string(next_frame) + " of the " +
                              std::to_string(format.n_frames) +
                              " its header promises; copy it again whole, or repair it: ffmpeg -i IN OUT.wav");
  }

  /// @return how many of n frames there were
  std::int64_t read_frames(float* to, std::int64_t n) {
    if (n_plain_bytes == 0) return sf_readf_float(file, to, n);
    const auto frame_bytes = std::int64_t{n_plain_bytes} * format.n_channels;
    raw.resize(static_cast<std::size_t>(n * frame_bytes));
    const std::int64_t got = sf_read_raw(file, raw.data(), n * frame_bytes) / frame_bytes;
    decode_pcm(raw.data(), n_plain_bytes, to, got * format.n_channels);
    return got;
  }

  void check_finite() const {
    // all exponent bits set is how infinity and NaN are written: one pass of integers
    std::uint32_t n_bad = 0;
    for (const float x : buffered) n_bad += (std::bit_cast<std::uint32_t>(x) & kExponent) == kExponent ? 1 : 0;
    if (n_bad == 0) return;
    const auto bad = std::find_if(buffered.begin(), buffered.end(), [](float x) { return !std::isfinite(x); });
    const std::int64_t index = bad - buffered.begin();
    const std::int64_t frame = buffered_first + index / format.n_channels;
    throw FileError(name, "sample " + std::to_string(frame) + " (" +
                              std::to_string(static_cast<double>(frame) / format.rate_hz) + " s) of channel " +
                              std::to_string(index % format.n_channels) +
                              " is not a finite number; repair the recording");
  }
};

AudioReader::AudioReader(std::filesystem::path path) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.name = input_name(path);
  const std::filesystem::path content = readable(path);
  check_not_empty(content, s.name);
  SF_INFO info{};
  s.file = sf_open(content.c_str(), SFM_READ, &info);
  if (s.file == nullptr) {
    if (is_mpeg4(content))
      throw FileError(s.name, "is MPEG-4 audio (m4a), which libsndfile cannot read; convert it: ffmpeg -i \"" + s.name +
                                  "\" out.wav");
    std::string reason = sf_strerror(nullptr);
    while (!reason.empty() && (reason.back() == '.' || reason.back() == '\n')) reason.pop_back();
    throw FileError(s.name, "not readable as audio (" + reason + "); convert it: ffmpeg -i IN OUT.wav");
  }
  s.format = {static_cast<double>(info.samplerate), info.channels, info.frames, describe_format(info.format)};
  s.may_be_infinite = may_be_infinite(info.format);
  check_promised_length(s.file, s.name);
  if (info.frames <= 0 || info.channels <= 0) throw FileError(s.name, "holds no samples; record again");
  if (s.format.rate_hz < kLowestRate_hz || s.format.rate_hz > kHighestRate_hz)
    throw FileError(s.name, "sampling rate " + std::to_string(info.samplerate) +
                                " Hz: must be 4 kHz to 4 MHz; correct the header or record again");
  s.n_plain_bytes = bytes_of_plain_integer(s.file, info.format);
}

AudioReader::AudioReader(AudioReader&&) noexcept = default;
AudioReader& AudioReader::operator=(AudioReader&&) noexcept = default;
AudioReader::~AudioReader() = default;

const AudioFormat& AudioReader::format() const { return state_->format; }

void AudioReader::read(std::int64_t first, int channel, std::span<float> out) {
  State& s = *state_;
  const auto n = static_cast<std::int64_t>(out.size());
  if (first < 0 || first + n > s.format.n_frames || channel < 0 || channel >= s.format.n_channels)
    throw InvalidArgument("samples " + std::to_string(first) + " ... " + std::to_string(first + n) + " of channel " +
                          std::to_string(channel) + ": the recording has " + std::to_string(s.format.n_frames) +
                          " samples in " + std::to_string(s.format.n_channels) + " channels");
  for (std::int64_t done = 0; done < n;) {
    const std::int64_t at = first + done;
    const std::int64_t n_buffered = static_cast<std::int64_t>(s.buffered.size()) / s.format.n_channels;
    if (at < s.buffered_first || at >= s.buffered_first + n_buffered) {
      s.fill_buffer(at);
      continue;
    }
    const std::int64_t n_here = std::min(n - done, s.buffered_first + n_buffered - at);
    const float* from = s.buffered.data() + (at - s.buffered_first) * s.format.n_channels + channel;
    if (s.format.n_channels == 1) std::copy_n(from, n_here, out.begin() + done);
    for (std::int64_t k = 0; k < n_here && s.format.n_channels > 1; ++k) out[done + k] = from[k * s.format.n_channels];
    done += n_here;
  }
}

AudioSource AudioReader::source(int channel) {
  State& s = *state_;
  AudioSource source{s.format.rate_hz,
                     s.format.n_frames,
                     [this, channel](std::int64_t first, std::span<float> out) { read(first, channel, out); },
                     {},
                     0};
  if (s.format.n_channels == 1 && s.is_held_whole()) {
    if (s.buffered.empty()) s.fill_buffer(0);
    source.resident = s.buffered;
  }
  return source;
}

}  // namespace bouncelab::audio
