// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/correlation_peaks.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/real_fft.hpp"
#include "bouncelab/core/vector_clones.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMaxPeaks = 8;
constexpr std::size_t kAtOnce = 64;  // values tested at once: most hold nothing

// no branches but one for many values: they would be mispredicted half of the time
BOUNCELAB_VECTOR_CLONES bool any_equal(const float* x, std::size_t n, float value) {
  int any = 0;
  for (std::size_t k = 0; k < n; ++k) any |= static_cast<int>(x[k] == value);
  return any != 0;
}

/// 1 for each local maximum above `least`, 0 for others.
/// @param x  n values and one on either side
BOUNCELAB_VECTOR_CLONES void mark_peaks(const float* x, std::size_t n, float least, std::uint8_t* __restrict marks) {
  const float* before = x - 1;
  const float* after = x + 1;
  for (std::size_t k = 0; k < n; ++k)
    marks[k] = static_cast<std::uint8_t>(static_cast<int>(x[k] > least) & static_cast<int>(x[k] >= before[k]) &
                                         static_cast<int>(x[k] >= after[k]));
}

/// The first mark from k on; kAtOnce where there is none. Marks that are far apart are found eight values at a time.
std::size_t place_of_mark(const std::array<std::uint8_t, kAtOnce>& marks, std::size_t k) {
  for (; k < kAtOnce; ++k) {
    std::uint64_t eight = 0;
    if (k % sizeof eight == 0) {
      for (; k < kAtOnce; k += sizeof eight) {
        std::memcpy(&eight, marks.data() + k, sizeof eight);
        if (eight != 0) break;
      }
      if (k >= kAtOnce) return kAtOnce;
    }
    if (marks[k] != 0) return k;
  }
  return kAtOnce;
}

/// The first place of the largest value.
std::size_t place_of_largest(const std::vector<float>& x) {
  const float value = audio::largest(x);
  std::size_t k = 0;
  while (k + kAtOnce < x.size() && !any_equal(x.data() + k, kAtOnce, value)) k += kAtOnce;
  while (x[k] != value) ++k;
  return k;
}

}  // namespace

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
  const std::vector<float> products = audio::RealFft(n_lags).inverse(audio::product_conj(filter.spectrum(), sound));
  // negative shifts are at the end
  if (lowest_ < 0)
    values_.insert(values_.end(), products.end() + lowest_, products.end() + std::min<std::int64_t>(0, highest + 1));
  if (highest >= 0)
    values_.insert(values_.end(), products.begin() + std::max<std::int64_t>(0, lowest_),
                   products.begin() + highest + 1);
  values_.push_back(-INFINITY);
  top_ = place_of_largest(values_);
}

CorrelationPeak Correlation::peak_at(std::size_t k) const {
  const double height = std::max(0.0, static_cast<double>(values_[k]));
  return {0.5 * static_cast<double>(static_cast<std::int64_t>(k) - 1 + lowest_), scale_ * height * height};
}

std::vector<CorrelationPeak> Correlation::peaks(double least_log_likelihood_ratio) const {
  constexpr double kRounding = 1e-5;  // relative: heights are single precision
  std::vector<std::size_t> others;    // the highest, by falling height
  // that is of interest
  auto least = static_cast<float>((1.0 - kRounding) * std::sqrt(std::max(0.0, least_log_likelihood_ratio) / scale_));
  const auto take = [&](std::size_t k) {
    if (!(values_[k] > least) || (k > top_ ? k - top_ : top_ - k) <= 2) return;
    others.insert(std::upper_bound(others.begin(), others.end(), k,
                                   [&](std::size_t a, std::size_t b) { return values_[a] > values_[b]; }),
                  k);
    if (others.size() < kMaxPeaks) return;
    others.pop_back();
    least = values_[others.back()];
  };
  const std::size_t end = values_.size() - 1;
  std::array<std::uint8_t, kAtOnce> marks{};
  for (std::size_t at = 1; at < end; at += kAtOnce) {
    const std::size_t n = std::min(kAtOnce, end - at);
    mark_peaks(values_.data() + at, n, least, marks.data());
    for (std::size_t k = 0; (k = place_of_mark(marks, k)) < n; ++k) take(at + k);
  }
  std::vector<CorrelationPeak> found{highest()};
  for (const std::size_t k : others) found.push_back(peak_at(k));
  return found;
}

}  // namespace bouncelab::detection
