// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/template_alignment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/vector_clones.hpp"
#include "timing/correlation_peaks.hpp"

namespace bouncelab::detection {
namespace {

/// Leaves the lower frequencies, which hold half of the energy.
/// @return the first bin left out
std::size_t keep_lower_half(audio::Spectrum& spectrum) {
  const double half = 0.5 * audio::energy(spectrum);
  double sum = 0.0;
  std::size_t n_kept = 0;
  while (n_kept < spectrum.size() && sum <= half) sum += audio::bin_power(spectrum, n_kept++);
  std::fill(spectrum.re.begin() + static_cast<std::ptrdiff_t>(n_kept), spectrum.re.end(), 0.0F);
  std::fill(spectrum.im.begin() + static_cast<std::ptrdiff_t>(n_kept), spectrum.im.end(), 0.0F);
  return n_kept;
}

/// Of the first n bins; eight partial sums side by side, in an order that is the same on every processor.
BOUNCELAB_VECTOR_CLONES double sum_of_squares(const float* x, std::size_t n) {
  constexpr std::size_t kSums = 8;
  std::array<double, kSums> sums{};
  std::size_t k = 0;
  for (; k + kSums <= n; k += kSums)
    for (std::size_t lane = 0; lane < kSums; ++lane) {
      const auto value = static_cast<double>(x[k + lane]);
      sums[lane] += value * value;
    }
  for (; k < n; ++k) sums[0] += static_cast<double>(x[k]) * x[k];
  return ((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]));
}

double power_of(const audio::Spectrum& spectrum, std::size_t n_bins) {
  return sum_of_squares(spectrum.re.data(), n_bins) + sum_of_squares(spectrum.im.data(), n_bins);
}

}  // namespace

void cut_training_window(TemplateEstimation& e, std::int64_t first, TrainingImpact& impact) {
  cut_window(e.white, e.learned.whitener, first, e.fourier, e.window.n_window, impact);
  impact.power = power_of(impact.spectrum, impact.spectrum.size());
}

void set_template(TemplateEstimation& e, TemplateAverage average) {
  e.mean = std::move(average.mean);
  e.n_bins = e.only_lower_half ? keep_lower_half(average.spectrum) : average.spectrum.size();
  e.learned.filter = MatchedFilter(std::move(average.spectrum), e.window.n_window);
  if (e.learned.subbands.n() == 0) e.learned.subbands = split_into_subbands(e.learned.filter);
}

void average(TemplateEstimation& e) { set_template(e, average_of(e.training, e.window, e.fourier)); }

void align(TemplateEstimation& e, bool search) {
  const double reach = kRoughTimeError_s * e.white.source().rate_hz;
  for (TrainingImpact& impact : e.training) {
    if (!(e.learned.filter.energy() > 0.0)) {
      impact.correlation = 0.0;
      continue;
    }
    if (search) impact.position = Correlation(e.learned.filter, impact.spectrum, -reach, reach).highest().shift;
    if (std::abs(impact.position) > kRecutDistance_samples) {
      const std::int64_t moved = std::llround(impact.position);
      cut_training_window(e, impact.window.first + moved, impact);
      impact.position -= static_cast<double>(moved);
    }
    impact.estimate = estimate_delay(e.learned.filter, e.learned.subbands, impact.spectrum, impact.position);
    impact.position = impact.estimate.shift;
    impact.estimate.amplitude = std::max(impact.estimate.amplitude, 1e-6);
    const bool is_whole = e.n_bins == impact.spectrum.size();
    impact.correlation = correlation(impact.estimate, is_whole ? impact.power : power_of(impact.spectrum, e.n_bins));
  }
}

void align_and_average(TemplateEstimation& e, int n_searched, int n_rounds) {
  for (int round = 0; round < n_rounds; ++round) {
    align(e, round < n_searched);
    average(e);
  }
}

void let_others_join(TemplateEstimation& e) {
  for (; e.n_used < e.begins.size(); ++e.n_used) cut_training_window(e, e.begins[e.n_used], e.training.emplace_back());
}

std::vector<float> residual_of(TemplateEstimation& e, const TrainingImpact& impact) {
  const MatchedFilter& filter = e.learned.filter;
  const std::vector<float> placed =
      e.fourier.inverse(audio::phase_shifted(filter.spectrum(), -filter.omega() * impact.position));
  std::vector<float> x = impact.window.sound;
  for (std::size_t n = 0; n < e.window.n_window; ++n) x[n] -= static_cast<float>(impact.estimate.amplitude) * placed[n];
  return x;
}

}  // namespace bouncelab::detection
