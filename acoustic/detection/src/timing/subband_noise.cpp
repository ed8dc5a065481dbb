// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/subband_noise.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/white_window.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kMinNoise = 1e-6;  // of white noise of variance 1

struct QuietWindow {
  double weighted_power = 0.0;  // with the weights of the delay, over all sub-bands
  double energy = 0.0;          // sum of squares
  std::vector<double> power;    // by sub-band
};

QuietWindow measure_power(const audio::Spectrum& sound, const MatchedFilter& filter, const Subbands& subbands) {
  QuietWindow quiet;
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    const double sum = filter.information_times_power_of(sound, subbands.edge[j], subbands.edge[j + 1]);
    quiet.power.push_back(0.5 * sum / (filter.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30));
    quiet.weighted_power += sum;
  }
  return quiet;
}

}  // namespace

double estimate_noise(audio::WhiteSound& sound, const std::vector<float>& whitener,
                      const std::vector<std::int64_t>& begins, const MatchedFilter& filter, Subbands& subbands) {
  audio::RealFft fourier(filter.n_window());
  std::vector<QuietWindow> windows;
  windows.reserve(begins.size());
  std::vector<float> white(filter.n_window());
  audio::Spectrum spectrum;
  for (const std::int64_t begin : begins) {
    const std::int64_t first = begin - static_cast<std::int64_t>(filter.n_window());
    sound.read(whitener, first, white);
    fourier.forward(white, spectrum);
    windows.push_back(measure_power(spectrum, filter, subbands));
    windows.back().energy = audio::dot(white, white);
  }
  const std::size_t n_quiet = (windows.size() + 1) / 2;
  // sorted, not parted: the order of the sums below would be that of one standard library
  std::sort(windows.begin(), windows.end(),
            [](const QuietWindow& a, const QuietWindow& b) { return a.weighted_power < b.weighted_power; });
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n_quiet; ++k) sum += windows[k].power[j];
    subbands.noise[j] = std::max(sum / static_cast<double>(n_quiet), kMinNoise);
  }
  double energy = 0.0;
  for (std::size_t k = 0; k < n_quiet; ++k) energy += windows[k].energy / static_cast<double>(n_quiet);
  return energy;
}

}  // namespace bouncelab::detection
