// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/sound_file.hpp"

#include <algorithm>
#include <fstream>
#include <numeric>

#include "bouncelab/core/error.hpp"
#include "bouncelab/core/files.hpp"
#include "bouncelab/core/table.hpp"
#include "io/coded_sound.hpp"
#include "io/sound_header.hpp"

namespace bouncelab::audio {
namespace {

constexpr std::int64_t kFramesAtOnce = 1 << 12;  // 16 kB of one channel: stays in the cache

}  // namespace

struct AudioReader::State {
  FileBytes file;
  SoundInfo info;
  std::optional<PlainSamples> plain;
  DecodedSamples decoded;  // of what is not plain

  State(const std::filesystem::path& path, std::optional<double> rate_hz, int track)
      : file(path), decoded(file.name()) {
    open(path, rate_hz, track);
    if (track < 0 || track >= info.n_tracks)
      throw InvalidArgument("track " + std::to_string(track) + ": " + file.name() + " has tracks 0 to " +
                            std::to_string(info.n_tracks - 1));
  }

  void open(const std::filesystem::path& path, std::optional<double> rate_hz, int track) {
    if (rate_hz && !(*rate_hz >= kLowestRate_hz && *rate_hz <= kHighestRate_hz))
      throw InvalidArgument("--rate: must be 4 kHz to 4 MHz");
    if (file.size() == 0) throw FileError(file.name(), "the file is empty (0 bytes); record again");
    if (is_npy(file)) return open_plain(npy_sound(file, rate_hz));
    if (is_text(file)) {
      std::ifstream in = open_text(path);
      info = read_number_text(in, file.name(), rate_hz, decoded);
      return;
    }
    if (const std::optional<PlainSound> sound = plain_sound(file))
      open_plain(*sound);
    else
      info = decode_coded(path, file, track, decoded);
    if (const std::string more = what_follows(file); !more.empty())
      info.warning += (info.warning.empty() ? "" : "; ") + more;
    if (rate_hz) throw InvalidArgument("--rate: " + file.name() + " has a sampling rate of its own; leave --rate out");
  }

  void open_plain(const PlainSound& sound) {
    info = sound.info;
    plain.emplace(file, sound);
  }

  /// Interleaved frames from `first` on.
  void read(std::int64_t first, std::span<float> frames) {
    if (plain)
      plain->read(first, frames);
    else
      decoded.read(first * info.n_channels, frames);
    if (info.may_be_infinite) check_finite(first, frames);
  }

  void check_finite(std::int64_t first, std::span<const float> frames) const {
    const std::size_t bad = first_unusable(frames);
    if (bad == frames.size()) return;
    const auto index = static_cast<std::int64_t>(bad);
    const std::int64_t frame = first + index / info.n_channels;
    throw FileError(file.name(), "sample " + std::to_string(frame) + " (" +
                                     std::to_string(static_cast<double>(frame) / info.rate_hz) + " s) of channel " +
                                     std::to_string(index % info.n_channels) +
                                     " is not a finite number below 1e12 (full scale is 1); repair the recording");
  }
};

AudioReader::AudioReader(const std::filesystem::path& path, std::optional<double> rate_hz, int track)
    : state_(std::make_shared<State>(path, rate_hz, track)) {}

const AudioFormat& AudioReader::format() const { return state_->info; }

void AudioReader::read(std::int64_t first, int channel, std::span<float> out) const {
  const SoundInfo& info = state_->info;
  const std::int64_t n = std::ssize(out), n_channels = info.n_channels;
  if (first < 0 || n > info.n_frames - first || channel < 0 || channel >= n_channels)
    throw InvalidArgument(std::to_string(n) + " samples from " + std::to_string(first) + " on of channel " +
                          std::to_string(channel) + ": the recording has " + std::to_string(info.n_frames) +
                          " samples in " + std::to_string(n_channels) + " channels");
  if (n_channels == 1) return state_->read(first, out);
  std::vector<float> frames(static_cast<std::size_t>(std::min(n, kFramesAtOnce) * n_channels));
  for (std::int64_t done = 0; done < n; done += kFramesAtOnce) {
    const std::int64_t n_here = std::min(kFramesAtOnce, n - done);
    state_->read(first + done, std::span(frames).first(static_cast<std::size_t>(n_here * n_channels)));
    const float* from = frames.data() + channel;
    for (std::int64_t k = 0; k < n_here; ++k, from += n_channels) out[static_cast<std::size_t>(done + k)] = *from;
  }
}

std::vector<int> AudioReader::channels_with_sound() const {
  const SoundInfo& info = state_->info;
  const auto n_channels = static_cast<std::size_t>(info.n_channels);
  std::vector<int> silent(n_channels), with_sound;
  std::iota(silent.begin(), silent.end(), 0);
  std::vector<float> first, frames;
  for (std::int64_t done = 0; done < info.n_frames && !silent.empty(); done += kFramesAtOnce) {
    frames.resize(static_cast<std::size_t>(std::min(info.n_frames - done, kFramesAtOnce)) * n_channels);
    state_->read(done, frames);
    if (done == 0) first.assign(frames.begin(), frames.begin() + info.n_channels);
    std::erase_if(silent, [&](int channel) {
      for (auto k = static_cast<std::size_t>(channel); k < frames.size(); k += n_channels)
        if (frames[k] != first[static_cast<std::size_t>(channel)]) {
          with_sound.push_back(channel);
          return true;
        }
      return false;
    });
  }
  std::sort(with_sound.begin(), with_sound.end());
  return with_sound;
}

AudioSource AudioReader::source(int channel) const {
  const AudioFormat& of = format();
  return {of.rate_hz, of.n_frames,
          [reader = *this, channel](std::int64_t first, std::span<float> out) { reader.read(first, channel, out); },
          of.silences};
}

}  // namespace bouncelab::audio
