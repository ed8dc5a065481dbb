// SPDX-License-Identifier: GPL-3.0-or-later
#include "timing/impact_template.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "bouncelab/audio/dsp/kernels.hpp"
#include "bouncelab/core/statistics.hpp"
#include "timing/correlation_peaks.hpp"
#include "timing/subband_jitter.hpp"
#include "timing/subband_noise.hpp"
#include "timing/template_training.hpp"

namespace bouncelab::detection {
namespace {

constexpr std::size_t kMaxShown = 12;  // impacts that `waveform` is the mean of
constexpr int kAlignmentRounds = 2;
constexpr std::size_t kResidualOrder = 32;
constexpr std::size_t kMinSubbands = 3;  // from which their disagreement gives the jitter
constexpr float kOnsetOfPeak = 0.1F;     // a plate's first motion is above, noise and a converter's pre-ringing below

/// What the steps of the estimation pass on.
struct Estimation {
  const audio::AudioSource& sound;
  TemplateWindow window;
  audio::RealFft fourier;
  std::vector<TrainingImpact> training;
  ImpactTemplate learned;
  std::vector<float> mean;  // of the last average, as a function of time
};

std::vector<float> whitening_filter(const audio::ArModel& noise) {
  std::vector<float> filter = noise.filter;
  const auto scale = static_cast<float>(1.0 / std::sqrt(noise.quiet_variance));
  for (float& c : filter) c *= scale;
  return filter;
}

void cut(Estimation& e, std::int64_t first, TrainingImpact& impact) {
  cut_window(e.sound, e.learned.whitener, first, e.fourier, e.window.n_window, impact);
}

void set_template(Estimation& e, TemplateAverage average) {
  e.mean = std::move(average.mean);
  e.learned.filter = MatchedFilter(std::move(average.spectrum), e.window.n_window);
  if (e.learned.subbands.n() == 0) e.learned.subbands = split_into_subbands(e.learned.filter);
}

void average(Estimation& e) { set_template(e, average_of(e.training, e.window, e.fourier)); }

/// Position and amplitude of each training impact by the present template.
/// @param search  anew within a millisecond, not only about the last position
void align(Estimation& e, bool search) {
  const double reach = kRoughTimeError_s * e.sound.rate_hz;
  for (TrainingImpact& impact : e.training) {
    if (search)
      impact.position = find_correlation_peaks(e.learned.filter, impact.spectrum, -reach, reach).front().shift;
    if (std::abs(impact.position) > kRecutDistance_samples) {
      const std::int64_t moved = std::llround(impact.position);
      cut(e, impact.window.first + moved, impact);
      impact.position -= static_cast<double>(moved);
    }
    impact.estimate = estimate_delay(e.learned.filter, e.learned.subbands, impact.spectrum, impact.position);
    impact.position = impact.estimate.shift;
    impact.estimate.amplitude = std::max(impact.estimate.amplitude, 1e-6);
    impact.correlation = correlation(impact.estimate, impact.total);
  }
}

/// @param n_searched  rounds in which positions are searched for; in the others they are refined
void align_and_average(Estimation& e, int n_searched) {
  for (int round = 0; round < kAlignmentRounds; ++round) {
    align(e, round < n_searched);
    average(e);
  }
}

void start_from(Estimation& e, const TrainingImpact& impact) {
  e.learned.subbands = {};
  set_template(e, first_template(impact, e.window, e.fourier));
  align_and_average(e, kAlignmentRounds);
}

/// The template that starts from one impact: the strongest that at least half of the others correlate with. The very
/// strongest may hold a knock, or be of another source altogether.
void find_template(Estimation& e) {
  constexpr std::size_t kMaxStarts = 5;
  std::size_t best_start = 0;
  std::ptrdiff_t most_alike = -1;
  for (std::size_t start = 0; start < std::min(kMaxStarts, e.training.size()); ++start) {
    start_from(e, e.training[start]);
    const std::ptrdiff_t n_alike = std::count_if(e.training.begin(), e.training.end(),
                                                 [](const TrainingImpact& impact) { return impact.is_averaged(); });
    if (2 * n_alike >= std::ssize(e.training)) return;
    if (n_alike > most_alike) most_alike = n_alike, best_start = start;
  }
  start_from(e, e.training[best_start]);
}

/// Extends the whitener by a filter that also whitens what the template does not explain: noise where that is all, the
/// ringing of modes that are excited differently each time where the noise is less than their variation.
void whiten_residuals(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> r(kResidualOrder + 1, 0.0);
  for (const TrainingImpact& impact : e.training) {
    const std::vector<float> placed =
        e.fourier.inverse(audio::phase_shifted(learned.filter.spectrum(), -learned.filter.omega() * impact.position));
    std::vector<float> x = impact.window.sound;
    for (std::size_t n = 0; n < e.window.n_window; ++n)
      x[n] -= static_cast<float>(impact.estimate.amplitude) * placed[n];
    const double energy = audio::dot(x, x) + 1e-30;
    for (std::size_t lag = 0; lag <= kResidualOrder; ++lag) r[lag] += audio::dot(x, std::span(x).subspan(lag)) / energy;
  }
  const std::vector<double> a = audio::prediction_error_filter(r);
  std::vector<float> both(learned.whitener.size() + kResidualOrder, 0.0F);
  for (std::size_t j = 0; j < learned.whitener.size(); ++j)
    for (std::size_t k = 0; k <= kResidualOrder; ++k) both[j + k] += learned.whitener[j] * static_cast<float>(a[k]);
  learned.whitener = std::move(both);
}

/// The template anew after a new whitener, from the windows as they lie.
void refine_template(Estimation& e) {
  for (TrainingImpact& impact : e.training) cut(e, impact.window.first, impact);
  average(e);
  align_and_average(e, 1);  // the new whitener may have resolved what was ambiguous
}

/// One or two sub-bands cannot disagree: half of what neither template nor noise explains is taken for phase variance
/// of each sub-band.
/// @param quiet  sum of squares of a window without impact
void add_unexplained_jitter(Estimation& e, double quiet) {
  std::vector<double> unexplained;  // over what the template explains
  for (const TrainingImpact& impact : e.training) {
    const double explained = 2.0 * impact.estimate.log_likelihood_ratio;
    if (impact.is_averaged()) unexplained.push_back(std::max(0.0, impact.total - explained - quiet) / explained);
  }
  if (unexplained.empty()) return;
  const double phase2 = 0.5 * upper_median(std::move(unexplained));
  const MatchedFilter& filter = e.learned.filter;
  Subbands& subbands = e.learned.subbands;
  for (std::size_t j = 0; j < subbands.n(); ++j)
    subbands.jitter2[j] =
        std::max(subbands.jitter2[j], phase2 * filter.energy(subbands.edge[j], subbands.edge[j + 1]) /
                                          (filter.information(subbands.edge[j], subbands.edge[j + 1]) + 1e-30));
}

void estimate_subbands(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  learned.subbands = split_into_subbands(learned.filter);
  std::vector<std::int64_t> begins;
  for (const TrainingImpact& impact : e.training) begins.push_back(impact.window.first);
  const double quiet = estimate_noise(e.sound, learned.whitener, begins, learned.filter, learned.subbands);
  for (int round = 0; round < 2; ++round) {
    align(e, false);
    std::vector<DelayEstimate> estimates;
    for (const TrainingImpact& impact : e.training)
      if (impact.is_averaged()) estimates.push_back(impact.estimate);
    estimate_jitter(estimates, learned.filter, learned.subbands);
    if (learned.subbands.n() < kMinSubbands) add_unexplained_jitter(e, quiet);
    average(e);
  }
}

/// Start of contact in the window: the first sample above a tenth of the peak.
double onset_index(const std::vector<float>& mean) {
  float peak = 0.0F;
  for (const float x : mean) peak = std::max(peak, std::abs(x));
  const auto first = std::find_if(mean.begin(), mean.end(), [&](float x) { return std::abs(x) > kOnsetOfPeak * peak; });
  return static_cast<double>(first - mean.begin());
}

void describe_training(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  std::vector<double> correlations;
  for (const TrainingImpact& impact : e.training) correlations.push_back(impact.correlation);
  learned.correlation = upper_median(std::move(correlations));
  learned.contact_index = onset_index(e.mean);
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged()) continue;
    ++learned.n_impacts;
    const double begin = static_cast<double>(impact.window.first) + impact.position + learned.contact_index;
    learned.training_t_s.push_back(begin / e.sound.rate_hz);
    learned.training_weight += impact.estimate.amplitude * impact.estimate.amplitude;
  }
}

/// Mean of the training impacts as recorded, and its spread.
void describe_waveform(Estimation& e) {
  ImpactTemplate& learned = e.learned;
  const std::size_t n_window = e.window.n_window;
  std::vector<double> sum(n_window, 0.0);
  std::vector<double> squares(n_window, 0.0);
  std::vector<float> x(n_window);
  double n = 0.0;
  for (const TrainingImpact& impact : e.training) {
    if (!impact.is_averaged() || n >= kMaxShown) continue;
    audio::read_padded(e.sound, impact.window.first, x);
    const audio::Spectrum moved = audio::phase_shifted(e.fourier.forward(x), learned.filter.omega() * impact.position);
    const std::vector<float> y = e.fourier.inverse(moved);
    for (std::size_t k = 0; k < n_window; ++k) {
      const double value = y[k] / impact.estimate.amplitude;
      sum[k] += value;
      squares[k] += value * value;
    }
    n += 1.0;
  }
  learned.waveform.resize(learned.n_template);
  learned.spread.resize(learned.n_template);
  for (std::size_t k = 0; k < learned.n_template; ++k) {
    learned.waveform[k] = sum[k] / n;
    learned.spread[k] = std::sqrt(std::max(0.0, squares[k] / n - learned.waveform[k] * learned.waveform[k]));
    learned.peak = std::max(learned.peak, std::abs(learned.waveform[k]));
  }
}

Estimation begin_estimation(const audio::AudioSource& sound, const audio::ArModel& noise,
                            const std::vector<Candidate>& impacts, const std::vector<bool>& clipped) {
  const TemplateWindow window = template_window(sound, impacts);
  Estimation e{sound, window, audio::RealFft(window.n_window), {}, {}, {}};
  e.learned.whitener = whitening_filter(noise);
  e.learned.n_template = window.n_template;
  for (const std::size_t k : choose_training_impacts(impacts, clipped)) {
    TrainingImpact impact;
    cut(e, window.samples(impacts[k].t_s - kTemplateLead_s), impact);
    e.training.push_back(std::move(impact));
  }
  return e;
}

}  // namespace

std::optional<ImpactTemplate> estimate_template(const audio::AudioSource& sound, const audio::ArModel& noise,
                                                const std::vector<Candidate>& impacts, const std::vector<bool>& clipped,
                                                float clip_level) {
  if (impacts.size() < 3 || !(noise.quiet_variance > 0.0)) return std::nullopt;
  Estimation e = begin_estimation(sound, noise, impacts, clipped);
  find_template(e);
  whiten_residuals(e);
  refine_template(e);
  estimate_subbands(e);
  describe_training(e);
  if (e.learned.n_impacts < 3) return std::nullopt;
  describe_waveform(e);
  // a template of clipped impacts is clipped itself: then samples beyond the limit fit it and must not be left out
  if (has_enough_unclipped(clipped)) e.learned.clip_level = clip_level;
  return std::move(e.learned);
}

bool has_enough_unclipped(const std::vector<bool>& clipped) {
  return std::count(clipped.begin(), clipped.end(), false) >= kMinUnclipped;
}

double correlation(const DelayEstimate& estimate, double total) {
  return std::sqrt(std::min(1.0, 2.0 * estimate.log_likelihood_ratio / (total + 1e-30)));
}

}  // namespace bouncelab::detection
