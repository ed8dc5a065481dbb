// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/template_search.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
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

std::vector<TrainingImpact> cut_training(TemplateEstimation& e, bool at_attacks) {
  std::vector<TrainingImpact> training(e.begins.size());
  for (std::size_t k = 0; k < training.size(); ++k)
    cut_training_window(e, e.begins[k] + (at_attacks ? samples_to_attack(e, e.begins[k]) : 0), training[k]);
  return training;
}

/// The template that starts from one impact. Low frequencies are aligned by first: they have one maximum where high
/// ones have many, and a codec keeps their phases, but gives high ones phases of its own.
void start_from(TemplateEstimation& e, std::size_t start) {
  e.learned.subbands = {};
  e.only_lower_half = true;
  set_template(e, tapered(e.training[start].spectrum, 1.0, e.window, e.fourier));
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

  std::ptrdiff_t n_alike() const { return detection::n_alike(training); }
  bool is_enough() const { return 4 * n_alike() >= 3 * std::ssize(training); }
};

Found state_of(const TemplateEstimation& e) { return {e.learned, e.training, e.mean}; }

void restore(TemplateEstimation& e, Found found) {
  e.learned = std::move(found.learned);
  e.training = std::move(found.training);
  e.mean = std::move(found.mean);
}

/// The template of the strongest impact that three quarters of the others correlate with. The very strongest may hold a
/// knock, or be of another source altogether.
/// @return where there is none, that which most correlate with
Found find_template(TemplateEstimation& e, bool at_attacks) {
  Found best;
  for (std::size_t start = 0; start < std::min(kTemplate.most_starts, e.begins.size()); ++start) {
    e.training = cut_training(e, at_attacks);
    start_from(e, start);
    Found found = state_of(e);
    if (start == 0 || found.n_alike() > best.n_alike()) best = std::move(found);
    if (best.is_enough()) break;
  }
  return best;
}

}  // namespace

void cut_training_window(TemplateEstimation& e, std::int64_t first, TrainingImpact& impact) {
  impact.window.first = first;
  impact.window.sound.resize(e.window.n_window);
  e.white.read(e.learned.whitener, first, impact.window.sound);
  e.fourier.forward(impact.window.sound, impact.spectrum);
  impact.total = audio::dot(impact.window.sound, impact.window.sound);
}

void set_template(TemplateEstimation& e, TemplateAverage average) {
  e.mean = std::move(average.mean);
  e.n_bins = e.only_lower_half ? keep_lower_half(average.spectrum) : average.spectrum.size();
  e.learned.filter = MatchedFilter(std::move(average.spectrum), e.window.n_window);
  if (e.learned.subbands.n() == 0) e.learned.subbands = split_into_subbands(e.learned.filter);
}

void average(TemplateEstimation& e) { set_template(e, average_of(e.training, e.window, e.fourier)); }

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
      cut_training_window(e, impact.window.first + moved, impact);
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
  std::vector<float> x = impact.window.sound;
  for (std::size_t n = 0; n < e.window.n_window; ++n) x[n] -= static_cast<float>(impact.estimate.amplitude) * placed[n];
  return x;
}

void find_template(TemplateEstimation& e) {
  Found best = find_template(e, false);
  if (!best.is_enough())
    if (Found found = find_template(e, true); found.n_alike() > best.n_alike()) best = std::move(found);
  restore(e, std::move(best));
}

void whiten_by_noise(TemplateEstimation& e, const ArModel& noise) {
  if (!(noise.quiet_variance > 0.0)) return;
  Found before = state_of(e);
  e.learned.whitener = impact_whitener(e.white.source(), noise, e.begins, e.window.n_window, 0.0);
  for (TrainingImpact& impact : e.training) cut_training_window(e, impact.window.first, impact);
  e.learned.subbands = {};
  average(e);
  align(e, false);
  if (n_alike(e.training) < before.n_alike()) restore(e, std::move(before));
}

}  // namespace bouncelab::detection
