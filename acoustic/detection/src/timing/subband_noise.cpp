// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/subband_noise.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/white_window.hpp"

namespace bouncelab::detection {
namespace {

constexpr double kLeastNoise = 1e-6;  // of white noise of variance 1

struct Quiet {
  double told = 0.0;          // what it would tell of a time, by all subbands
  double energy = 0.0;        // sum of squares
  std::vector<double> power;  // by subband
};

Quiet power_of(const audio::Spectrum& sound, const MatchedFilter& wave, const Subbands& subbands) {
  Quiet quiet;
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    double sum = 0.0;
    for (std::size_t k = subbands.edge[j]; k < subbands.edge[j + 1]; ++k)
      sum += wave.information(k, k + 1) *
             (static_cast<double>(sound.re[k]) * sound.re[k] + static_cast<double>(sound.im[k]) * sound.im[k]);
    quiet.power.push_back(0.5 * sum / (wave.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30));
    quiet.told += sum;
  }
  return quiet;
}

}  // namespace

double estimate_noise(const audio::AudioSource& sound, const std::vector<float>& whitener,
                      const std::vector<std::int64_t>& begins, const MatchedFilter& wave, Subbands& subbands) {
  audio::RealFft fourier(wave.n_window());
  std::vector<Quiet> windows;
  for (const std::int64_t begin : begins) {
    const std::int64_t first = begin - static_cast<std::int64_t>(wave.n_window());
    const std::vector<float> white = audio::read_white(sound, whitener, first, wave.n_window()).sound;
    windows.push_back(power_of(fourier.forward(white), wave, subbands));
    windows.back().energy = audio::dot(white, white);
  }
  const std::size_t n_quiet = (windows.size() + 1) / 2;
  std::nth_element(windows.begin(), windows.begin() + static_cast<std::ptrdiff_t>(n_quiet - 1), windows.end(),
                   [](const Quiet& a, const Quiet& b) { return a.told < b.told; });
  for (std::size_t j = 0; j < subbands.n(); ++j) {
    double sum = 0.0;
    for (std::size_t k = 0; k < n_quiet; ++k) sum += windows[k].power[j];
    subbands.noise[j] = std::max(sum / static_cast<double>(n_quiet), kLeastNoise);
  }
  double energy = 0.0;
  for (std::size_t k = 0; k < n_quiet; ++k) energy += windows[k].energy / static_cast<double>(n_quiet);
  return energy;
}

}  // namespace bouncelab::detection
