// SPDX-License-Identifier: GPL-3.0-or-later
// The decoder as it is, without the process of its own in which the program runs it.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "io/sound_decoder.hpp"
#include "target.hpp"

namespace bouncelab::fuzz {
namespace {

constexpr std::int64_t kMostSamples = 20'000, kAtOnce = 1000;

void check(const audio::SoundInfo& info, std::size_t n_bytes) {
  require(info.rate_hz >= 4e3 && info.rate_hz <= 4e6, "the sampling rate is in the range promised");
  require(info.n_channels > 0 && info.n_frames > 0, "there are samples");
  require(!info.description.empty() && info.description.size() < 200, "the format is described");
  if (info.plain == audio::PlainEncoding::none) return;
  const auto n_held = static_cast<std::int64_t>(n_bytes) - info.first_byte;
  require(info.first_byte >= 0 && info.n_frames <= n_held / (bytes_per_sample(info.plain) * info.n_channels),
          "plain samples are all in the file");
}

/// From the begin in blocks, then the last frame, then the first again.
void read_through(audio::SoundDecoder& decoder) {
  const audio::SoundInfo& info = decoder.info();
  const std::int64_t n = std::min(info.n_frames, kMostSamples / info.n_channels + 1);
  std::vector<float> block(static_cast<std::size_t>(kAtOnce * info.n_channels));
  const auto frames = [&](std::int64_t n_frames) {
    return std::span(block).first(static_cast<std::size_t>(n_frames * info.n_channels));
  };
  for (std::int64_t first = 0; first < n; first += kAtOnce) {
    const std::span<float> samples = frames(std::min(kAtOnce, n - first));
    decoder.read(first, samples);
    require(info.may_be_infinite ||
                std::all_of(samples.begin(), samples.end(), [](float x) { return std::abs(x) <= 1.0F; }),
            "integers are within full scale");
  }
  decoder.read(info.n_frames - 1, frames(1));
  decoder.read(0, frames(1));
}

}  // namespace

void run(Bytes input) {
  accepts([&] {
    audio::SoundDecoder decoder(audio::SoundBytes(std::as_bytes(input)), "input");
    check(decoder.info(), input.size());
    read_through(decoder);
  });
}

}  // namespace bouncelab::fuzz
