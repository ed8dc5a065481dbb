// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/sound_file.hpp"

#include <sndfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <string>
#include <utility>

#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/text.hpp"

namespace bouncelab::audio {
namespace {

/// WAV counts its bytes in 32 bits; the margin holds the header's chunks.
constexpr double kWavLimit_bytes = 4294967295.0 - 65536.0;
/// What the frame header of FLAC can encode (RFC 9639, 9.1.2 and 8.2): 20 bits of Hz.
constexpr int kFlacMaxRate_hz = 655350;

struct EncodedAs {
  int subtype, bytes_per_sample;
};
/// By SampleEncoding.
constexpr std::array<EncodedAs, 4> kEncodings{
    {{SF_FORMAT_PCM_16, 2}, {SF_FORMAT_PCM_24, 3}, {SF_FORMAT_PCM_32, 4}, {SF_FORMAT_FLOAT, 4}}};
const EncodedAs& encoded_as(SampleEncoding encoding) { return kEncodings[static_cast<std::size_t>(encoding)]; }

std::string lower_extension(const std::filesystem::path& path) { return lower_case(path.extension().string()); }

int container(const std::filesystem::path& path, const AudioSpec& spec, std::int64_t n_frames) {
  const std::string extension = lower_extension(path);
  if (extension == ".flac") return SF_FORMAT_FLAC;
  if (extension == ".w64") return SF_FORMAT_W64;
  if (extension == ".rf64") return SF_FORMAT_RF64;
  if (extension != ".wav" && !(extension.empty() && is_stream(path)))  // no name tells
    throw InvalidArgument(path.string() + ": no sound format has the extension '" + extension +
                          "'; use .wav, .flac, .w64 or .rf64");
  const double n_bytes = static_cast<double>(n_frames) * spec.n_channels * encoded_as(spec.encoding).bytes_per_sample;
  return n_bytes > kWavLimit_bytes ? SF_FORMAT_RF64 : SF_FORMAT_WAV;
}

/// Of samples of full scale 1.
double full_scale(SampleEncoding encoding) { return std::ldexp(1.0, 8 * encoded_as(encoding).bytes_per_sample - 1); }

double steps(double x, double full_scale) {
  const double rounded = std::nearbyint(x * full_scale);
  const double at_least = rounded < -full_scale ? -full_scale : rounded;
  return at_least > full_scale - 1 ? full_scale - 1 : at_least;
}

float clipped_to_float(double x) { return static_cast<float>(std::clamp(x, -1.0, 1.0)); }

/// Whole steps in the upper bits of 32.
BOUNCELAB_VECTOR_CLONES void left_align(const double* x, std::size_t n, double full_scale, int* words) {
  const double step_to_32_bits = 0x1p31 / full_scale;
  for (std::size_t k = 0; k < n; ++k) words[k] = static_cast<int>(steps(x[k], full_scale) * step_to_32_bits);
}

BOUNCELAB_VECTOR_CLONES void round_to_steps(const double* x, std::size_t n, double full_scale, float* samples) {
  const double step = 1.0 / full_scale;  // a power of two
  for (std::size_t k = 0; k < n; ++k) samples[k] = static_cast<float>(steps(x[k], full_scale) * step);
}

SF_INFO checked_info(const std::filesystem::path& path, const AudioSpec& spec, std::int64_t n_frames) {
  const std::string name = path.string();
  SF_INFO info{};
  info.samplerate = spec.rate_hz;
  info.channels = spec.n_channels;
  info.format = container(path, spec, n_frames) | encoded_as(spec.encoding).subtype;
  if (spec.rate_hz <= 0)
    throw InvalidArgument(name + ": sample rate " + std::to_string(spec.rate_hz) + " Hz; it must be positive");
  if (lower_extension(path) == ".flac") {
    if (spec.rate_hz > kFlacMaxRate_hz)
      throw InvalidArgument(name + ": FLAC cannot hold " + std::to_string(spec.rate_hz) + " Hz (at most " +
                            std::to_string(kFlacMaxRate_hz) + " Hz); use .wav");
    if (spec.encoding == SampleEncoding::pcm32 || spec.encoding == SampleEncoding::float32)
      throw InvalidArgument(name + ": FLAC holds 16 or 24 bits here, not 32 bits or float; use .wav or fewer bits");
  }
  if (sf_format_check(&info) == 0)
    throw InvalidArgument(name + ": this format cannot hold " + std::to_string(spec.n_channels) + " channels at " +
                          std::to_string(spec.rate_hz) + " Hz; use .wav");
  return info;
}

/// What libsndfile writes into. Given a descriptor alone (sf_open_fd) it keeps no errors of what its encoder of FLAC
/// writes, last of all when it is closed: a full disk would leave half a recording that passes for a whole one. So the
/// first is kept here.
struct Sink {
  int descriptor = -1;
  int error = 0;  ///< errno
};

sf_count_t length_of(void* sink) {
  struct stat status {};
  return ::fstat(static_cast<Sink*>(sink)->descriptor, &status) == 0 ? status.st_size : -1;
}

sf_count_t seek_in(sf_count_t offset, int whence, void* sink) {
  return ::lseek(static_cast<Sink*>(sink)->descriptor, offset, whence);
}

sf_count_t read_from(void* to, sf_count_t n, void* sink) {
  return ::read(static_cast<Sink*>(sink)->descriptor, to, static_cast<std::size_t>(n));
}

sf_count_t write_to(const void* from, sf_count_t n, void* user_data) {
  Sink& sink = *static_cast<Sink*>(user_data);  // nothing may be thrown through libsndfile
  const char* bytes = static_cast<const char*>(from);
  for (sf_count_t at = 0; at < n;) {
    const ssize_t n_written = ::write(sink.descriptor, bytes + at, static_cast<std::size_t>(n - at));
    if (n_written < 0 && errno == EINTR) continue;
    if (n_written <= 0) {
      if (sink.error == 0) sink.error = n_written < 0 ? errno : ENOSPC;
      return at;
    }
    at += n_written;
  }
  return n;
}

sf_count_t place_in(void* sink) { return ::lseek(static_cast<Sink*>(sink)->descriptor, 0, SEEK_CUR); }

}  // namespace

struct AudioWriter::State {
  State(const std::filesystem::path& path, SampleEncoding encoding_, bool may_replace)
      : name(path.string()), encoding(encoding_), output(path, may_replace) {}
  ~State() {
    if (file) sf_close(file);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void throw_if_writing_failed() const {
    if (sink.error != 0) throw FileError(name, why_writing_failed(sink.error));
  }
  void check_written(sf_count_t n_written, std::size_t n) const {
    throw_if_writing_failed();
    if (n_written != static_cast<sf_count_t>(n))
      throw FileError(name, std::string("writing failed (") + sf_strerror(file) + "); is the disk full?");
  }

  std::string name;
  SampleEncoding encoding;
  std::vector<int> words;
  std::vector<float> floats;
  OutputFile output;  // destroyed after the file in it is closed
  Sink sink;
  SNDFILE* file = nullptr;
};

AudioWriter::AudioWriter(const std::filesystem::path& path, const AudioSpec& spec, std::int64_t n_frames,
                         bool may_replace) {
  SF_INFO info = checked_info(path, spec, n_frames);
  state_ = std::make_shared<State>(path, spec.encoding, may_replace);
  state_->sink.descriptor = state_->output.descriptor();
  SF_VIRTUAL_IO calls{length_of, seek_in, read_from, write_to, place_in};
  state_->file = sf_open_virtual(&calls, SFM_WRITE, &info, &state_->sink);
  if (!state_->file) throw FileError(state_->name, std::string("cannot be written: ") + sf_strerror(nullptr));
  // the PEAK chunk carries the time of writing: the same sound would not be the same bytes
  sf_command(state_->file, SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);
}

void AudioWriter::write(std::span<const double> interleaved) {
  if (state_->encoding == SampleEncoding::float32) {
    std::vector<float>& floats = state_->floats;
    floats.resize(interleaved.size());
    std::transform(interleaved.begin(), interleaved.end(), floats.begin(), clipped_to_float);
    return write_floats(floats);
  }
  // rounded here: libsndfile cuts off the lower bits, half a step of offset
  std::vector<int>& words = state_->words;
  words.resize(interleaved.size());
  left_align(interleaved.data(), interleaved.size(), full_scale(state_->encoding), words.data());
  state_->check_written(sf_write_int(state_->file, words.data(), std::ssize(words)), words.size());
}

void AudioWriter::write(std::span<const float> interleaved) {
  if (state_->encoding == SampleEncoding::float32) return write_floats(interleaved);
  write(std::vector<double>(interleaved.begin(), interleaved.end()));
}

void AudioWriter::write_floats(std::span<const float> interleaved) {
  state_->check_written(sf_write_float(state_->file, interleaved.data(), std::ssize(interleaved)), interleaved.size());
}

void AudioWriter::commit() {
  const int status = sf_close(std::exchange(state_->file, nullptr));
  state_->throw_if_writing_failed();
  if (status != 0) throw FileError(state_->name, std::string("closing failed: ") + sf_error_number(status));
  state_->output.commit();
}

std::vector<float> as_read_back(std::span<const double> samples, SampleEncoding encoding) {
  std::vector<float> floats(samples.size());
  if (encoding == SampleEncoding::float32)
    std::transform(samples.begin(), samples.end(), floats.begin(), clipped_to_float);
  else
    round_to_steps(samples.data(), samples.size(), full_scale(encoding), floats.data());
  return floats;
}

void validate(const std::filesystem::path& path, const AudioSpec& spec) { checked_info(path, spec, 0); }

}  // namespace bouncelab::audio
