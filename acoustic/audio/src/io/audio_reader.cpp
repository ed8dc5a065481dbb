// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/audio_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/input_file.hpp"
#include "bouncelab/core/table.hpp"
#include "io/ffmpeg_decoder.hpp"
#include "io/flac_decoder.hpp"
#include "io/guarded_decoder.hpp"
#include "io/not_finite.hpp"
#include "io/npy.hpp"
#include "io/number_text.hpp"
#include "io/pcm_decode.hpp"
#include "io/readable_file.hpp"
#include "io/sample_memory.hpp"
#include "io/sound_decoder.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kFramesPerPiece = 1 << 14;  // 64 kB of one channel: stays in the cache
constexpr std::int64_t kFramesOfJump = 1 << 10;
constexpr std::int64_t kFramesWithoutCopy = 1 << 12;  // from here on a copy takes longer than what lies between pieces
// samples up to which a recording is held whole: 64 MB where decoding costs more than memory, 4 MB where it does not
constexpr std::int64_t kMostHeldWhole = 1 << 24;
constexpr std::int64_t kMostPlainHeldWhole = 1 << 20;
constexpr std::int64_t kLongestHeader = 1 << 16;  // bytes, of which a sink is told

}  // namespace

struct AudioReader::State {
  std::unique_ptr<ReadableFile> file;  // none where the bytes are in memory
  std::string name;
  SoundBytes bytes;
  // one of these has the samples, or the file itself where they are plain
  std::optional<GuardedDecoder> guarded;
  std::optional<FfmpegDecoder> ffmpeg;
  std::optional<NumberText> numbers;
  std::optional<SoundDecoder> decoder;  // of bytes in memory
  SoundInfo info;
  AudioFormat format;
  std::unique_ptr<std::byte[]> raw;  // what was read of plain samples
  std::int64_t buffered_first = 0;   // interleaved frames kept from the last read, so that channels share them
  SampleMemory buffer;
  std::span<float> buffered;  // in the buffer, or in the guarded decoder's
  BytesSink bytes_read;       // may be empty
  bool is_header_told = false;

  State(const std::filesystem::path& path, std::optional<double> rate_hz, BytesSink bytes_read_)
      : file(std::make_unique<ReadableFile>(path)),
        name(file->name()),
        bytes(file->descriptor()),
        bytes_read(std::move(bytes_read_)) {
    if (rate_hz && !(*rate_hz >= kLowestRate_hz && *rate_hz <= kHighestRate_hz))
      throw InvalidArgument("--rate: must be 4 kHz to 4 MHz");
    if (is_npy(bytes)) {
      set_info(npy_info(bytes, name, rate_hz));
      return;
    }
    try {
      guarded.emplace(file->descriptor(), name);
      set_info(guarded->info());
    } catch (const NotForLibsndfile& error) {
      open_otherwise(path, rate_hz, error.reason);
    }
    if (rate_hz && !numbers)
      throw InvalidArgument("--rate: " + name + " has a sampling rate of its own; leave --rate out");
  }
  State(std::span<const std::byte> bytes_, std::string name_) : name(std::move(name_)), bytes(bytes_) {
    decoder.emplace(bytes, name);
    set_info(decoder->info());
  }

  void open_otherwise(const std::filesystem::path& path, std::optional<double> rate_hz, const std::string& reason) {
    if (is_text(bytes)) {
      std::ifstream in = open_text(path);
      numbers.emplace(in, name, rate_hz);
      return set_info(numbers->info());
    }
    ffmpeg.emplace(readable(path), file->descriptor(), name, reason);
    set_info(ffmpeg->info());
    format.ffmpeg = ffmpeg_version_used();
  }

  void set_info(const SoundInfo& found) {
    info = found;
    format = {info.rate_hz, info.n_channels, info.n_frames, info.description, info.lossy_coding, {}, info.warning};
  }

  bool is_plain() const { return info.plain != PlainEncoding::none; }

  bool is_coded() const { return guarded && !is_plain(); }

  bool is_held_whole() const {
    if (ffmpeg) return ffmpeg->is_whole();
    return info.n_frames <= (is_plain() ? kMostPlainHeldWhole : kMostHeldWhole) / info.n_channels;
  }

  /// @param n_wanted  frames; what goes on from the last ones is read in larger pieces
  void fill_buffer(std::int64_t first, std::int64_t n_wanted) {
    const bool whole = is_held_whole();
    if (whole && is_coded()) return hold_until(std::min(first + n_wanted, info.n_frames));
    if (whole) first = 0;
    const std::int64_t n_most = whole ? info.n_frames : std::min(kFramesPerPiece, info.n_frames);
    const bool goes_on = first == buffered_first + std::ssize(buffered) / info.n_channels;
    const std::int64_t n = std::min(
        whole || goes_on || !is_plain() ? n_most : std::clamp(n_wanted, std::min(kFramesOfJump, n_most), n_most),
        info.n_frames - first);
    buffered = {};
    buffered = ffmpeg       ? ffmpeg->read(first, n)
               : is_coded() ? guarded->read(first, n)
                            : read_into_buffer(first, n, n_most);
    buffered_first = first;
    if (info.may_be_infinite) check_finite(0);
  }

  /// Of a recording that the guarded decoder holds whole: the frames before `end`, and those that are decoded anyway.
  void hold_until(std::int64_t end) {
    const std::size_t n_before = buffered.size();
    if (std::ssize(buffered) >= end * info.n_channels) return;
    const std::span<float> whole = place_of_whole();
    buffered = whole.first(static_cast<std::size_t>(guarded->read_whole(end, whole) * info.n_channels));
    if (info.may_be_infinite) check_finite(n_before);
  }

  std::span<float> place_of_whole() {
    const auto n = static_cast<std::size_t>(info.n_frames * info.n_channels);
    if (!buffer) buffer = sample_memory(n);
    return {buffer.get(), n};
  }

  std::span<float> read_into_buffer(std::int64_t first, std::int64_t n, std::int64_t n_most) {
    if (!buffer) buffer = sample_memory(static_cast<std::size_t>(n_most * info.n_channels));
    const std::span<float> filled{buffer.get(), static_cast<std::size_t>(n * info.n_channels)};
    if (is_plain())
      read_plain(first, filled);
    else if (numbers)
      numbers->read(first, filled);
    else
      decoder->read(first, filled);
    return filled;
  }

  void read_plain(std::int64_t first, std::span<float> out) {
    const std::int64_t frame_bytes = std::int64_t{bytes_per_sample(info.plain)} * info.n_channels;
    const std::int64_t n = std::ssize(out) / info.n_channels;
    if (!raw)
      raw.reset(new std::byte[static_cast<std::size_t>(std::min(kFramesPerPiece, info.n_frames) * frame_bytes)]);
    if (bytes_read && !is_header_told) tell_header();
    for (std::int64_t done = 0; done < n;) {
      const std::int64_t n_here = std::min(kFramesPerPiece, n - done);
      const std::span<std::byte> piece{raw.get(), static_cast<std::size_t>(n_here * frame_bytes)};
      const std::int64_t at = info.first_byte + (first + done) * frame_bytes;
      const std::int64_t n_bytes = bytes.read(at, piece);
      if (bytes_read) bytes_read(at, piece.first(static_cast<std::size_t>(n_bytes)));
      const std::int64_t got = n_bytes / frame_bytes;
      decode_pcm(piece, info.plain,
                 out.subspan(static_cast<std::size_t>(done * info.n_channels),
                             static_cast<std::size_t>(got * info.n_channels)));
      done += got;
      if (got == n_here) continue;
      if (bytes.error() != 0)
        throw FileError(name,
                        std::string("cannot be read (") + std::strerror(bytes.error()) + "); copy it to a local disk");
      throw FileError(name, ends_early(first + done, info.n_frames));
    }
  }

  /// What lies before the samples: so that who is told of all samples in order has seen all that is before them.
  void tell_header() {
    is_header_told = true;
    std::vector<std::byte> header(static_cast<std::size_t>(std::min(info.first_byte, kLongestHeader)));
    const std::int64_t n_bytes = bytes.read(0, header);
    bytes_read(0, std::span(header).first(static_cast<std::size_t>(n_bytes)));
  }

  /// @param from  sample of the buffer
  void check_finite(std::size_t from) const {
    const std::size_t bad = from + first_not_finite(buffered.subspan(from));
    if (bad == buffered.size()) return;
    const auto index = static_cast<std::int64_t>(bad);
    const std::int64_t frame = buffered_first + index / format.n_channels;
    throw FileError(name, "sample " + std::to_string(frame) + " (" +
                              std::to_string(static_cast<double>(frame) / format.rate_hz) + " s) of channel " +
                              std::to_string(index % format.n_channels) +
                              " is not a finite number; repair the recording");
  }
};

AudioReader::AudioReader(const std::filesystem::path& path, std::optional<double> rate_hz, BytesSink bytes_read)
    : state_(std::make_unique<State>(path, rate_hz, std::move(bytes_read))) {}

AudioReader::AudioReader(std::span<const std::byte> bytes, const std::string& name)
    : state_(std::make_unique<State>(bytes, name)) {}

AudioReader::AudioReader(AudioReader&&) noexcept = default;
AudioReader& AudioReader::operator=(AudioReader&&) noexcept = default;
AudioReader::~AudioReader() = default;

const AudioFormat& AudioReader::format() const { return state_->format; }

void AudioReader::read(std::int64_t first, int channel, std::span<float> out) {
  State& s = *state_;
  const auto n = static_cast<std::int64_t>(out.size());
  if (first < 0 || n > s.format.n_frames - first || channel < 0 || channel >= s.format.n_channels)
    throw InvalidArgument(std::to_string(n) + " samples from " + std::to_string(first) + " on of channel " +
                          std::to_string(channel) + ": the recording has " + std::to_string(s.format.n_frames) +
                          " samples in " + std::to_string(s.format.n_channels) + " channels");
  for (std::int64_t done = 0; done < n;) {
    const std::int64_t at = first + done;
    const std::int64_t n_buffered = static_cast<std::int64_t>(s.buffered.size()) / s.format.n_channels;
    if (at < s.buffered_first || at >= s.buffered_first + n_buffered) {
      if (n - done >= kFramesWithoutCopy && s.is_plain() && s.format.n_channels == 1 && !s.info.may_be_infinite)
        return s.read_plain(at, out.subspan(static_cast<std::size_t>(done)));  // without a copy
      s.fill_buffer(at, n - done);
      continue;
    }
    const std::int64_t n_here = std::min(n - done, s.buffered_first + n_buffered - at);
    const float* from = s.buffered.data() + (at - s.buffered_first) * s.format.n_channels + channel;
    if (s.format.n_channels == 1) std::copy_n(from, n_here, out.begin() + done);
    for (std::int64_t k = 0; k < n_here && s.format.n_channels > 1; ++k) out[done + k] = from[k * s.format.n_channels];
    done += n_here;
  }
}

bool AudioReader::gains_by_more_readers() const {
  return state_->is_coded() && state_->info.can_begin_anywhere && !state_->is_held_whole();
}

AudioSource AudioReader::source(int channel) {
  State& s = *state_;
  AudioSource source{s.format.rate_hz,
                     s.format.n_frames,
                     [this, channel](std::int64_t first, std::span<float> out) { read(first, channel, out); },
                     {},
                     0};
  if (s.format.n_channels == 1 && s.is_held_whole() && s.is_coded()) {
    source.resident = s.place_of_whole();
    if (std::ssize(s.buffered) < s.format.n_frames) {
      s.guarded->read_whole(0, s.place_of_whole());  // is being decoded from now on
      source.wait_for = [&s](std::int64_t end) { s.hold_until(end); };
    }
  } else if (s.format.n_channels == 1 && s.is_held_whole()) {
    if (s.buffered.empty()) s.fill_buffer(0, s.format.n_frames);
    source.resident = s.buffered;
  }
  return source;
}

void prepare_to_read(const std::filesystem::path& path, int n_threads) {
  std::error_code error;
  bool needs_libsndfile = true;
  if (std::filesystem::is_regular_file(path, error)) {
    try {
      const ReadableFile file(path);
      needs_libsndfile = !is_flac(SoundBytes(file.descriptor()));
    } catch (const FileError&) {  // the reader will say so
    }
  }
  GuardedDecoder::start_process(n_threads, needs_libsndfile);
}

}  // namespace bouncelab::audio
