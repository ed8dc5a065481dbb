// SPDX-License-Identifier: GPL-3.0-or-later
#include "bouncelab/audio/dsp/decimate.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"

namespace bouncelab::audio {
namespace {

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
  constexpr std::size_t kAtOnce = 32;  // by which dot() goes; what is left over would take most of its time
  unit_gain.resize((unit_gain.size() + kAtOnce - 1) / kAtOnce * kAtOnce, 0.0F);
  return unit_gain;
}

}  // namespace

AudioSource decimate(const AudioSource& source, int factor) {
  const auto read = [source, factor, taps = low_pass(factor)](std::int64_t first, std::span<float> out) {
    std::vector<float> x(out.size() * static_cast<std::size_t>(factor) + taps.size());
    read_padded(source, (first - 8) * factor, x);
    for (std::size_t n = 0; n < out.size(); ++n)
      out[n] = static_cast<float>(dot(taps, std::span(x).subspan(n * static_cast<std::size_t>(factor), taps.size())));
  };
  return {source.rate_hz / factor, source.n_samples / factor, read, {}, 0};
}

}  // namespace bouncelab::audio
