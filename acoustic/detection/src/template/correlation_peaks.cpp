// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/correlation_peaks.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {

Correlation::Correlation(const MatchedFilter& filter, const audio::Spectrum& sound, double from, double to)
    // the inverse holds sums of products over sqrt(n_window)
    : scale_(0.5 * static_cast<double>(filter.n_window()) / filter.energy()) {
  // steps of half a sample: with whole samples a peak near the Nyquist frequency could fall between two steps
  const std::size_t n_lags = 2 * filter.n_window();
  const auto n = static_cast<std::int64_t>(n_lags);
  lowest_ = std::clamp<std::int64_t>(std::llround(2.0 * from), 2 - n / 2, n / 2 - 2);
  const std::int64_t highest = std::clamp<std::int64_t>(std::llround(2.0 * to), lowest_, n / 2 - 2);
  values_.reserve(static_cast<std::size_t>(highest - lowest_ + 3));
  values_.push_back(-INFINITY);
  const audio::Spectrum spectrum = audio::product_conj(filter.spectrum(), sound);
  const std::span<const float> products = audio::RealFft(n_lags).inverse(spectrum.re, spectrum.im);
  // negative shifts are at the end
  if (lowest_ < 0)
    values_.insert(values_.end(), products.end() + lowest_, products.end() + std::min<std::int64_t>(0, highest + 1));
  if (highest >= 0)
    values_.insert(values_.end(), products.begin() + std::max<std::int64_t>(0, lowest_),
                   products.begin() + highest + 1);
  values_.push_back(-INFINITY);
  top_ = static_cast<std::size_t>(std::max_element(values_.begin(), values_.end()) - values_.begin());
}

CorrelationPeak Correlation::peak_at(std::size_t k) const {
  const double height = std::max(0.0, static_cast<double>(values_[k]));
  return {0.5 * static_cast<double>(static_cast<std::int64_t>(k) - 1 + lowest_), scale_ * height * height};
}

std::vector<CorrelationPeak> Correlation::peaks() const {
  constexpr std::size_t kMostOthers = 7;
  std::vector<std::size_t> others;
  for (std::size_t k = 1; k + 1 < values_.size(); ++k)
    if (values_[k] > 0.0F && values_[k] >= values_[k - 1] && values_[k] >= values_[k + 1] &&
        (k > top_ ? k - top_ : top_ - k) > 2)
      others.push_back(k);
  const std::size_t n = std::min(others.size(), kMostOthers);
  std::partial_sort(
      others.begin(), others.begin() + static_cast<std::ptrdiff_t>(n), others.end(),
      [&](std::size_t a, std::size_t b) { return std::pair(-values_[a], a) < std::pair(-values_[b], b); });
  others.resize(n);
  std::vector<CorrelationPeak> found{highest()};
  for (const std::size_t k : others) found.push_back(peak_at(k));
  return found;
}

}  // namespace bouncelab::detection
