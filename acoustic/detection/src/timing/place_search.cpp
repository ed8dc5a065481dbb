// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/place_search.hpp"

#include <algorithm>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "timing/correlation_peaks.hpp"

namespace bouncelab::detection {
namespace {

/// The template at `begin` in a window of twice its length.
MatchedFilter in_longer_window(const ImpactTemplate& learned, std::int64_t begin, audio::RealFft& fourier) {
  const std::vector<float> placed = audio::RealFft(learned.filter.n_window()).inverse(learned.filter.spectrum());
  std::vector<float> x(fourier.size(), 0.0F);
  std::copy_n(placed.begin(), learned.n_template, x.begin() + begin);
  return {fourier.forward(x), fourier.size()};
}

/// The likelihood of an impact at a quarter of a sample from a step of the correlation, over that at the step: the
/// template's correlation with itself there, squared.
double share_at_quarter(const MatchedFilter& filter) {
  constexpr double kFarthest = 0.25;  // samples
  double sum = 0.0;
  for (std::size_t k = 0; k < filter.n_filled(); ++k)
    sum += filter.energy(k, k + 1) * cos(kFarthest * filter.omega() * static_cast<double>(k));
  return square(sum / (filter.energy() + 1e-30));
}

}  // namespace

PlaceSearch::PlaceSearch(const ImpactTemplate& learned)
    : learned_(learned),
      fourier_(2 * learned.filter.n_window()),
      begin_(static_cast<std::int64_t>(learned.filter.n_window() - learned.n_template / 2 - 2)),
      filter_(in_longer_window(learned, begin_, fourier_)),
      between_steps_(1.0 / share_at_quarter(filter_)) {}

std::vector<PossiblePlace> PlaceSearch::find(Ringing& known, double rate_hz, std::int64_t first, std::int64_t n_lags,
                                             double least) {
  const auto n_template = static_cast<std::int64_t>(learned_.n_template);
  const std::int64_t n_most = static_cast<std::int64_t>(fourier_.size()) - n_template;  // lags of a block
  std::vector<PossiblePlace> places;
  std::vector<float> x;
  audio::Spectrum spectrum;
  for (std::int64_t at = 0; at < n_lags; at += n_most) {
    const std::int64_t n = std::min(n_most, n_lags - at);
    x.resize(static_cast<std::size_t>(n + n_template - 1));
    known.stretch_without(first + at, x);
    if (0.5 * audio::dot(x, x) <= least) continue;
    fourier_.forward(x, spectrum);
    const Correlation products(filter_, spectrum, static_cast<double>(-begin_), static_cast<double>(n - 1 - begin_));
    for (const CorrelationPeak& peak : products.peaks()) {
      const double most = between_steps_ * peak.log_likelihood_ratio;
      const double begin = static_cast<double>(first + at + begin_) + peak.shift;
      if (most > least) places.push_back({(begin + learned_.contact_index) / rate_hz, most});
    }
  }
  return places;
}

}  // namespace bouncelab::detection
