// SPDX-License-Identifier: GPL-3.0-or-later
#include "wave_place.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "fourier.hpp"

namespace bouncelab {
namespace {

constexpr std::size_t kMostPlaces = 8;

struct Peak {
  std::int64_t at = 0;  // in halves
  double height = 0.0;
};

}  // namespace

std::vector<WavePlace> find_places(const WaveTemplate& wave, const Spectrum& sound, double reach) {
  // in halves: at a whole sample's spacing what lies near the Nyquist frequency could be missed altogether
  Fourier twice(2 * wave.n_window());
  const std::vector<float> products = twice.inverse(product_conj(wave.wave(), sound));
  const auto n = static_cast<std::int64_t>(products.size());
  const std::int64_t last = std::min<std::int64_t>(n / 2 - 2, std::llround(2.0 * reach));
  const auto at = [&](std::int64_t k) { return products[static_cast<std::size_t>(k < 0 ? k + n : k)]; };
  Peak best{-last, at(-last)};
  for (std::int64_t k = -last; k <= last; ++k)
    if (at(k) > best.height) best = {k, at(k)};
  std::vector<Peak> peaks;
  for (std::int64_t k = -last; k <= last; ++k) {
    const bool is_peak = (k == -last || at(k) >= at(k - 1)) && (k == last || at(k) >= at(k + 1));
    if (is_peak && at(k) > 0.0F && std::abs(k - best.at) > 2) peaks.push_back({k, at(k)});
  }
  const std::size_t n_others = std::min(peaks.size(), kMostPlaces - 1);
  std::partial_sort(peaks.begin(), peaks.begin() + static_cast<std::ptrdiff_t>(n_others), peaks.end(),
                    [](const Peak& a, const Peak& b) { return a.height > b.height; });
  peaks.resize(n_others);
  // the inverse holds sums of products over sqrt(n_window)
  const double scale = 0.5 * static_cast<double>(wave.n_window()) / wave.energy();
  const double top = std::max(0.0, best.height);
  std::vector<WavePlace> places{{0.5 * static_cast<double>(best.at), 0.0}};
  for (const Peak& peak : peaks)
    places.push_back({0.5 * static_cast<double>(peak.at), scale * (top * top - peak.height * peak.height)});
  return places;
}

}  // namespace bouncelab
