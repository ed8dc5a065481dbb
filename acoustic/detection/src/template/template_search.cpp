// SPDX-License-Identifier: GPL-3.0-or-later
#include "template/impact_template.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp.hpp"
#include "bouncelab/core/elementary.hpp"
#include "bouncelab/core/numerics.hpp"
#include "template/subband_delay.hpp"

namespace bouncelab::detection {
namespace {

/// Power of the noise in each bin of a spectrum, per real and imaginary part; 0 in digital silence.
std::vector<double> noise_power(const ArModel& noise, audio::RealFft& fourier) {
  const audio::Spectrum filter = fourier.forward(noise.filter);
  const double to_gain = 0.5 * static_cast<double>(fourier.size());  // the transform is scaled by sqrt(2/n)
  std::vector<double> power(filter.size(), 0.0);
  for (std::size_t k = 1; k + 1 < power.size(); ++k)
    power[k] = noise.quiet_variance / std::max(to_gain * audio::bin_power(filter, k), 1e-12);
  return power;
}

/// Power of the impacts as recorded: the mean of their spectra's shapes at the median of their energies.
std::vector<double> impact_power(const audio::AudioSource& sound, const std::vector<std::int64_t>& begins,
                                 std::size_t n_window, audio::RealFft& fourier) {
  std::vector<double> power(fourier.size() / 2 + 1, 0.0);
  std::vector<double> energies;
  std::vector<float> x(n_window);
  for (const std::int64_t first : begins) {
    audio::read_padded(sound, first, x);
    const audio::Spectrum spectrum = fourier.forward(x);
    energies.push_back(audio::energy(spectrum));
    if (!(energies.back() > 0.0)) continue;
    for (std::size_t k = 0; k < power.size(); ++k) power[k] += audio::bin_power(spectrum, k) / energies.back();
  }
  const double scale = 0.5 * upper_median(std::move(energies)) / static_cast<double>(begins.size());
  for (double& p : power) p *= scale;
  return power;
}

/// cos(2 pi k / n), k = 0 ... n - 1; n a power of two, at least 4.
std::vector<double> cosines(std::size_t n) {
  std::vector<double> cosine(n);
  for (std::size_t k = 0; k <= n / 4; ++k) {
    const double x = cos(2.0 * kPi * static_cast<double>(k) / static_cast<double>(n));
    cosine[k] = cosine[(n - k) % n] = x;
    cosine[n / 2 - k] = cosine[n / 2 + k] = -x;
  }
  return cosine;
}

/// Prediction error filter for a power spectrum, scaled to leave variance 1. Of the differenced sound, as the noise was
/// modelled: the spectrum spans less then.
std::vector<float> whitener_for(const std::vector<double>& power, std::size_t n_order) {
  const std::size_t n = 2 * (power.size() - 1);
  const std::vector<double> cosine = cosines(n);
  std::vector<double> r(n_order + 1, 0.0);
  for (std::size_t k = 1; k < power.size(); ++k) {
    const double differenced = power[k] * 2.0 * (1.0 - cosine[k]);
    std::size_t phase = 0;  // k lag, modulo n
    for (double& at_lag : r) {
      at_lag += differenced * cosine[phase];
      phase += k;
      if (phase >= n) phase -= n;
    }
  }
  const std::vector<double> a = prediction_error_filter(r);
  double variance = 0.0;  // that the filter leaves, times the number of bins
  for (std::size_t lag = 0; lag <= n_order; ++lag) variance += a[lag] * r[lag];
  const double scale = variance > 0.0 ? std::sqrt(static_cast<double>(power.size() - 1) / variance) : 0.0;
  std::vector<float> filter(n_order + 2);
  for (std::size_t k = 0; k < filter.size(); ++k)
    filter[k] = static_cast<float>(scale * ((k <= n_order ? a[k] : 0.0) - (k > 0 ? a[k - 1] : 0.0)));
  return filter;
}

}  // namespace

std::vector<float> impact_whitener(const audio::AudioSource& sound, const ArModel& noise,
                                   const std::vector<std::int64_t>& begins, std::size_t n_window, double unrepeated) {
  // long enough for the noise's filter also at low rates
  audio::RealFft fourier(std::max(n_window, std::bit_ceil(noise.filter.size())));
  std::vector<double> power = noise_power(noise, fourier);
  const std::vector<double> impacts = impact_power(sound, begins, n_window, fourier);
  const double mean = std::accumulate(impacts.begin(), impacts.end(), 0.0) / static_cast<double>(impacts.size());
  for (std::size_t k = 0; k < power.size(); ++k) power[k] += unrepeated * impacts[k] + kTemplate.floor * mean;
  return whitener_for(power, noise.filter.size() - 2);
}

namespace {

/// Template of 15 ms, which hold more than nine tenths of the information of a plate's sound on its time; of 40 ms
/// where impacts follow so closely that what rings after 15 ms masks the next ones.
double template_length_s(const std::vector<Candidate>& impacts) {
  std::size_t n_close = 0;
  std::size_t n_far = 0;
  for (std::size_t k = 0; k + 1 < impacts.size(); ++k) {
    n_close += impacts[k + 1].t_s - impacts[k].t_s < kTemplate.close_s ? 1 : 0;
    n_far += impacts[k + 1].t_s - impacts[k].t_s > 2.0 * kTemplate.long_s ? 1 : 0;
  }
  return n_close >= kTemplate.many_close && n_far >= kTemplate.many_far ? kTemplate.long_s : kTemplate.short_s;
}

/// Factors of the template's samples: both ends fall to 0.
std::vector<double> taper_of(const TemplateEstimation& e) {
  const auto fall = static_cast<std::size_t>(e.samples(kTemplate.taper_s));
  const auto rise = static_cast<std::size_t>(e.samples(0.25 * kTemplate.lead_s)) + 1;
  const auto part_of_sine = [](std::size_t n, std::size_t of) {
    return square(sin(0.5 * kPi * static_cast<double>(n) / static_cast<double>(of)));
  };
  std::vector<double> taper(e.learned.n_template, 1.0);
  for (std::size_t n = 0; n < std::min(rise, taper.size()); ++n) taper[n] *= part_of_sine(n, rise);
  for (std::size_t left = 1; left < fall && left <= taper.size(); ++left)
    taper[taper.size() - left] *= part_of_sine(left, fall);
  return taper;
}

/// At most 32 of the impacts, the strongest first; unclipped ones where there are five.
std::vector<std::size_t> choose_training_impacts(const std::vector<Candidate>& impacts,
                                                 const std::vector<bool>& clipped) {
  std::vector<std::size_t> chosen(impacts.size());
  std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  std::vector<std::size_t> unclipped = chosen;
  std::erase_if(unclipped, [&](std::size_t k) { return clipped[k]; });
  if (std::ssize(unclipped) >= kTemplate.fewest_unclipped) chosen = unclipped;
  const auto stronger = [&](std::size_t a, std::size_t b) { return impacts[a].amplitude > impacts[b].amplitude; };
  if (chosen.size() > kTemplate.most_training) {
    std::nth_element(chosen.begin(), chosen.begin() + kTemplate.most_training, chosen.end(), stronger);
    chosen.resize(kTemplate.most_training);
  }
  std::sort(chosen.begin(), chosen.end(), stronger);
  return chosen;
}

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

/// A sum of impacts over its weight, with tapered ends, 0 before and after the template.
audio::Spectrum tapered(TemplateEstimation& e, const audio::Spectrum& sum, double weight) {
  e.mean = e.fourier.inverse(sum);
  const double scale = weight > 0.0 ? 1.0 / weight : 0.0;
  for (std::size_t n = 0; n < e.learned.n_template; ++n) e.mean[n] *= static_cast<float>(scale * e.taper[n]);
  std::fill(e.mean.begin() + static_cast<std::ptrdiff_t>(e.learned.n_template), e.mean.end(), 0.0F);
  return e.fourier.forward(e.mean);
}

void set_template(TemplateEstimation& e, audio::Spectrum spectrum) {
  e.n_bins = e.only_lower_half ? keep_lower_half(spectrum) : spectrum.size();
  e.learned.filter = MatchedFilter(std::move(spectrum), e.fourier.size());
  if (e.learned.subbands.n() == 0) e.learned.subbands = split_into_subbands(e.learned.filter);
}

/// The template that starts from one impact. Low frequencies are aligned by first: they have one maximum where high
/// ones have many, and a codec keeps their phases, but gives high ones phases of its own.
void start_from(TemplateEstimation& e, std::size_t start) {
  e.training.assign(e.begins.size(), {});
  for (std::size_t k = 0; k < e.begins.size(); ++k) cut_training_window(e, e.begins[k], e.training[k]);
  e.learned.subbands = {};
  e.only_lower_half = true;
  set_template(e, tapered(e, e.training[start].spectrum, 1.0));
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

}  // namespace

TemplateEstimation begin_estimation(WhiteSound& white, const std::vector<Candidate>& impacts,
                                    const std::vector<bool>& clipped) {
  const double length_s = template_length_s(impacts);
  const auto samples = [&](double duration_s) {
    return static_cast<std::size_t>(std::llround(duration_s * white.source().rate_hz));
  };
  const std::size_t n_window = std::bit_ceil(samples(kTemplate.lead_s + length_s + 2.0 * kTemplate.rough_time_error_s));
  TemplateEstimation e{&white, audio::RealFft(n_window)};
  e.learned.n_template = std::min(n_window, samples(kTemplate.lead_s + length_s));
  e.taper = taper_of(e);
  for (const std::size_t k : choose_training_impacts(impacts, clipped))
    e.begins.push_back(e.samples(impacts[k].t_s - kTemplate.lead_s));
  return e;
}

void cut_training_window(TemplateEstimation& e, std::int64_t first, TrainingImpact& impact) {
  impact.first = first;
  impact.sound.resize(e.fourier.size());
  e.white->read(e.learned.whitener, first, impact.sound);
  impact.spectrum = e.fourier.forward(impact.sound);
}

void average(TemplateEstimation& e) {
  const std::vector<float> none(e.fourier.size() / 2 + 1, 0.0F);
  audio::Spectrum sums[2] = {{none, none}, {none, none}};  // of every other impact
  double weights[2] = {0.0, 0.0};
  std::size_t n_averaged = 0;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    const double a = impact.estimate.amplitude;
    const std::size_t half = n_averaged++ % 2;
    audio::add_scaled(sums[half],
                      audio::phase_shifted(impact.spectrum, e.learned.filter.omega() * impact.estimate.shift), a);
    weights[half] += a * a;
  }
  audio::Spectrum sum = sums[0];
  audio::add_scaled(sum, sums[1], 1.0);
  audio::Spectrum spectrum = tapered(e, sum, weights[0] + weights[1]);
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
  const double reach = kTemplate.rough_time_error_s * e.white->source().rate_hz;
  for (TrainingImpact& impact : e.training) {
    if (!(e.learned.filter.energy() > 0.0)) {
      impact.correlation = 0.0;
      continue;
    }
    double& shift = impact.estimate.shift;
    if (search) shift = Correlation(e.learned.filter, impact.spectrum, -reach, reach).highest().shift;
    if (std::abs(shift) > kTemplate.recut_samples) {
      const std::int64_t moved = std::llround(shift);
      cut_training_window(e, impact.first + moved, impact);
      shift -= static_cast<double>(moved);
    }
    impact.estimate = estimate_delay(e.learned.filter, e.learned.subbands, impact.spectrum, shift);
    impact.estimate.amplitude = std::max(impact.estimate.amplitude, 1e-6);
    impact.correlation = correlation(impact.estimate, power_of(impact.spectrum, e.n_bins));
  }
}

std::vector<float> residual_of(TemplateEstimation& e, const TrainingImpact& impact) {
  const MatchedFilter& filter = e.learned.filter;
  const std::vector<float> placed =
      e.fourier.inverse(audio::phase_shifted(filter.spectrum(), -filter.omega() * impact.estimate.shift));
  std::vector<float> x(e.learned.n_template);
  for (std::size_t n = 0; n < x.size(); ++n)
    x[n] = static_cast<float>(e.taper[n] * impact.sound[n] - impact.estimate.amplitude * placed[n]);
  return x;
}

void find_template(TemplateEstimation& e) {
  TemplateEstimation best = e;
  for (std::size_t start = 0; start < std::min(kTemplate.most_starts, e.begins.size()); ++start) {
    start_from(e, start);
    if (best.training.empty() || n_alike(e.training) > n_alike(best.training)) best = e;
    if (4 * n_alike(best.training) >= 3 * std::ssize(best.training)) break;
  }
  e = std::move(best);
}

void whiten_by_noise(TemplateEstimation& e, const ArModel& noise) {
  if (!(noise.quiet_variance > 0.0)) return;
  const TemplateEstimation before = e;
  e.learned.whitener = impact_whitener(e.white->source(), noise, e.begins, e.fourier.size(), 0.0);
  for (TrainingImpact& impact : e.training) cut_training_window(e, impact.first, impact);
  e.learned.subbands = {};
  average(e);
  align(e, false);
  if (n_alike(e.training) < n_alike(before.training)) e = before;
}

std::vector<float> coherence_weight(const audio::Spectrum& a, double weight_a, const audio::Spectrum& b,
                                    double weight_b) {
  const std::size_t n = a.size();
  std::vector<double> common(n + 1, 0.0), all(n + 1, 0.0);  // running sums
  const double weight = weight_a + weight_b;
  for (std::size_t k = 0; k < n; ++k) {
    const double re = static_cast<double>(a.re[k]) + b.re[k];
    const double im = static_cast<double>(a.im[k]) + b.im[k];
    const double product = static_cast<double>(a.re[k]) * b.re[k] + static_cast<double>(a.im[k]) * b.im[k];
    common[k + 1] = common[k] + product / (weight_a * weight_b);
    all[k + 1] = all[k] + (re * re + im * im) / (weight * weight);
  }
  std::vector<float> weights(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t from = k > kTemplate.coherence_bins ? k - kTemplate.coherence_bins : 0;
    const std::size_t to = std::min(n, k + kTemplate.coherence_bins + 1);
    const double ratio = (common[to] - common[from]) / (all[to] - all[from] + 1e-30);
    weights[k] = static_cast<float>(
        std::clamp((ratio - kTemplate.coherence_of_noise) / (1.0 - kTemplate.coherence_of_noise), 0.0, 1.0));
  }
  return weights;
}

}  // namespace bouncelab::detection
