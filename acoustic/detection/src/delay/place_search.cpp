// SPDX-License-Identifier: GPL-3.0-or-later
#include "delay/place_search.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "template/correlation_peaks.hpp"

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
  const audio::Spectrum phasor = audio::phase_ramp(filter.n_filled(), kFarthest * filter.omega());
  double sum = 0.0;
  for (std::size_t k = 0; k < filter.n_filled(); ++k) sum += filter.energy(k, k + 1) * phasor.re[k];
  return square(sum / (filter.energy() + 1e-30));
}

/// The template's correlation with itself half a sample later, or where it is largest from one, one and a half ... on.
std::vector<float> alike_later(const MatchedFilter& filter, double between_steps) {
  audio::RealFft twice(2 * filter.n_window());
  const std::vector<float> products = twice.inverse(audio::product_conj(filter.spectrum(), filter.spectrum()));
  std::vector<float> alike(products.begin(), products.begin() + static_cast<std::ptrdiff_t>(filter.n_window()));
  const double scale = std::sqrt(between_steps) / std::max(1e-30F, alike.front());
  float largest = 0.0F;
  for (std::size_t k = alike.size(); k-- > 0;) {
    largest = std::max(largest, alike[k]);
    alike[k] = static_cast<float>(std::min(1.0, scale * largest));
  }
  return alike;
}

}  // namespace

PlaceSearch::PlaceSearch(const ImpactTemplate& learned)
    : learned_(learned),
      fourier_(2 * learned.filter.n_window()),
      begin_(static_cast<std::int64_t>(learned.filter.n_window() - learned.n_template / 2 - 2)),
      filter_(in_longer_window(learned, begin_, fourier_)),
      between_steps_(1.0 / share_at_quarter(filter_)),
      alike_(alike_later(filter_, between_steps_)) {}

double PlaceSearch::most_beside(const ImpactBeside& beside, double energy) const {
  const auto later = static_cast<std::size_t>(std::max(0.0, 2.0 * beside.apart));
  const double alike = alike_[std::min(later, alike_.size() - 1)];
  const double explained = 2.0 * beside.log_likelihood_ratio;
  return 0.5 * square(alike * std::sqrt(explained) + std::sqrt(std::max(0.0, energy - explained)));
}

std::vector<PossiblePlace> PlaceSearch::find(Ringing& known, double rate_hz, std::int64_t first, std::int64_t n_lags,
                                             double least, const ImpactBeside& beside) {
  const auto n_template = static_cast<std::int64_t>(learned_.n_template);
  const std::int64_t n_most = static_cast<std::int64_t>(fourier_.size()) - n_template;  // lags of a block
  std::vector<PossiblePlace> places;
  std::vector<float> stretch(static_cast<std::size_t>(n_lags + n_template - 1));
  known.stretch_without(first, stretch);
  if (most_beside(beside, audio::dot(stretch, stretch)) <= least) return places;
  audio::Spectrum spectrum;
  for (std::int64_t at = 0; at < n_lags; at += n_most) {
    const std::int64_t n = std::min(n_most, n_lags - at);
    const auto x = std::span<const float>(stretch).subspan(static_cast<std::size_t>(at),
                                                           static_cast<std::size_t>(n + n_template - 1));
    if (0.5 * audio::dot(x, x) <= least) continue;
    fourier_.forward(x, spectrum);
    const Correlation products(filter_, spectrum, static_cast<double>(-begin_), static_cast<double>(n - 1 - begin_));
    for (const CorrelationPeak& peak : products.peaks(least / between_steps_)) {
      const double most = between_steps_ * peak.log_likelihood_ratio;
      const double begin = static_cast<double>(first + at + begin_) + peak.shift;
      if (most > least) places.push_back({(begin + learned_.contact_index) / rate_hz, most});
    }
  }
  return places;
}

}  // namespace bouncelab::detection
