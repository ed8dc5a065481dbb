// SPDX-License-Identifier: GPL-3.0-or-later
// Plain samples in place; coded sound by the decoder as it is, without the process of its own in which the program runs
// it.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "io/sound_header.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

constexpr std::int64_t kMostSamples = 20'000, kAtOnce = 1000;

void check(const audio::SoundInfo& info) {
  require(info.rate_hz >= 4e3 && info.rate_hz <= 4e6, "the sampling rate is in the range promised");
  require(info.n_channels > 0 && info.n_frames > 0, "there are samples");
  require(!info.description.empty() && info.description.size() < 200, "the format is described");
}

void check_samples(const audio::SoundInfo& info, std::span<const float> samples) {
  require(
      info.may_be_infinite || std::all_of(samples.begin(), samples.end(), [](float x) { return std::abs(x) <= 1.0F; }),
      "integers are within full scale");
}

/// From the begin in blocks, then the last frame: all of them are in the file.
void read_plain(FileBytes bytes, const audio::PlainSound& sound) {
  check(sound.info);
  audio::PlainSamples plain(bytes, sound);
  const std::int64_t n = std::min(sound.info.n_frames, kMostSamples / sound.info.n_channels + 1);
  std::vector<float> block(static_cast<std::size_t>(kAtOnce * sound.info.n_channels));
  const auto read = [&](std::int64_t first, std::int64_t n_frames) {
    const std::span<float> samples = std::span(block).first(static_cast<std::size_t>(n_frames * sound.info.n_channels));
    must_accept("plain samples are all in the file", [&] { plain.read(first, samples); });
    check_samples(sound.info, samples);
  };
  for (std::int64_t first = 0; first < n; first += kAtOnce) read(first, std::min(kAtOnce, n - first));
  read(sound.info.n_frames - 1, 1);
}

void decode(FileBytes bytes) {
  audio::SoundDecoder decoder(bytes);
  check(decoder.info());
  std::int64_t n_samples = 0;
  for (auto piece = decoder.next(); !piece.empty() && n_samples < kMostSamples; piece = decoder.next()) {
    check_samples(decoder.info(), piece);
    n_samples += std::ssize(piece);
  }
}

}  // namespace

void run(Bytes input) {
  accepts([&] {
    FileBytes bytes(std::as_bytes(input), "input");
    if (const std::optional<audio::PlainSound> sound = audio::plain_sound(bytes))
      read_plain(bytes, *sound);
    else
      decode(bytes);
  });
}

}  // namespace bouncelab::fuzz
