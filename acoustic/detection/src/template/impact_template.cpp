// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_template.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "template/impact_whitener.hpp"
#include "template/subband_errors.hpp"
#include "template/template_model.hpp"
#include "template/template_search.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMaxShown = 12;  // impacts that the wave is the mean of

/// Extends the whitener by a filter that also whitens what the template does not explain: noise where that is all, the
/// ringing of modes that are excited differently each time where the noise is less than their variation. The template
/// anew, from the windows as they lie.
void whiten_residuals(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> r(kTemplate.residual_order + 1, 0.0);
  for (const TrainingImpact& impact : e.training) {
    const std::vector<float> x = residual_of(e, impact);
    const double energy = audio::dot(x, x) + 1e-30;
    for (std::size_t lag = 0; lag <= kTemplate.residual_order; ++lag)
      r[lag] += audio::dot(x, std::span(x).subspan(lag)) / energy;
  }
  const std::vector<double> a = prediction_error_filter(r);
  std::vector<float> both(learned.whitener.size() + kTemplate.residual_order, 0.0F);
  for (std::size_t j = 0; j < learned.whitener.size(); ++j)
    for (std::size_t k = 0; k <= kTemplate.residual_order; ++k)
      both[j + k] += learned.whitener[j] * static_cast<float>(a[k]);
  learned.whitener = std::move(both);
  for (TrainingImpact& impact : e.training) cut_training_window(e, impact.first, impact);
  average(e);
  align(e, true);  // the new whitener may have resolved what was ambiguous
  average(e);
}

void estimate_subbands(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  learned.subbands = split_into_subbands(learned.filter);
  const double quiet = estimate_noise(e);
  for (int round = 0; round < 2; ++round) {
    align(e, false);
    std::vector<DelayEstimate> estimates;
    for (const TrainingImpact& impact : e.training)
      if (impact.is_averaged()) estimates.push_back(impact.estimate);
    estimate_jitter(estimates, learned.filter, learned.subbands);
    if (learned.subbands.n() < kTemplate.fewest_subbands) add_unexplained_jitter(e, quiet);
    average(e);
  }
}

/// Start of contact in the window: the first sample above a tenth of the peak.
double onset_index(const std::vector<float>& mean) {
  float peak = 0.0F;
  for (const float x : mean) peak = std::max(peak, std::abs(x));
  const auto first =
      std::find_if(mean.begin(), mean.end(), [&](float x) { return std::abs(x) > kTemplate.onset_of_peak * peak; });
  return static_cast<double>(first - mean.begin());
}

double effective_samples(const std::vector<float>& wave) {
  double squares = 1e-30, fourth_powers = 1e-30;
  for (const float x : wave) {
    const double x2 = square(static_cast<double>(x));
    squares += x2;
    fourth_powers += x2 * x2;
  }
  return std::min(3.0 * squares * squares / fourth_powers, static_cast<double>(wave.size()));
}

void describe_training(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> correlations;
  for (const TrainingImpact& impact : e.training) correlations.push_back(impact.correlation);
  learned.correlation = upper_median(std::move(correlations));
  learned.contact_index = onset_index(e.mean);
  learned.n_effective = effective_samples(e.mean);
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    const double begin = static_cast<double>(impact.first) + impact.estimate.shift + learned.contact_index;
    learned.training_t_s.push_back(begin / e.white->source().rate_hz);
    learned.training_weight += impact.estimate.amplitude * impact.estimate.amplitude;
  }
}

/// Mean of the training impacts as recorded, and its spread.
void describe_waveform(TemplateEstimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> sum(learned.n_template, 0.0);
  std::vector<double> squares(learned.n_template, 0.0);
  std::vector<float> x(e.fourier.size());
  std::size_t n_shown = 0;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged() || n_shown == kMaxShown) continue;
    audio::read_padded(e.white->source(), impact.first, x);
    const std::vector<float> y =
        e.fourier.inverse(audio::phase_shifted(e.fourier.forward(x), learned.filter.omega() * impact.estimate.shift));
    const double factor = 1.0 / impact.estimate.amplitude;
    for (std::size_t k = 0; k < learned.n_template; ++k) {
      const double value = factor * static_cast<double>(y[k]);
      sum[k] += value;
      squares[k] += value * value;
    }
    ++n_shown;
  }
  const double rate_hz = e.white->source().rate_hz;
  LearnedWave& wave = learned.wave;
  wave.t0_s = -learned.contact_index / rate_hz;
  wave.dt_s = 1.0 / rate_hz;
  wave.n_impacts = std::ssize(learned.training_t_s);
  const auto n = static_cast<double>(n_shown);
  for (std::size_t k = 0; k < learned.n_template; ++k) {
    wave.mean.push_back(sum[k] / n);
    wave.spread.push_back(std::sqrt(std::max(0.0, squares[k] / n - square(wave.mean[k]))));
    learned.peak = std::max(learned.peak, std::abs(wave.mean[k]));
  }
}

}  // namespace

std::optional<ImpactTemplate> estimate_template(WhiteSound& white, const ArModel& noise,
                                                const std::vector<Candidate>& impacts,
                                                const std::vector<bool>& clipped) {
  if (impacts.size() < 3) return std::nullopt;
  TemplateEstimation e = begin_estimation(white, impacts, clipped);
  e.learned.whitener = impact_whitener(white.source(), noise, e.begins, e.fourier.size(), kTemplate.unrepeated);
  find_template(e);
  whiten_by_noise(e, noise);
  whiten_residuals(e);
  estimate_subbands(e);
  describe_training(e);
  if (e.learned.training_t_s.size() < 3) return std::nullopt;
  describe_waveform(e);
  return std::move(e.learned);
}

double correlation(const DelayEstimate& estimate, double total) {
  return std::sqrt(std::min(1.0, 2.0 * estimate.log_likelihood_ratio / (total + 1e-30)));
}

double recorded_rms_frequency(const ImpactTemplate& learned) {
  const std::size_t n_window = learned.filter.n_window();
  // long enough for the whitener also at low rates
  const std::size_t n = std::max(n_window, std::bit_ceil(learned.whitener.size()));
  const audio::Spectrum response = audio::RealFft(n).forward(learned.whitener);
  double power = 0.0, squares = 0.0;
  for (std::size_t k = 1; k < learned.filter.spectrum().size(); ++k) {
    const double gain2 = audio::bin_power(response, k * (n / n_window));
    const double recorded = learned.filter.energy(k, k + 1) / (gain2 + 1e-30);
    power += recorded;
    squares += recorded * square(static_cast<double>(k));
  }
  return std::max(1e-6, std::sqrt(squares / (power + 1e-300)) / static_cast<double>(n_window));
}

}  // namespace bouncelab::detection
