// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/correlation_peaks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/audio/dsp/real_fft.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMaxPeaks = 8;

struct Peak {
  std::int64_t at = 0;  // in halves of a sample
  double height = 0.0;
};

}  // namespace

std::vector<CorrelationPeak> find_correlation_peaks(const MatchedFilter& filter, const audio::Spectrum& sound,
                                                    double from, double to) {
  // steps of half a sample: with whole samples a peak near the Nyquist frequency could fall between two steps
  audio::RealFft twice(2 * filter.n_window());
  const std::vector<float> products = twice.inverse(audio::product_conj(filter.spectrum(), sound));
  const auto n = static_cast<std::int64_t>(products.size());
  const std::int64_t lowest = std::clamp<std::int64_t>(std::llround(2.0 * from), 2 - n / 2, n / 2 - 2);
  const std::int64_t highest = std::clamp<std::int64_t>(std::llround(2.0 * to), lowest, n / 2 - 2);
  std::vector<float> correlation(static_cast<std::size_t>(highest - lowest + 3), -INFINITY);  // and one on either side
  for (std::int64_t k = lowest; k <= highest; ++k)
    correlation[static_cast<std::size_t>(k - lowest + 1)] = products[static_cast<std::size_t>(k < 0 ? k + n : k)];
  const auto top = std::find(correlation.begin(), correlation.end(), audio::largest(correlation));
  const Peak best{top - correlation.begin() - 1 + lowest, *top};
  std::vector<Peak> peaks;  // the highest others, by falling height
  float least = 0.0F;       // that is of interest
  for (std::size_t k = 1; k + 1 < correlation.size(); ++k) {
    // no branches but one that is seldom taken: they would be mispredicted half of the time
    const int is_peak = static_cast<int>(correlation[k] > least) &
                        static_cast<int>(correlation[k] >= correlation[k - 1]) &
                        static_cast<int>(correlation[k] >= correlation[k + 1]);
    if (is_peak == 0) continue;
    const Peak here{static_cast<std::int64_t>(k) - 1 + lowest, correlation[k]};
    if (std::abs(here.at - best.at) <= 2) continue;
    peaks.insert(std::upper_bound(peaks.begin(), peaks.end(), here,
                                  [](const Peak& a, const Peak& b) { return a.height > b.height; }),
                 here);
    if (peaks.size() < kMaxPeaks) continue;
    peaks.pop_back();
    least = static_cast<float>(peaks.back().height);
  }
  // the inverse holds sums of products over sqrt(n_window)
  const double scale = 0.5 * static_cast<double>(filter.n_window()) / filter.energy();
  const auto to_peak = [&](const Peak& peak) {
    const double height = std::max(0.0, peak.height);
    return CorrelationPeak{0.5 * static_cast<double>(peak.at), scale * height * height};
  };
  std::vector<CorrelationPeak> found{to_peak(best)};
  for (const Peak& peak : peaks) found.push_back(to_peak(peak));
  return found;
}

}  // namespace bouncelab::detection
