// SPDX-License-Identifier: GPL-3.0-or-later
#include "wave_place.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "fourier.hpp"

namespace bouncelab {

WavePlace find_place(const WaveTemplate& wave, const Spectrum& sound, double reach) {
  // in halves: at a whole sample's spacing what lies near the Nyquist frequency could be missed altogether
  Fourier twice(2 * wave.n_window());
  const std::vector<float> products = twice.inverse(product_conj(wave.wave(), sound));
  const auto n = static_cast<std::int64_t>(products.size());
  const std::int64_t last = std::min<std::int64_t>(n / 2 - 2, std::llround(2.0 * reach));
  const auto at = [&](std::int64_t k) { return products[static_cast<std::size_t>(k < 0 ? k + n : k)]; };
  std::int64_t best = -last;
  for (std::int64_t k = -last; k <= last; ++k)
    if (at(k) > at(best)) best = k;
  WavePlace found{0.5 * static_cast<double>(best), 0.5 * static_cast<double>(best), INFINITY};
  double second = 0.0;
  for (std::int64_t k = -last; k <= last; ++k) {
    const bool is_peak = (k == -last || at(k) >= at(k - 1)) && (k == last || at(k) >= at(k + 1));
    if (!is_peak || std::abs(k - best) <= 2 || at(k) <= second) continue;
    second = at(k);
    found.runner_up = 0.5 * static_cast<double>(k);
  }
  // the inverse holds sums of products over sqrt(n_window)
  const double top = std::max(0.0, static_cast<double>(at(best)));
  found.lead = 0.5 * static_cast<double>(wave.n_window()) * (top * top - second * second) / wave.energy();
  return found;
}

}  // namespace bouncelab
