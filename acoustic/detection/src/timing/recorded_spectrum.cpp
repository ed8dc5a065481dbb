// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/recorded_spectrum.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "bouncelab/core/elementary.hpp"

namespace bouncelab::detection {
namespace {

/// Squared gain of the whitener at the template's bins, in some unit.
std::vector<double> gain2(const ImpactTemplate& learned) {
  const std::size_t n_window = learned.filter.n_window();
  // long enough for the whitener also at low rates
  const std::size_t n = std::max(n_window, std::bit_ceil(learned.whitener.size()));
  audio::RealFft fourier(n);
  const audio::Spectrum response = fourier.forward(learned.whitener);
  std::vector<double> gain(learned.filter.spectrum().size());
  for (std::size_t k = 0; k < gain.size(); ++k) {
    const std::size_t at = k * (n / n_window);
    gain[k] = square(static_cast<double>(response.re[at])) + square(static_cast<double>(response.im[at]));
  }
  return gain;
}

}  // namespace

double recorded_rms_frequency(const ImpactTemplate& learned) {
  const std::vector<double> gain = gain2(learned);
  double power = 0.0, squares = 0.0;
  for (std::size_t k = 1; k < gain.size(); ++k) {
    const double here = learned.filter.energy(k, k + 1) / (gain[k] + 1e-30);
    power += here;
    squares += here * square(static_cast<double>(k));
  }
  return std::max(1e-6, std::sqrt(squares / (power + 1e-300)) / static_cast<double>(learned.filter.n_window()));
}

}  // namespace bouncelab::detection
