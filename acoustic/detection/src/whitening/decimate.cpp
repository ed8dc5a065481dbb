// SPDX-License-Identifier: GPL-3.0-or-later
#include "whitening/decimate.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::int64_t kMostHeld = 3 << 20;      // samples, 12 MB: 13 minutes at 4 kHz
constexpr std::int64_t kResultsAtOnce = 1 << 9;  // of the result

std::vector<float> low_pass(int factor) {
  const int reach = 8 * factor;
  const double cutoff = 0.8 / factor;  // of the Nyquist frequency
  std::vector<double> taps;
  double sum = 0.0;
  for (int k = -reach; k <= reach; ++k) {
    const double x = std::numbers::pi * cutoff * k;
    const double window = 0.5 + 0.5 * cos(std::numbers::pi * k / (reach + 1.0));
    taps.push_back(window * (k == 0 ? 1.0 : sin(x) / x));
    sum += taps.back();
  }
  std::vector<float> unit_gain;
  for (const double tap : taps) unit_gain.push_back(static_cast<float>(tap / sum));
  constexpr std::size_t kStep = 16;  // by which audio::filter_and_decimate() goes
  unit_gain.resize((unit_gain.size() + kStep - 1) / kStep * kStep, 0.0F);
  return unit_gain;
}

}  // namespace

audio::AudioSource decimate(const audio::AudioSource& source, int factor) {
  const auto read = [source, factor, taps = low_pass(factor)](std::int64_t first, std::span<float> out) {
    std::vector<float> x(out.size() * static_cast<std::size_t>(factor) + taps.size());
    read_padded(source, (first - 8) * factor, x);
    audio::filter_and_decimate(x, static_cast<std::size_t>(factor), taps, out);
  };
  const std::int64_t n_samples = source.n_samples / factor;
  if (n_samples > kMostHeld) return {source.rate_hz / factor, n_samples, read, source.silences};
  const auto held = std::make_shared<std::vector<float>>(static_cast<std::size_t>(n_samples));
  for (std::int64_t first = 0; first < n_samples; first += kResultsAtOnce)
    read(first, std::span(*held).subspan(static_cast<std::size_t>(first),
                                         static_cast<std::size_t>(std::min(kResultsAtOnce, n_samples - first))));
  const auto copy = [held](std::int64_t first, std::span<float> out) {
    std::copy_n(held->begin() + first, out.size(), out.begin());
  };
  return {source.rate_hz / factor, n_samples, copy, source.silences};
}

}  // namespace bouncelab::detection
