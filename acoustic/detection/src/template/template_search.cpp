// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/template_search.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/ball.hpp"
#include "bouncelab/core/elementary.hpp"
#include "template/correlation_peaks.hpp"
#include "template/impact_whitener.hpp"
#include "template/template_model.hpp"

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

/// Of the first n bins.
double power_of(const audio::Spectrum& spectrum, std::size_t n_bins) {
  const auto re = std::span(spectrum.re).first(n_bins), im = std::span(spectrum.im).first(n_bins);
  return audio::dot(re, re) + audio::dot(im, im);
}

/// From the first sample of a window to where it should begin: what a codec lets sound before an attack, and the soft
/// beginning of a soft ball's, may be taken for the impact. The attack is where a fifth of the energy has come.
std::int64_t samples_to_attack(const TemplateEstimation& e, std::int64_t first) {
  std::vector<float> x(e.window.n_window);
  e.white.read(e.learned.whitener, first, x);
  const double enough = kTemplate.attack_share * audio::dot(x, x);
  double sum = 0.0;
  std::size_t n = 0;
  while (n + 1 < x.size() && sum < enough) sum += square(static_cast<double>(x[n++]));
  const std::int64_t late = static_cast<std::int64_t>(n) - e.window.samples(kTemplate.lead_s);
  return late > e.window.samples(kTemplate.rough_time_error_s) ? late : 0;
}

/// A sum of impacts over its weight, with tapered ends, 0 before and after the template.
/// @param mean  receives it as a function of time
audio::Spectrum tapered(const TemplateEstimation& e, const audio::Spectrum& sum, double weight,
                        std::vector<float>& mean) {
  mean = e.fourier.inverse(sum);
  const double scale = weight > 0.0 ? 1.0 / weight : 0.0;
  for (std::size_t n = 0; n < e.window.n_template; ++n) mean[n] *= static_cast<float>(scale * e.window.taper[n]);
  std::fill(mean.begin() + static_cast<std::ptrdiff_t>(e.window.n_template), mean.end(), 0.0F);
  return e.fourier.forward(mean);
}

void set_template(TemplateEstimation& e, audio::Spectrum spectrum) {
  e.n_bins = e.only_lower_half ? keep_lower_half(spectrum) : spectrum.size();
  e.learned.filter = MatchedFilter(std::move(spectrum), e.window.n_window);
  if (e.learned.subbands.n() == 0) e.learned.subbands = split_into_subbands(e.learned.filter);
}

/// The template that starts from one impact. Low frequencies are aligned by first: they have one maximum where high
/// ones have many, and a codec keeps their phases, but gives high ones phases of its own.
void start_from(TemplateEstimation& e, std::size_t start, bool at_attacks) {
  e.training.assign(e.begins.size(), {});
  for (std::size_t k = 0; k < e.begins.size(); ++k)
    cut_training_window(e, e.begins[k] + (at_attacks ? samples_to_attack(e, e.begins[k]) : 0), e.training[k]);
  e.learned.subbands = {};
  e.only_lower_half = true;
  set_template(e, tapered(e, e.training[start].spectrum, 1.0, e.mean));
  align(e, true);
  average(e);
  align(e, true);
  e.only_lower_half = false;
  e.learned.subbands = {};
  average(e);
  align(e, false);
}

std::ptrdiff_t n_alike(const std::vector<TrainingImpact>& training) {
  return std::count_if(training.begin(), training.end(),
                       [](const TrainingImpact& impact) { return impact.is_averaged(); });
}

/// A template and the impacts that it is the mean of.
struct Found {
  ImpactTemplate learned;
  std::vector<TrainingImpact> training;
  std::vector<float> mean;
};

Found state_of(const TemplateEstimation& e) { return {e.learned, e.training, e.mean}; }

void restore(TemplateEstimation& e, Found found) {
  e.learned = std::move(found.learned);
  e.training = std::move(found.training);
  e.mean = std::move(found.mean);
}

}  // namespace

void cut_training_window(TemplateEstimation& e, std::int64_t first, TrainingImpact& impact) {
  impact.first = first;
  impact.sound.resize(e.window.n_window);
  e.white.read(e.learned.whitener, first, impact.sound);
  e.fourier.forward(impact.sound, impact.spectrum);
  impact.total = audio::dot(impact.sound, impact.sound);
}

void average(TemplateEstimation& e) {
  const std::vector<float> none(e.window.n_window / 2 + 1, 0.0F);
  audio::Spectrum sums[2] = {{none, none}, {none, none}};  // of every other impact
  double weights[2] = {0.0, 0.0};
  std::size_t n_averaged = 0;
  audio::Spectrum moved{none, none};
  const double omega = 2.0 * kPi / static_cast<double>(e.window.n_window);
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    const double a = impact.estimate.amplitude;
    const std::size_t half = n_averaged++ % 2;
    audio::phase_shift(impact.spectrum, omega * impact.position, moved);
    audio::add_scaled(sums[half], moved, a);
    weights[half] += a * a;
  }
  audio::Spectrum sum = sums[0];
  audio::add_scaled(sum, sums[1], 1.0);
  audio::Spectrum spectrum = tapered(e, sum, weights[0] + weights[1], e.mean);
  if (n_averaged >= kTemplate.fewest_for_coherence) {
    const std::vector<float> weight = coherence_weight(sums[0], weights[0], sums[1], weights[1]);
    for (std::size_t k = 0; k < spectrum.size(); ++k) {
      spectrum.re[k] *= weight[k];
      spectrum.im[k] *= weight[k];
    }
  }
  set_template(e, std::move(spectrum));
}

void align(TemplateEstimation& e, bool search) {
  const double reach = kTemplate.rough_time_error_s * e.white.source().rate_hz;
  for (TrainingImpact& impact : e.training) {
    if (!(e.learned.filter.energy() > 0.0)) {
      impact.correlation = 0.0;
      continue;
    }
    if (search) impact.position = Correlation(e.learned.filter, impact.spectrum, -reach, reach).highest().shift;
    if (std::abs(impact.position) > kTemplate.recut_samples) {
      const std::int64_t moved = std::llround(impact.position);
      cut_training_window(e, impact.first + moved, impact);
      impact.position -= static_cast<double>(moved);
    }
    impact.estimate = estimate_delay(e.learned.filter, e.learned.subbands, impact.spectrum, impact.position);
    impact.position = impact.estimate.shift;
    impact.estimate.amplitude = std::max(impact.estimate.amplitude, 1e-6);
    impact.correlation = correlation(impact.estimate, power_of(impact.spectrum, e.n_bins));
  }
}

std::vector<float> residual_of(TemplateEstimation& e, const TrainingImpact& impact) {
  const MatchedFilter& filter = e.learned.filter;
  const std::vector<float> placed =
      e.fourier.inverse(audio::phase_shifted(filter.spectrum(), -filter.omega() * impact.position));
  std::vector<float> x = impact.sound;
  for (std::size_t n = 0; n < e.window.n_window; ++n) x[n] -= static_cast<float>(impact.estimate.amplitude) * placed[n];
  return x;
}

void find_template(TemplateEstimation& e) {
  Found best;
  for (const bool at_attacks : {false, true})
    for (std::size_t start = 0; start < std::min(kTemplate.most_starts, e.begins.size()); ++start) {
      start_from(e, start, at_attacks);
      if (best.training.empty() || n_alike(e.training) > n_alike(best.training)) best = state_of(e);
      if (4 * n_alike(best.training) >= 3 * std::ssize(best.training)) return restore(e, std::move(best));
    }
  restore(e, std::move(best));
}

void whiten_by_noise(TemplateEstimation& e, const ArModel& noise) {
  if (!(noise.quiet_variance > 0.0)) return;
  Found before = state_of(e);
  e.learned.whitener = impact_whitener(e.white.source(), noise, e.begins, e.window.n_window, 0.0);
  for (TrainingImpact& impact : e.training) cut_training_window(e, impact.first, impact);
  e.learned.subbands = {};
  average(e);
  align(e, false);
  if (n_alike(e.training) < n_alike(before.training)) restore(e, std::move(before));
}

}  // namespace bouncelab::detection
